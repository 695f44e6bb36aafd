// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>

#include <cub/device/device_reduce.cuh>
#include <cub/device/device_scan.cuh>

#include <swiftgs/cuda/check.hpp>
#include <swiftgs/cuda/stages.hpp>

#include "radix_sort.cuh"
#include "state.hpp"

namespace swiftgs {
namespace {

/// Calls a function of CUB twice, for the size of its temporary memory and for its result. CUB takes an error
/// that is left behind by the caller's own calls for one of its kernels.
template <class F>
void run_cub(const char* call, DeviceBuffer<std::byte>& temporary, const F& f) {
  std::size_t bytes = 0;
  cudaGetLastError();
  check_cuda(f(nullptr, bytes), call);
  temporary.reset(bytes);
  check_cuda(f(temporary.data(), bytes), call);
}

struct SumU64 {
  __device__ std::uint64_t operator()(std::uint64_t a, std::uint64_t b) const { return a + b; }
};

}  // namespace

std::uint64_t Cuda::exclusive_scan(Span<std::uint32_t> counts) {
  if (counts.empty()) return 0;
  check_not_captured("exclusive_scan");
  // The last sum and the last count make the total, which may not fit the sums: add the counts up in 64 bits
  // first.
  DeviceBuffer<std::byte>& temporary = state_->temporary;
  state_->total.reset(1);
  const auto n = std::int64_t(counts.size);
  run_cub("cub::DeviceReduce::Reduce", temporary, [&](void* memory, std::size_t& bytes) {
    return cub::DeviceReduce::Reduce(memory, bytes, counts.data, state_->total.data(), n, SumU64(),
                                     std::uint64_t(0), stream());
  });
  run_cub("cub::DeviceScan::ExclusiveSum", temporary, [&](void* memory, std::size_t& bytes) {
    return cub::DeviceScan::ExclusiveSum(memory, bytes, counts.data, counts.data, n, stream());
  });
  std::uint64_t total = 0;
  download(Span<const std::uint64_t>{state_->total.data(), 1}, &total);
  return total;
}

void Cuda::sort_pairs(Pairs<Cuda, std::uint16_t>& pairs, Count n, int bits) {
  kernels::run_radix_sort(*this, pairs, n, bits, state_->sorts);
}
void Cuda::sort_pairs(Pairs<Cuda, std::uint32_t>& pairs, Count n, int bits) {
  kernels::run_radix_sort(*this, pairs, n, bits, state_->sorts);
}
void Cuda::sort_pairs(Pairs<Cuda, std::uint64_t>& pairs, Count n, int bits) {
  kernels::run_radix_sort(*this, pairs, n, bits, state_->sorts);
}

void Cuda::sort_positions(const std::uint32_t* keys, Count n, int bits, Pairs<Cuda, std::uint32_t>& pairs) {
  kernels::check_sort(n);
  pairs.reset(n.most);
  kernels::run_radix_sort<std::uint32_t>(*this, {keys, nullptr}, pairs, n, bits, state_->sorts);
}

}  // namespace swiftgs
