// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include <cuda_runtime_api.h>

#include <swiftgs/cuda/backend.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/error.hpp>

namespace swiftgs {

void* DeviceMemory::allocate(std::size_t bytes) {
  void* memory = nullptr;
  const cudaError_t result = cudaMalloc(&memory, bytes);
  if (result == cudaErrorMemoryAllocation) {
    cudaGetLastError();  // the next call must not see it again
    const MemoryUse use = Cuda::memory_use();
    throw CapacityError("bytes of device memory", bytes, use.total - use.in_use);
  }
  check_cuda(result, "cudaMalloc");
  return memory;
}

void DeviceMemory::release(void* memory) { cudaFree(memory); }

}  // namespace swiftgs
