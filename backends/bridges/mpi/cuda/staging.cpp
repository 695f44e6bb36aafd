// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <limits>

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

FrameReport await_shares(Cuda& cuda, Shares<Cuda>& shares) {
  if (!shares.awaited) return {};
  shares.awaited = false;
  FrameReport report = cuda.await_report();
  if (report.overflowed != 0) return report;
  const std::uint32_t* const posted = shares.posted.data();
  for (std::size_t r = 1; r < shares.begins.size(); ++r) {
    // Sums have 32 bits. The splats for one rank fit, so a sum below the one before has wrapped.
    if (posted[r] < posted[r - 1])
      require_indices("splats for the first strips", (std::uint64_t(1) << 32) + posted[r]);
    shares.begins[r] = posted[r];
  }
  const std::size_t all = std::size_t(shares.begins.back());
  if (all > shares.capacity)
    shares.capacity = std::min<std::size_t>(with_spare(all), std::numeric_limits<std::uint32_t>::max()),
    report.overflowed = 1;
  else
    shares.splats.set_count(all);
  return report;
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
