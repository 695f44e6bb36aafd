// SPDX-License-Identifier: Apache-2.0
#include "device.hpp"

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <cuda_runtime_api.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/error.hpp>

namespace swiftgs::c {
namespace {

/// A plane of the host and its copy on the device, which is dense and runs in the same direction.
class CopiedPlane {
 public:
  CopiedPlane(const void* data, std::ptrdiff_t pitch, std::size_t row, int height)
      : row_(row), height_(std::size_t(height)), pitch_(std::size_t(std::abs(pitch))), up_(pitch < 0) {
    const auto* const top = static_cast<const std::byte*>(data);
    host_ = const_cast<std::byte*>(up_ ? top + std::ptrdiff_t(height_ - 1) * pitch : top);
  }

  std::size_t bytes() const { return (row_ * height_ + 255) / 256 * 256; }
  void place(std::byte* memory) { device_ = memory; }

  /// The top row of the image on the device, and the way down.
  void* top() const { return up_ ? device_ + (height_ - 1) * row_ : device_; }
  std::ptrdiff_t pitch() const { return up_ ? -std::ptrdiff_t(row_) : std::ptrdiff_t(row_); }

  void upload(cudaStream_t stream) const {
    copy(device_, row_, host_, pitch_, cudaMemcpyHostToDevice, stream);
  }
  void download(cudaStream_t stream) const {
    copy(host_, pitch_, device_, row_, cudaMemcpyDeviceToHost, stream);
  }

 private:
  void copy(void* to, std::size_t to_pitch, const void* from, std::size_t from_pitch, cudaMemcpyKind kind,
            cudaStream_t stream) const {
    check_cuda(cudaMemcpy2DAsync(to, to_pitch, from, from_pitch, row_, height_, kind, stream),
               "cudaMemcpy2DAsync");
  }

  std::byte* host_ = nullptr;  ///< lowest address of either
  std::byte* device_ = nullptr;
  std::size_t row_, height_, pitch_;
  bool up_;
};

class CudaFrames final : public HostFrames {
 public:
  explicit CudaFrames(const BackendOptions& options) : stream_(options.stream) {
    if (options.memory) memory_.use(*options.memory);
  }

  void render_into(AnyRenderer& renderer, Span<const View> views, Measures measures) override {
    for (const View& view : views) validate(view);  // before a plane is taken at its word
    renderer.wait();                                // nothing of an earlier frame reads the memory
    planes_.clear(), views_.assign(views.begin(), views.end());
    std::size_t bytes = 0;
    each_plane([&](auto& plane, std::size_t pixel, const FrameView& frame, bool, bool) {
      planes_.emplace_back(plane.data, plane.pitch, pixel * std::size_t(frame.width), frame.height);
      bytes += planes_.back().bytes();
    });
    memory_.reset(bytes);

    std::size_t next = 0, offset = 0;
    bool uploaded = false;
    each_plane([&](auto& plane, std::size_t, const FrameView&, bool is_read, bool) {
      CopiedPlane& copied = planes_[next++];
      copied.place(memory_.data() + offset);
      offset += copied.bytes();
      if (is_read) copied.upload(stream_), uploaded = true;
      plane.data = static_cast<decltype(plane.data)>(copied.top()), plane.pitch = copied.pitch();
    });
    if (uploaded) renderer.wait();  // if the frame throws, nothing reads the caller's memory any more
    renderer.render_into({views_.data(), views_.size()}, measures);
    next = 0;
    each_plane([&](auto&, std::size_t, const FrameView&, bool, bool is_written) {
      if (is_written) planes_[next].download(stream_);
      ++next;
    });
    renderer.wait();
  }
  std::size_t bytes() const override { return memory_.bytes(); }
  void trim() override { memory_.trim(); }

 private:
  /// f(plane, bytes of a pixel, its frame, whether the frame reads it, whether it writes it) for every plane.
  template <class F>
  void each_plane(const F& f) {
    for (View& view : views_) {
      FrameView& frame = view.frame;
      for_each_plane(
          [&](std::size_t, auto& plane, std::size_t pixel, bool is_read) {
            if (plane.data) f(plane, pixel, frame, is_read, true);
          },
          frame, frame.pixel_bytes(), PerPlane<bool>{.colour = frame.over});
      if (frame.occluder.data) f(frame.occluder, sizeof(float), frame, true, false);
    }
  }

  cudaStream_t stream_;
  DeviceBuffer<std::byte> memory_;
  std::vector<CopiedPlane> planes_;
  std::vector<View> views_;
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

std::unique_ptr<HostFrames> make_host_frames(const BackendOptions& options) {
  return std::make_unique<CudaFrames>(options);
}

}  // namespace swiftgs::c
