// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Small scenes for the tests of the reference, and readers of its frames.

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <swiftgs/reference.hpp>

namespace swiftgs::test {

inline constexpr double sh_c0 = 0.28209479177387814;

/// One Gaussian to be; white, round and in front of `small_camera` unless told otherwise.
struct Gaussian {
  vec3 mean{0, 0, 2};
  vec3 scale{0.1f, 0.1f, 0.1f};
  Quaternion rotation{};
  float opacity = 0.5f;
  vec3 sh0{0.5f / float(sh_c0)};
};

/// A scene of degree 0.
template <class... Gaussians>
Scene scene_of(const Gaussians&... gaussians) {
  Scene scene;
  const auto add = [&](const Gaussian& g) {
    scene.means.push_back(g.mean);
    scene.scales.push_back(g.scale);
    scene.rotations.push_back(g.rotation);
    scene.opacities.push_back(g.opacity);
    scene.sh0.push_back(g.sh0);
  };
  (add(gaussians), ...);
  return scene;
}

/// At the world's origin, looking along +z; with an odd size the axis meets the centre of the middle pixel.
inline Camera small_camera(int width = 33, int height = 33, double focal = 40) {
  Camera camera;
  camera.fx = camera.fy = focal;
  camera.cx = 0.5 * width, camera.cy = 0.5 * height;
  camera.width = width, camera.height = height;
  return camera;
}

/// `scene` as `small_camera` sees it.
inline ReferenceFrame draw(const Scene& scene, const Conventions& conventions = Conventions::gsplat(),
                           dvec3 background = dvec3(0)) {
  return render_reference(scene, small_camera(), conventions, background);
}

inline std::size_t at(const ReferenceFrame& frame, int x, int y) {
  return std::size_t(y) * std::size_t(frame.width) + std::size_t(x);
}

inline double alpha_at(const ReferenceFrame& frame, int x, int y) { return frame.alpha[at(frame, x, y)]; }

/// Largest |value(x, y) - expected(x, y)| over the image, where `value` is alpha.
template <class Expected>
double worst_alpha(const ReferenceFrame& frame, const Expected& expected) {
  double worst = 0;
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x)
      worst = std::max(worst, std::abs(alpha_at(frame, x, y) - expected(x, y)));
  return worst;
}

/// `alpha` where the conventions blend it, 0 where they skip it.
inline double unless_skipped(double alpha, const Conventions& k = {}) {
  return alpha < double(k.alpha_min) ? 0 : std::min(alpha, double(k.alpha_max));
}

}  // namespace swiftgs::test
