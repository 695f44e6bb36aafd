// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which Gaussians score highest. `subset` makes a smaller scene of them.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include <swiftgs/edit/select.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// Opacity times the product of the three scales: a score that needs no view. @shape{Gaussians}
inline std::vector<double> opacity_volumes(const Scene& scene) {
  validate(scene);
  std::vector<double> scores(scene.size());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const vec3 s = scene.scales[i];
    scores[i] = double(scene.opacities[i]) * double(s.x) * double(s.y) * double(s.z);
  }
  return scores;
}

/// `fraction` of `count` Gaussians, rounded: at least one if `count` is at least one. Throws
/// `InvalidArgument` unless the fraction is above 0 and at most 1.
inline std::size_t kept_count(double fraction, std::size_t count) {
  if (!(fraction > 0 && fraction <= 1))
    detail::refuse("pruning: expected a fraction above 0 and at most 1, got ", fraction);
  const std::size_t kept = std::size_t(std::llround(fraction * double(count)));
  return count == 0 ? 0 : std::clamp<std::size_t>(kept, 1, count);
}

/// Indices of the `count` highest of `scores`, ascending; of equal scores the lower index comes first. No
/// score may be NaN. Throws `InvalidArgument` where there are fewer scores, and `CapacityError` beyond
/// 2^32 - 1 of them.
template <class Score>
std::vector<std::uint32_t> highest(const std::vector<Score>& scores, std::size_t count) {
  const std::size_t most = std::numeric_limits<std::uint32_t>::max();
  if (scores.size() > most) throw CapacityError("Gaussians", scores.size(), most);
  if (count > scores.size())
    detail::refuse("pruning: expected at most ", scores.size(), " Gaussians to keep, got ", count);
  std::vector<std::uint32_t> order(scores.size());
  std::iota(order.begin(), order.end(), 0u);
  std::nth_element(order.begin(), order.begin() + std::ptrdiff_t(count), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     return scores[a] != scores[b] ? scores[a] > scores[b] : a < b;
                   });
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace swiftgs
