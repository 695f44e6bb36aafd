// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Arrays of the host on a device and back, and what every test of the CUDA backend begins with.

#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

#include <cuda_runtime_api.h>
#include <doctest/doctest.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/arrays_on.hpp"
#include "policies/tile_lists.hpp"
#include "support/skip.hpp"

namespace swiftgs::test {

/// Reports the running test as skipped where no kernel of this build can run.
inline bool without_device() {
  if (Cuda::usable()) return false;
  skip("no CUDA device that the kernels of this build run on");
  return true;
}

/// A stream that does not wait for the default one, unless its flags say so.
class Stream {
 public:
  explicit Stream(unsigned flags = cudaStreamNonBlocking) {
    cudaStream_t made = nullptr;
    check_cuda(cudaStreamCreateWithFlags(&made, flags), "cudaStreamCreateWithFlags");
    stream_.reset(made);
  }
  cudaStream_t get() const { return stream_.get(); }
  void wait() const { check_cuda(cudaStreamSynchronize(get()), "cudaStreamSynchronize"); }

 private:
  struct Destroy {
    void operator()(cudaStream_t stream) const { cudaStreamDestroy(stream); }
  };
  std::unique_ptr<std::remove_pointer_t<cudaStream_t>, Destroy> stream_;
};

/// Free memory of the device when all work is done. @units{bytes}
inline std::size_t free_memory() {
  check_cuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
  std::size_t free = 0, total = 0;
  check_cuda(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  return free;
}

/// Copies within a device, in the order of a stream.
inline void copy_on_device(const void* from, void* to, std::size_t bytes, cudaStream_t stream) {
  check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, stream), "cudaMemcpyAsync");
}

template <>
struct CopyToBackend<Cuda> {
  template <class T>
  static void copy(Span<const T> from, T* to) {
    check_cuda(cudaMemcpy(to, from.data, from.size * sizeof(T), cudaMemcpyHostToDevice), "cudaMemcpy");
    check_cuda(cudaStreamSynchronize(nullptr), "cudaStreamSynchronize");
  }
};

/// Copies to the device; complete when it returns.
template <class T>
void copy_to_device(Span<const T> from, DeviceBuffer<T>& to) {
  to.reset(from.size);
  if (from.size != 0) CopyToBackend<Cuda>::copy(from, to.data());
}
template <class T>
DeviceBuffer<T> to_device(const std::vector<T>& from) {
  DeviceBuffer<T> to;
  copy_to_device(span_of(from), to);
  return to;
}

template <>
struct CopySplats<Cuda> {
  static void copy(const SplatsView& from, Splats<Cuda>& to) {
    const auto array = [](auto span, auto* memory) {
      if (span.size != 0)
        check_cuda(cudaMemcpy(memory, span.data, span.size * sizeof *span.data, cudaMemcpyDeviceToDevice),
                   "cudaMemcpy");
    };
    to.reset(from.size(), 1);
    array(from.shapes, to.shapes.data());
    array(from.depths, to.depths.data());
    array(from.gaussians, to.gaussians.data());
    check_cuda(cudaStreamSynchronize(nullptr), "cudaStreamSynchronize");
    to.count = from.size();
  }
};

}  // namespace swiftgs::test

/// A case that needs a device, or one of each of some types `T`. It is skipped where there is none.
#define SWIFTGS_DEVICE_CASE(sentence) SWIFTGS_DEVICE_CASE_(DOCTEST_ANONYMOUS(swiftgs_device_case_), sentence)
#define SWIFTGS_DEVICE_CASE_(run, sentence)      \
  static void run();                             \
  TEST_CASE(sentence) {                          \
    if (!swiftgs::test::without_device()) run(); \
  }                                              \
  static void run()
#define SWIFTGS_DEVICE_CASES(sentence, T, ...) \
  SWIFTGS_DEVICE_CASES_(DOCTEST_ANONYMOUS(swiftgs_device_case_), sentence, T, __VA_ARGS__)
#define SWIFTGS_DEVICE_CASES_(run, sentence, T, ...) \
  template <class T>                                 \
  static void run();                                 \
  TEST_CASE_TEMPLATE(sentence, T, __VA_ARGS__) {     \
    if (!swiftgs::test::without_device()) run<T>();  \
  }                                                  \
  template <class T>                                 \
  static void run()
