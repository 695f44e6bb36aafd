// SPDX-License-Identifier: Apache-2.0
#include <cuda_runtime_api.h>

#include <swiftgs/cuda/check.hpp>
#include <swiftgs/mpi/cuda.hpp>

namespace swiftgs {

void* PinnedMemory::allocate(std::size_t bytes) {
  void* memory = nullptr;
  check_cuda(cudaMallocHost(&memory, bytes), "cudaMallocHost");
  return memory;
}

void PinnedMemory::release(void* memory) { cudaFreeHost(memory); }

void copy_from_host(Cuda& cuda, const void* from, void* to, std::size_t bytes) {
  if (bytes == 0) return;
  cuda.check_not_captured("copy_from_host");
  check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, cuda.stream()),
             "cudaMemcpyAsync to the device");
}

int take_device(const Ranks& ranks) {
  // Before anything may throw: all ranks take part in it.
  const int rank = ranks.rank_on_machine();
  int devices = 0;
  check_cuda(cudaGetDeviceCount(&devices), "cudaGetDeviceCount");
  if (devices < 1) throw DeviceError("cudaGetDeviceCount", "there is no device, expected one for each rank");
  const int device = rank % devices;
  check_cuda(cudaSetDevice(device), "cudaSetDevice");
  return device;
}

}  // namespace swiftgs
