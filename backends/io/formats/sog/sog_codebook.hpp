// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace swiftgs::io {

/// A number and how often it occurs.
struct Occurrence {
  float value = 0;
  float times = 1;
};

/// What each byte stands for: 256 ascending numbers.
class Codebook {
 public:
  /// At most `most` values, 1 to 256, with nearly the least sum of squared errors of `numbers`. They are
  /// exact if `numbers` has no more different ones. Numbers far from most get an
  /// eighth of the values at most, unless the others need fewer. The last is repeated to fill the table.
  static Codebook of(std::vector<Occurrence> numbers, std::size_t most = 256);

  /// The byte for the nearest number.
  std::uint8_t byte_of(float value) const;

  /// Puts a number smaller than all others at the front. Drops the last, which must be a repeated one.
  void prepend(float value);

  const std::array<float, 256>& values() const { return values_; }

 private:
  void set(const std::vector<double>& ascending);

  std::array<float, 256> values_{};
  std::array<float, 255> bounds_{};  ///< between a number and the next
};

}  // namespace swiftgs::io
