// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace swiftgs::kernels {

inline constexpr unsigned warp_size = 32;
inline constexpr unsigned whole_warp = 0xffffffffu;

__device__ inline unsigned lane_index() { return threadIdx.x % warp_size; }

/// Bits of the lanes below this one.
__device__ inline unsigned lanes_below() { return (1u << lane_index()) - 1; }

/// Sum over all lanes.
__device__ inline std::uint32_t warp_sum(std::uint32_t value) {
  for (unsigned step = warp_size / 2; step > 0; step /= 2) value += __shfl_xor_sync(whole_warp, value, step);
  return value;
}

/// Sum over the lanes below this one.
__device__ inline std::uint32_t sum_below(std::uint32_t value) {
  std::uint32_t sum = value;
  for (unsigned step = 1; step < warp_size; step *= 2) {
    const std::uint32_t below = __shfl_up_sync(whole_warp, sum, step);
    if (lane_index() >= step) sum += below;
  }
  return sum - value;
}

/// The last lane whose `first` is at most `position`, where `first` ascends from 0 with the lanes: the owner
/// of `position` among ranges that begin at `first`.
__device__ inline unsigned owner_of(std::uint32_t position, std::uint32_t first) {
  unsigned owner = 0;
  for (unsigned step = warp_size / 2; step > 0; step /= 2)
    if (__shfl_sync(whole_warp, first, int(owner + step)) <= position) owner += step;
  return owner;
}

/// Room for `count` elements in shared memory, which may not hold types with default values.
template <class T, unsigned count>
struct SharedArray {
  alignas(T) unsigned char bytes[count * sizeof(T)];

  __device__ T* data() { return reinterpret_cast<T*>(bytes); }
};

}  // namespace swiftgs::kernels
