// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// Where most of a scene lies, in the coordinates of its means: relative to its origin.
struct SceneBounds {
  dvec3 low{-1.0}, high{1.0};  ///< box of all but the outermost 2 % to each side along each axis
  dvec3 centre{0.0};           ///< median along each axis
  double radius = 1;           ///< half of the Gaussians are as near to the centre; above 0
};

namespace detail {

/// A Gaussian as bounds and start views see it.
struct SampledGaussian {
  dvec3 mean;
  double size;        ///< longest standard deviation
  double brightness;  ///< 0 to 1
};

/// Solid Gaussians, or all where none is; at most about 40,000, evenly chosen. Those with a NaN or an
/// infinity, which no renderer draws, are left out.
inline std::vector<SampledGaussian> sample_gaussians(const Scene& scene) {
  constexpr std::size_t enough = 20'000;
  std::vector<SampledGaussian> solid, any;
  const std::size_t step = std::max<std::size_t>(1, scene.size() / enough);
  for (std::size_t i = 0; i < scene.size(); i += step) {
    const vec3 &mean = scene.means[i], &scale = scene.scales[i], &sh0 = scene.sh0[i];
    if (!are_finite(&mean.x, 3) || !are_finite(&scale.x, 3) || !are_finite(&sh0.x, 3)) continue;
    const double colour = 0.5 + 0.28209479177387814 * (double(sh0.x) + double(sh0.y) + double(sh0.z)) / 3;
    any.push_back({dvec3(mean), double(std::max({scale.x, scale.y, scale.z})), std::clamp(colour, 0.0, 1.0)});
    if (scene.opacities[i] > 0.3f) solid.push_back(any.back());
  }
  return solid.empty() ? any : solid;
}

/// The value that `part` of `values`, which are not empty, are below.
inline double quantile(std::vector<double>& values, double part) {
  const auto at = values.begin() + std::ptrdiff_t(part * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

inline SceneBounds bounds_of(const std::vector<SampledGaussian>& sample) {
  SceneBounds bounds;
  if (sample.empty()) return bounds;
  constexpr double outside = 0.02;
  std::vector<double> values;
  const auto of_each = [&](const auto& value) -> std::vector<double>& {
    values.clear();
    for (const SampledGaussian& each : sample) values.push_back(value(each));
    return values;
  };
  for (int axis = 0; axis < 3; ++axis) {
    bounds.centre[axis] = quantile(of_each([&](const auto& g) { return g.mean[axis]; }), 0.5);
    bounds.low[axis] = quantile(of_each([&](const auto& g) { return g.mean[axis] - g.size; }), outside);
    bounds.high[axis] = -quantile(of_each([&](const auto& g) { return -g.mean[axis] - g.size; }), outside);
  }
  const double distance = quantile(of_each([&](const auto& g) {
                                     const dvec3 away = g.mean - bounds.centre;
                                     return std::sqrt(dot(away, away));
                                   }),
                                   0.5);
  // One Gaussian has a size as well. Less than the last digits of a position is no radius.
  const double reach = 3 * quantile(of_each([](const auto& g) { return g.size; }), 0.5);
  const dvec3& c = bounds.centre;
  bounds.radius =
      std::max({distance, reach, 1e-6 * std::max({1.0, std::abs(c.x), std::abs(c.y), std::abs(c.z)})});
  return bounds;
}

}  // namespace detail

/// Where most of `scene` lies, whatever strays about it: by its solid Gaussians, or by all where none is
/// solid. A scene without Gaussians has the bounds of a ball of radius 1.
inline SceneBounds robust_bounds(const Scene& scene) {
  return detail::bounds_of(detail::sample_gaussians(scene));
}

}  // namespace swiftgs
