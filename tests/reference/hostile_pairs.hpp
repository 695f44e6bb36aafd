// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include <swiftgs/frame/float_pair.hpp>
#include <swiftgs/tools/split_mix.hpp>

namespace swiftgs::test {

/// Pairs whose bits are what roundings dislike: few ones, few zeros, low parts of half a unit or of 0.
class Hostile {
 public:
  explicit Hostile(std::uint64_t seed) : bits_(seed) {}

  /// Within 2^least and 2^(most + 1), of either sign.
  float number(int least, int most) {
    const int exponent = least + int(bits_.bits() % std::uint64_t(most - least + 1));
    const float sign = bits_.bits() % 2 ? 1.0f : -1.0f;
    return sign * std::ldexp(1 + float(fraction()) * 0x1p-23f, exponent);
  }
  FloatPair pair(int least, int most) {
    const float high = number(least, most);
    switch (bits_.bits() % 4) {
      case 0:
        return {high, 0};
      case 1:
        return fast_two_sum(high, std::ldexp(number(0, 0), std::ilogb(high) - 25));
      default:
        return fast_two_sum(high, std::ldexp(number(-12, 0), std::ilogb(high) - 25));
    }
  }
  int below(int count) { return int(bits_.bits() % std::uint64_t(count)); }

 private:
  std::uint32_t fraction() {
    const auto any = std::uint32_t(bits_.bits()) & 0x7fffffu;
    switch (bits_.bits() % 4) {
      case 0:
        return any & std::uint32_t(bits_.bits()) & std::uint32_t(bits_.bits());
      case 1:
        return any | (std::uint32_t(bits_.bits()) & 0x7fffffu);
      case 2:
        return any >> (bits_.bits() % 24);
      default:
        return any;
    }
  }

  SplitMix64 bits_;
};

}  // namespace swiftgs::test
