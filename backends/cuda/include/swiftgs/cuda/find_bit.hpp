// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include <swiftgs/frame/math.hpp>

namespace swiftgs::kernels {

/// Bits of `word` that are set.
SWIFTGS_HD inline unsigned count_bits(std::uint32_t word) {
#if defined(__CUDA_ARCH__)
  return unsigned(__popc(word));
#else
  return unsigned(std::popcount(word));
#endif
}

/// Position of the n-th lowest bit that is set, from 0.
SWIFTGS_HD inline unsigned find_bit(std::uint64_t mask, unsigned n) {
  unsigned position = 0;
  std::uint32_t word = std::uint32_t(mask);
  if (const unsigned low = count_bits(word); n >= low)
    n -= low, word = std::uint32_t(mask >> 32), position = 32;
  for (unsigned half = 16; half > 0; half /= 2) {
    const unsigned low = count_bits(word & ((1u << half) - 1));
    if (n >= low) n -= low, word >>= half, position += half;
  }
  return position;
}

}  // namespace swiftgs::kernels
