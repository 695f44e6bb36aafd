// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include <swiftgs/contribution.hpp>

#include "policies/backends.hpp"

namespace swiftgs::test {

using Sums = std::vector<std::uint64_t>;

/// Sums of the weights over views, in parts.
template <class B>
Sums sums_of(const Scene& scene, const std::vector<Camera>& cameras, const Conventions& conventions,
             B backend = make_backend<B>()) {
  Contributions<B> contributions(std::make_shared<const Scene>(scene), std::move(backend));
  for (const Camera& camera : cameras) contributions.add(camera, conventions);
  return contributions.sums();
}

/// Weight of all Gaussians together. @units{pixels}
inline double total(const Sums& sums) {
  return std::accumulate(sums.begin(), sums.end(), 0.0,
                         [](double sum, std::uint64_t parts) { return sum + weight_of_parts(parts); });
}

/// Adds a white ball.
inline void append(Scene& scene, vec3 mean, float scale, float opacity) {
  scene.means.push_back(mean), scene.scales.push_back(vec3(scale)), scene.rotations.push_back({});
  scene.opacities.push_back(opacity), scene.sh0.push_back(vec3(1));
}

}  // namespace swiftgs::test
