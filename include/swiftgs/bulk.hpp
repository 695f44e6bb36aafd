// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <swiftgs/math.hpp>

/// @file
/// Where most of many numbers or positions lie, whatever strays about them.

namespace swiftgs::detail {

struct Range {
  double low = 0, high = 0;
};

/// From the least to the greatest of `values`, which are numbers, but for the `outside` outermost to each
/// side; expects more than twice as many. Reorders `values`.
template <class T>
Range trimmed_range(std::vector<T>& values, std::size_t outside) {
  const auto low = values.begin() + std::ptrdiff_t(outside);
  const auto high = values.end() - 1 - std::ptrdiff_t(outside);
  std::nth_element(values.begin(), low, values.end());
  const auto least = double(*low);
  std::nth_element(low, high, values.end());
  return {least, double(*high)};
}

/// How many of `count` values to leave out to each side: more than the thousandth that may stray, as a sample
/// may hold them more often.
inline std::size_t outermost(std::size_t count) { return count / 50; }

/// Positions without strays. A stray lies farther from a box than twice the box's longest side; the box holds
/// all positions but the outermost along each axis. Fewer than 50 positions have no strays, more an eighth at
/// most.
class Bulk {
 public:
  /// `position(k)` is finite for each k below `count`. Takes time linear in `count`.
  template <class Position>
  Bulk(std::size_t count, const Position& position) {
    if (count == 0) return;
    double longest = 0;
    std::vector<float> values(count);
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t k = 0; k < count; ++k) values[k] = position(k)[axis];
      const Range range = trimmed_range(values, outermost(count));
      low_[axis] = range.low, high_[axis] = range.high;
      longest = std::max(longest, range.high - range.low);
    }
    centre_ = 0.5 * (low_ + high_);
    low_ -= 2 * longest, high_ += 2 * longest;
  }

  bool has(const vec3& position) const {
    for (int axis = 0; axis < 3; ++axis)
      if (position[axis] < low_[axis] || position[axis] > high_[axis]) return false;
    return true;
  }

  /// Centre of the box without strays.
  const dvec3& centre() const { return centre_; }
  /// Nothing farther along an axis is part of the bulk.
  const dvec3& low() const { return low_; }
  const dvec3& high() const { return high_; }

 private:
  dvec3 centre_{0.0}, low_{0.0}, high_{0.0};
};

}  // namespace swiftgs::detail
