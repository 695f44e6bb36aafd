// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <swiftgs/reference/projection.hpp>

namespace swiftgs::reference {

/// Trials of one frame: in each, every float of the scene and the stored mean of every splat moves by up to
/// one unit in its last place.
inline constexpr std::size_t trials = 6;

/// Decides, from what it is asked for alone, whether a number moves down, up or not at all in a trial.
class Nudges {
 public:
  explicit Nudges(std::uint64_t seed) : state_(seed) {}

  float nudged(float value) {
    const int step = next();
    if (step == 0 || !std::isfinite(value)) return value;
    const float to =
        step > 0 ? std::numeric_limits<float>::infinity() : -std::numeric_limits<float>::infinity();
    const float moved = std::nextafter(value, to);
    return std::isfinite(moved) ? moved : value;
  }
  vec3 nudged(vec3 v) { return {nudged(v.x), nudged(v.y), nudged(v.z)}; }

  /// -1, 0 or 1.
  int next() {
    // SplitMix64 (Steele, Lea and Flood 2014).
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return int((z ^ (z >> 31)) % 3) - 1;
  }

 private:
  std::uint64_t state_;
};

/// `scene` with every float moved by up to one unit in its last place.
inline Scene nudged(const Scene& scene, std::uint64_t seed) {
  Nudges nudges(seed);
  Scene out = scene;
  for (vec3& v : out.means) v = nudges.nudged(v);
  for (vec3& v : out.scales) v = nudges.nudged(v);
  for (Quaternion& q : out.rotations)
    q = {nudges.nudged(q.w), nudges.nudged(q.x), nudges.nudged(q.y), nudges.nudged(q.z)};
  for (float& v : out.opacities) v = nudges.nudged(v);
  for (vec3& v : out.sh0) v = nudges.nudged(v);
  for (float& v : out.sh_rest) v = nudges.nudged(v);
  return out;
}

/// Distance from |value| to the next float @units{value}
inline double float_ulp(double value) {
  const float magnitude = std::abs(float(value));
  if (!std::isfinite(magnitude)) return 0;
  return double(std::nextafter(magnitude, std::numeric_limits<float>::infinity())) - double(magnitude);
}

/// What a pixel needs of a splat, as the scene has it or as a trial has it.
struct SplatNumbers {
  double x = 0, y = 0, x_weight = 0, y_weight = 0, shear = 0;
  double log2_opacity = 0, depth = 0;
  Eigen::Vector3d colour = Eigen::Vector3d::Zero();

  explicit SplatNumbers(const Splat& s)
      : x(s.x),
        y(s.y),
        x_weight(s.x_weight),
        y_weight(s.y_weight),
        shear(s.shear),
        log2_opacity(std::log2(s.opacity)),
        depth(s.depth),
        colour(s.colour) {}

  /// Half the squared Mahalanobis distance of a point.
  double sigma(double at_x, double at_y) const {
    const double dy = at_y - y, along = at_x - x - shear * dy;
    return 0.5 * (x_weight * along * along + y_weight * dy * dy);
  }
};

/// A splat, and what it is in every trial.
struct VariedSplat {
  Splat splat;
  std::vector<SplatNumbers> numbers;         ///< as it is, then `trials` times
  bool drawn = false;                        ///< its depth lies between the planes
  bool order_is_loose = false;               ///< its depth may round to that of a neighbour
  float least_depth = 0, largest_depth = 0;  ///< floats that its depth may round to
};

/// How far double arithmetic may move the camera-space depth of Gaussian `i`.
inline double depth_error(const Scene& scene, std::size_t i, const View& view) {
  const vec3& m = scene.means[i];
  double sum = std::abs(view.translation.z());
  for (int k = 0; k < 3; ++k)
    sum += std::abs(view.rotation(2, k)) * (std::abs(double(m[k])) + std::abs(view.centre[k]));
  return std::ldexp(sum, -49);
}

/// Projects Gaussian `i` of `scene`, and of the trials `moved`. Nothing where no rounding could draw it.
inline std::optional<VariedSplat> project_varied(const Scene& scene, const std::vector<Scene>& moved,
                                                 std::size_t i, const View& view, std::uint64_t seed) {
  const Eigen::Vector3d p = camera_space_mean(scene, i, view);
  const Conventions& k = view.conventions;
  const double slack = depth_error(scene, i, view);
  const float low = float(p.z() - slack), high = float(p.z() + slack);
  const auto between_planes = [&](float z) { return is_between_planes(z, k); };
  const bool drawn = between_planes(float(p.z()));
  if (!drawn && !between_planes(low) && !between_planes(high)) return {};
  std::optional<Splat> splat = project_unculled(scene, i, p, view);
  if (!splat || !shade(*splat, scene, view)) return {};
  VariedSplat out{.splat = *splat, .numbers = {}};
  out.drawn = drawn;
  out.least_depth = low, out.largest_depth = high;

  Nudges nudges(seed ^ (i * 0x2545f4914f6cdd1du));
  out.numbers.emplace_back(*splat);
  for (const Scene& trial : moved) {
    // A trial in which the splat cannot be drawn at all tells nothing of how far it moves.
    std::optional<Splat> there = project_unculled(trial, i, camera_space_mean(trial, i, view), view);
    if (!there || !shade(*there, trial, view)) there = splat;
    SplatNumbers& numbers = out.numbers.emplace_back(*there);
    numbers.x += nudges.next() * float_ulp(numbers.x);
    numbers.y += nudges.next() * float_ulp(numbers.y);
  }
  return out;
}

}  // namespace swiftgs::reference
