// SPDX-License-Identifier: Apache-2.0
#include "device.hpp"

#include <cstddef>
#include <memory>
#include <string>

#include <cuda_runtime_api.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/error.hpp>

#include "device_frames.hpp"

namespace swiftgs::c {
namespace {

/// Copies in the order of a stream.
class CudaCopies {
 public:
  template <class T>
  using Buffer = DeviceBuffer<T>;

  explicit CudaCopies(const BackendOptions& options) : stream_(options.stream) {}

  void upload(const CopiedPlane& plane) {
    copy(plane.device, plane.row, plane.host, plane.pitch, plane, cudaMemcpyHostToDevice);
  }
  void download(const CopiedPlane& plane) {
    copy(plane.host, plane.pitch, plane.device, plane.row, plane, cudaMemcpyDeviceToHost);
  }

 private:
  void copy(void* to, std::size_t to_pitch, const void* from, std::size_t from_pitch,
            const CopiedPlane& plane, cudaMemcpyKind kind) const {
    check_cuda(cudaMemcpy2DAsync(to, to_pitch, from, from_pitch, plane.row, plane.height, kind, stream_),
               "cudaMemcpy2DAsync");
  }

  cudaStream_t stream_;
};

}  // namespace

void require_device(const char* what) {
  if (!Cuda::usable()) throw Unavailable(std::string(what) + ", but there is none that this build can use");
}

int current_device() {
  int device = 0;
  check_cuda(cudaGetDevice(&device), "cudaGetDevice");
  return device;
}

void* allocate_memory(std::size_t bytes) { return DeviceMemory::allocate(bytes); }
void free_memory(void* memory) { DeviceMemory::release(memory); }

void copy_memory(void* to, const void* from, std::size_t bytes, void* stream) {
  const auto in = static_cast<cudaStream_t>(stream);
  check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDefault, in), "cudaMemcpyAsync");
  check_cuda(cudaStreamSynchronize(in), "cudaStreamSynchronize");
}

void order_streams(void* before, void* after) {
  if (before == after) return;
  // An event from outside would break the capture.
  for (void* const stream : {before, after}) {
    cudaStreamCaptureStatus status = cudaStreamCaptureStatusNone;
    const cudaError_t asked = cudaStreamIsCapturing(static_cast<cudaStream_t>(stream), &status);
    cudaGetLastError();
    if (asked != cudaSuccess || status != cudaStreamCaptureStatusNone)
      throw DeviceError("order", "a stream is being captured into a CUDA graph, expected one that is not");
  }
  cudaEvent_t made = nullptr;
  check_cuda(cudaEventCreateWithFlags(&made, cudaEventDisableTiming), "cudaEventCreateWithFlags");
  const auto destroy = [](cudaEvent_t event) { cudaEventDestroy(event); };
  const std::unique_ptr<CUevent_st, decltype(destroy)> event(made, destroy);
  check_cuda(cudaEventRecord(made, static_cast<cudaStream_t>(before)), "cudaEventRecord");
  check_cuda(cudaStreamWaitEvent(static_cast<cudaStream_t>(after), made), "cudaStreamWaitEvent");
}

std::unique_ptr<HostFrames> make_cuda_frames(const BackendOptions& options) {
  return std::make_unique<DeviceFrames<CudaCopies>>(options);
}

}  // namespace swiftgs::c
