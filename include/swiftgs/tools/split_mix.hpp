// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace swiftgs {

/// Random bits that depend on the seed alone, on every machine (SplitMix64; Steele, Lea and Flood 2014).
class SplitMix64 {
 public:
  /// Difference of consecutive states: 2^64 over the golden ratio, an odd number.
  static constexpr std::uint64_t step = 0x9e3779b97f4a7c15u;

  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() { return scrambled(state_ += step); }
  /// In [0, 1).
  double uniform() { return double(bits() >> 11) * 0x1p-53; }

  /// Maps a state to its output, one to one.
  static std::uint64_t scrambled(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

 private:
  std::uint64_t state_;
};

}  // namespace swiftgs
