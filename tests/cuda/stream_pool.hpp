// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A memory hook that works in the order of a stream.

#include <cstddef>
#include <cstdint>
#include <limits>

#include <cuda_runtime_api.h>

#include <swiftgs/cuda/check.hpp>

#include "policies/counted_memory.hpp"

namespace swiftgs::test {

/// A pool of memory that works in the order of a stream. The stream outlives it. It fills memory with
/// garbage, in that order, when it hands it out and when it takes it back.
class StreamPool : public CountedBlocks {
 public:
  explicit StreamPool(cudaStream_t stream) : stream_(stream) {
    int device = 0;
    check_cuda(cudaGetDevice(&device), "cudaGetDevice");
    cudaMemPoolProps properties{};
    properties.allocType = cudaMemAllocationTypePinned;
    properties.location = {cudaMemLocationTypeDevice, device};
    check_cuda(cudaMemPoolCreate(&pool_, &properties), "cudaMemPoolCreate");
    std::uint64_t keep = std::numeric_limits<std::uint64_t>::max();
    check_cuda(cudaMemPoolSetAttribute(pool_, cudaMemPoolAttrReleaseThreshold, &keep),
               "cudaMemPoolSetAttribute");
  }
  ~StreamPool() {
    cudaStreamSynchronize(stream_);
    cudaMemPoolDestroy(pool_);
  }

  MemoryHook hook() { return {&StreamPool::allocate, &StreamPool::release, this}; }

 private:
  static void* allocate(void* context, std::size_t bytes) {
    auto& self = *static_cast<StreamPool*>(context);
    if (self.refuses(bytes)) return nullptr;
    void* memory = nullptr;
    if (cudaMallocFromPoolAsync(&memory, bytes, self.pool_, self.stream_) != cudaSuccess) {
      cudaGetLastError();
      return nullptr;
    }
    check_cuda(cudaMemsetAsync(memory, 0xa5, bytes, self.stream_), "cudaMemsetAsync");
    self.add(memory, bytes);
    return memory;
  }
  static void release(void* context, void* memory, std::size_t bytes) {
    auto& self = *static_cast<StreamPool*>(context);
    self.remove(memory, bytes);
    cudaMemsetAsync(memory, 0x5a, bytes, self.stream_);
    cudaFreeAsync(memory, self.stream_);
  }

  cudaStream_t stream_;
  cudaMemPool_t pool_ = nullptr;
};

}  // namespace swiftgs::test
