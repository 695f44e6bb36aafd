// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Origins of scenes that lie far from zero, by where most positions lie, whatever strays about them.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/scene.hpp>

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

namespace swiftgs {

/// Decides from positions in the world whether a scene needs an origin, and which. It needs one if rounding
/// positions to float moves one of them by more than a four-millionth of the scene's size, which takes a
/// scene at least twice as far from zero as it is large. The origin is then the middle of the positions, in
/// whole units; in a scene smaller than 1, in whole powers of two below its size. So the difference of a
/// position and the origin is exact in double, and float holds it as finely as the scene's size allows. Along
/// each axis the outermost positions have no say, one in fifty to each side, but one at least of five or
/// more: strays neither make a scene large nor its positions coarse. Nor do the largest scales, one in fifty.
class OriginChoice {
 public:
  /// Calls f(i) for indices below `count`, evenly chosen, of as many Gaussians as suffice.
  template <class F>
  static void for_each_sample(std::size_t count, const F& f) {
    constexpr std::size_t enough = 4096;
    const std::size_t samples = std::min(count, enough);
    for (std::size_t k = 0; k < samples; ++k) f(count / samples * k + count % samples * k / samples);
  }

  /// Takes a Gaussian into account, unless a float cannot hold its numbers at all. `scale` is its largest.
  void add(const dvec3& position, float scale) {
    if (!detail::is_finite(vec3(position)) || !detail::is_finite(scale)) return;
    positions_.push_back(position);
    scales_.push_back(scale);
  }

  dvec3 origin() const {
    constexpr double seen = 0x1p-22;
    if (positions_.empty()) return dvec3(0.0);
    const std::size_t count = positions_.size();
    const std::size_t outside = count < 5 ? 0 : std::max<std::size_t>(1, detail::outermost(count));
    std::vector<double> values(scales_.begin(), scales_.end());
    double size = std::max(0.0, detail::trimmed_range(values, outside).high);
    dvec3 middle, rounding(0.0);
    for (int axis = 0; axis < 3; ++axis) {
      std::transform(positions_.begin(), positions_.end(), values.begin(),
                     [&](const dvec3& position) { return position[axis]; });
      const detail::Range range = detail::trimmed_range(values, outside);
      size = std::max(size, range.high - range.low);
      for (const double value : values)
        if (value >= range.low && value <= range.high)
          rounding[axis] = std::max(rounding[axis], std::abs(value - double(float(value))));
      const auto half = values.begin() + std::ptrdiff_t(count / 2);
      std::nth_element(values.begin(), half, values.end());
      middle[axis] = *half;
    }
    if (!(glm::length(rounding) > seen * size)) return dvec3(0.0);
    const double unit = size < 1 ? std::exp2(std::floor(std::log2(size))) : 1;
    return unit > 0 ? glm::round(middle / unit) * unit : middle;
  }

 private:
  std::vector<dvec3> positions_{};
  std::vector<float> scales_{};
};

/// The same Gaussians with means relative to another origin: moved in double, rounded once. Linear in their
/// number. Throws `InvalidArgument` as `validate` does of the scene before and after.
inline Scene with_origin(Scene scene, const dvec3& origin) {
  validate(scene);
  if (scene.origin == origin) return scene;
  for (vec3& mean : scene.means) mean = vec3(scene.origin - origin + dvec3(mean));
  scene.origin = origin;
  validate(scene);
  return scene;
}

}  // namespace swiftgs
