// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Generated scenes for the comparison with the oracle. `oracle_camera` sees all of them.

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "policies/random_splats.hpp"

namespace swiftgs::test {

/// At the world's origin, looking along +z, with different focal lengths and an odd principal point.
inline Camera oracle_camera() {
  Camera camera;
  camera.fx = 31, camera.fy = 34.5, camera.cx = 19.3, camera.cy = 22.1;
  camera.width = 53, camera.height = 37;
  return camera;
}

/// Gaussians of many sizes in front of the camera and a few behind it; harmonics up to `largest` in size.
inline Scene mixture(Random& random, std::size_t count, int degree = 0, double largest = 3) {
  Scene scene;
  scene.sh_degree = degree;
  for (std::size_t i = 0; i < count; ++i) {
    const double size = random.scale(0.02, 0.6);
    scene.means.push_back({random.f(-2, 2), random.f(-2, 2), random.f(-0.5, 4)});
    scene.scales.push_back(
        vec3{float(size), float(size * random.scale(0.01, 1)), float(size * random.scale(0.01, 1))});
    scene.rotations.push_back(random_rotation(random));
    scene.opacities.push_back(random.f(0, 1));
    const auto harmonic = [&] { return random.f(-largest, largest); };
    scene.sh0.push_back({harmonic(), harmonic(), harmonic()});
    for (int k = 0; k < 3 * sh_rest_count(degree); ++k) scene.sh_rest.push_back(harmonic());
  }
  return scene;
}

/// Lines and discs up to 1e8 times as long as thick.
inline Scene needles_and_pancakes(Random& random, std::size_t count, int degree = 0) {
  Scene scene = mixture(random, count, degree);
  for (std::size_t i = 0; i < count; ++i) {
    const float length = float(random.scale(0.1, 100)), width = length * float(random.scale(1e-8, 1e-2));
    scene.scales[i] = i % 2 ? vec3(width, length, width) : vec3(length, width, length);
    scene.means[i].z = std::abs(scene.means[i].z) + 0.5f;
    scene.opacities[i] *= 0.3f;  // so that those behind are seen too
  }
  return scene;
}

/// Large Gaussians whose means lie up to a thousand images beside the image.
inline Scene far_off_screen(Random& random, std::size_t count) {
  Scene scene = mixture(random, count);
  for (std::size_t i = 0; i < count; ++i) {
    const float z = random.f(0.5, 4), away = float(random.scale(2, 2000)) * z;
    const double angle = random.in(0, 6.2831853);
    scene.means[i] = {away * float(std::cos(angle)), away * float(std::sin(angle)), z};
    scene.scales[i] = vec3{away, away * random.f(0.01, 1), away * random.f(0.01, 1)};
    scene.scales[i] *= random.f(0.3, 2);
    scene.opacities[i] *= 0.5f;
  }
  return scene;
}

/// Dots at the planes of `k` and 1, 2 and 4 floats to each side of them.
inline Scene at_planes(Random& random, const Conventions& k) {
  const float planes[] = {k.near_plane, std::min(k.far_plane, 1e10f)};
  Scene scene = mixture(random, 18 * 4);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    float z = planes[i % 2];
    const int steps[] = {0, 1, 2, 4, -1, -2, -4, 3, -3};
    const int step = steps[i / 2 % 9];
    for (int s = 0; s < std::abs(step); ++s) z = std::nextafter(z, step > 0 ? INFINITY : 0.0f);
    scene.means[i] = {random.f(-0.5, 0.5) * z, random.f(-0.5, 0.5) * z, z};
    scene.scales[i] = vec3{random.f(0.02, 0.1), random.f(0.02, 0.1), random.f(0.02, 0.1)} * z;
  }
  return scene;
}

/// Gaussians of only five different depths.
inline Scene equal_depths(Random& random, std::size_t count) {
  Scene scene = mixture(random, count);
  for (std::size_t i = 0; i < count; ++i) scene.means[i].z = 1.5f + 0.25f * float(i * 7 % 5);
  return scene;
}

/// Faint Gaussians behind each other, so that pixels blend hundreds.
inline Scene deep_stack(Random& random, std::size_t count) {
  Scene scene = mixture(random, count, 1);
  for (std::size_t i = 0; i < count; ++i) {
    scene.means[i] = {random.f(-0.3, 0.3), random.f(-0.3, 0.3), random.f(1, 30)};
    scene.scales[i] = vec3{random.f(0.2, 1), random.f(0.2, 1), random.f(0.2, 1)} * scene.means[i].z;
    scene.opacities[i] = random.f(0.004, 0.02);
  }
  return scene;
}

/// All numbers that belong to rotations with five digits.
inline void keep_five_digits(Scene& scene) {
  const auto cut = [](float& v) { v = std::round(1e5f * v) / 1e5f; };
  for (Quaternion& q : scene.rotations) cut(q.w), cut(q.x), cut(q.y), cut(q.z);
}
inline void keep_five_digits(Camera& camera) {
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row)
      camera.rotation[column][row] = std::round(1e5 * camera.rotation[column][row]) / 1e5;
}

/// The camera as a mirror shows it: x runs the other way, and the rotation has a determinant of -1.
inline void mirror(Camera& camera) {
  for (int column = 0; column < 3; ++column) camera.rotation[column][0] *= -1;
  camera.translation.x *= -1;
}

/// `scene` and `camera` times `factor`, then moved by `offset`; means round to the floats that are there.
inline void move_world(Scene& scene, Camera& camera, double factor, dvec3 offset) {
  for (vec3& mean : scene.means)
    for (int k = 0; k < 3; ++k) mean[k] = float(factor * double(mean[k]) + offset[k]);
  for (vec3& scale : scene.scales) scale *= float(factor);
  camera.translation = factor * camera.translation - camera.rotation * offset;
}

}  // namespace swiftgs::test
