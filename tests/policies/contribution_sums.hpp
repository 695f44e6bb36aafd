// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include <swiftgs/contribution.hpp>

#include "policies/backends.hpp"
#include "policies/random_splats.hpp"

namespace swiftgs::test {

using Sums = std::vector<std::uint64_t>;

/// Sums of the weights over views, in parts.
template <class B>
Sums sums_of(const Scene& scene, const std::vector<Camera>& cameras,
             const Conventions& conventions = Conventions::gsplat(), B backend = test::make_backend<B>()) {
  Contributions<B> contributions(std::make_shared<const Scene>(scene), std::move(backend));
  for (const Camera& camera : cameras) contributions.add(camera, conventions);
  return contributions.sums();
}

/// Weight of all Gaussians together. @units{pixels}
inline double total(const Sums& sums) {
  return std::accumulate(sums.begin(), sums.end(), 0.0,
                         [](double sum, std::uint64_t parts) { return sum + weight_of_parts(parts); });
}

/// Whether sums of two backends differ by the rounding of their projections alone: a pixel at the threshold
/// of alpha keeps 1/255 more or less.
inline bool close(const Sums& a, const Sums& b) {
  bool same = a.size() == b.size();
  for (std::size_t i = 0; same && i < a.size(); ++i) {
    const double x = weight_of_parts(a[i]), y = weight_of_parts(b[i]);
    same = std::abs(x - y) <= 1e-4 * y + 1.0 / 255;
  }
  return same && std::abs(total(a) - total(b)) <= 1e-5 * total(b);
}

/// A scene of which a tenth is in front of the others, large, and of a colour that is not finite: of SH
/// coefficients that are, but add up to more than the largest float.
inline Scene scene_with_colourless(std::size_t count, std::uint64_t seed) {
  Scene scene = random_scene(count, 3, seed);
  for (std::size_t i = 0; i < count; i += 10) {
    scene.means[i] = vec3(0.01f * float(i % 7), 0, 1), scene.scales[i] = vec3(0.3f),
    scene.opacities[i] = 0.9f;
    for (int k = 0; k < sh_rest_count(3); ++k)  // those that are not 0 along the axis
      for (std::size_t c = 0; c < 3; ++c)
        scene.sh_rest[i * 45 + 3 * std::size_t(k) + c] = k == 1 || k == 5 || k == 11 ? 3e38f : 0;
  }
  return scene;
}

}  // namespace swiftgs::test
