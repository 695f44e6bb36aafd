// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include <cub/device/device_reduce.cuh>
#include <cub/device/device_scan.cuh>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/cuda/launch.cuh>

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

template <class Key>
void Cuda::radix_sort(Pairs<Cuda, Key>& pairs, std::size_t n, int bits) {
  if (n == 0 || bits == 0) return;
  check_not_captured("sort_pairs");
  const std::size_t most = std::numeric_limits<std::uint32_t>::max();
  if (n > most) throw CapacityError("pairs in one sort", n, most);
  const kernels::Digits passes{unsigned(bits)};
  const unsigned tiles = blocks_for(n, kernels::radix_tile<Key>);
  RadixCounts* const both = state_->digit_counts.begin(*this);
  RadixCounts* const counts = both + state_->sorts % 2;
  RadixCounts* const next_counts = both + (state_->sorts + 1) % 2;
  ++state_->sorts;
  launch("radix_histogram", kernels::radix_histogram<Key>, kernels::histogram_blocks(n),
         kernels::histogram_threads, stream(), pairs.keys.data(), std::uint32_t(n), passes, counts,
         next_counts);
  for (unsigned p = 0; p < passes.count; ++p) {
    launch("radix_pass", kernels::radix_pass<Key>, tiles, kernels::radix_threads, stream(), pairs.keys.data(),
           pairs.values.data(), pairs.spare_keys.data(), pairs.spare_values.data(), std::uint32_t(n),
           passes.digit(p), counts->of_pass[p], state_->digit_sums.next(*this, kernels::radix_states(tiles)));
    std::swap(pairs.keys, pairs.spare_keys), std::swap(pairs.values, pairs.spare_values);
  }
  state_->digit_counts.end();
}

void Cuda::sort_pairs(Pairs<Cuda, std::uint16_t>& pairs, std::size_t n, int bits) {
  radix_sort(pairs, n, bits);
}
void Cuda::sort_pairs(Pairs<Cuda, std::uint32_t>& pairs, std::size_t n, int bits) {
  radix_sort(pairs, n, bits);
}
void Cuda::sort_pairs(Pairs<Cuda, std::uint64_t>& pairs, std::size_t n, int bits) {
  radix_sort(pairs, n, bits);
}

}  // namespace swiftgs
