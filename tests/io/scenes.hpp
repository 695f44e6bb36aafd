// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <random>

#include <swiftgs/scene.hpp>

namespace swiftgs::test {

/// A scene of arbitrary legal Gaussians, the same every time.
inline Scene some_scene(std::size_t count, int sh_degree) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(-1, 1);
  Scene scene;
  scene.sh_degree = sh_degree;
  for (std::size_t i = 0; i < count; ++i) {
    const auto three = [&] { return vec3(value(random), value(random), value(random)); };
    scene.means.push_back(5.0f * three());
    const vec3 log_scale = 3.0f * three();
    scene.scales.emplace_back(std::exp(log_scale.x), std::exp(log_scale.y), std::exp(log_scale.z));
    const vec4 q(value(random), three());
    const float length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    scene.rotations.push_back({q.x / length, q.y / length, q.z / length, q.w / length});
    scene.opacities.push_back(0.5f + 0.49f * value(random));
    scene.sh0.push_back(three());
    for (int k = 0; k < 3 * sh_rest_count(sh_degree); ++k) scene.sh_rest.push_back(0.9f * value(random));
  }
  return scene;
}

/// Upper triangle of R diag(s^2) R^T of Gaussian `i`: xx, xy, xz, yy, yz, zz.
inline std::array<double, 6> covariance(const Scene& scene, std::size_t i) {
  const auto [qw, qx, qy, qz] = scene.rotations[i];
  const double w = qw, x = qx, y = qy, z = qz;
  const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                          {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                          {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  std::array<double, 6> result{};
  int entry = 0;
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b, ++entry)
      for (int k = 0; k < 3; ++k)
        result[entry] += r[a][k] * r[b][k] * std::pow(double(scene.scales[i][k]), 2);
  return result;
}

}  // namespace swiftgs::test
