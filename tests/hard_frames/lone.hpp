// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <swiftgs/edit/rotation.hpp>

#include "hard_frames/case.hpp"

/// @file
/// Lone Gaussians for a search to start from, under cameras and conventions of every kind. Severity: the
/// largest scale over the depth.

namespace swiftgs::stress {

inline dvec3 unit_vector(dvec3 v) { return v / std::sqrt(detail::dot(v, v)); }

/// The shortest turn that takes `from` to `to`, both of length 1.
inline DQuaternion turn_between(dvec3 from, dvec3 to) {
  const dvec3 axis = detail::cross(from, to);
  const double w = 1 + detail::dot(from, to);
  // Opposite vectors have no shortest turn.
  return w > 1e-9 ? unit({w, axis.x, axis.y, axis.z}) : DQuaternion{};
}

/// A quaternion of length 1, in every third case of halves, roots of halves and zeros.
inline DQuaternion any_rotation(Random& random) {
  const Quaternion q = random.rotation();
  DQuaternion out{double(q.w), double(q.x), double(q.y), double(q.z)};
  if (random.below(3) == 0)
    for (double* part : {&out.w, &out.x, &out.y, &out.z}) *part = random.below(3) - 1;
  return out.w == 0 && out.x == 0 && out.y == 0 && out.z == 0 ? DQuaternion{} : unit(out);
}

/// Mostly an ordinary lens; else one of every focal length, uneven ones and far principal points included.
inline Camera any_camera(Random& random, ImageSize size) {
  Camera camera = forward_camera(size, size.width * random.scale(0.3, 10));
  if (random.below(3) == 0) camera.fx = camera.fy = random.scale(5e-4, 1e6);
  if (random.below(3) == 0) camera.fy *= random.below(2) ? random.scale(0.01, 100) : random.in(0.9, 1.1);
  if (random.below(4) == 0) {
    const double right = random.scale(1, 1e5);
    camera.cx += right * (random.below(3) - 1);
    const double down = random.scale(1, 1e5);
    camera.cy += down * (random.below(3) - 1);
  }
  if (random.below(2)) camera.rotation = matrix_of(any_rotation(random));
  return camera;
}

inline Conventions any_conventions(Random& random) {
  Conventions out;
  if (random.below(4) == 0) out = Conventions::inria(), out.footprint = {};
  out.antialiased = random.below(3) == 0;
  const int blur = random.below(6);
  if (blur == 0) out.blur = 0;
  if (blur == 1) out.blur = float(random.scale(1e-9, 1e-1));
  return out;
}

/// A frame of one Gaussian that the camera sees in or near the image. `turned(local, ray)` turns its axes
/// towards the ray from the camera, a vector of camera space; `local` is its longest axis and its thinnest.
template <class Turned>
StressCase lone_case(double ratio, std::uint64_t seed, ImageSize size, const Turned& turned) {
  Random random(seed);
  StressCase out;
  out.camera = any_camera(random, size);
  out.conventions = any_conventions(random);
  const double z = random.scale(0.3, 100), far = random.below(6) ? 0 : random.scale(1, 1e5);
  const double column = random.in(-0.2, 1.2) * size.width, right = far * random.in(-1, 1);
  const double row = random.in(-0.2, 1.2) * size.height, down = far * random.in(-1, 1);
  const double x = column + right - out.camera.cx, y = row + down - out.camera.cy;
  const dvec3 seen(x * z / out.camera.fx, y * z / out.camera.fy, z);

  Gaussian g{.opacity = float(random.scale(0.02, 1)), .rgb = random_colour(random)};
  const int longest = random.below(3), thinnest = (longest + 1 + random.below(2)) % 3;
  const double length = z * ratio * random.scale(0.3, 3);
  for (int k = 0; k < 3; ++k) g.scale[k] = float(length * random.scale(1e-7, 1));
  g.scale[longest] = float(length);
  std::pair<dvec3, dvec3> local{dvec3(0), dvec3(0)};
  local.first[longest] = 1, local.second[thinnest] = 1;
  const DQuaternion seen_rotation = turned(random, g, local, unit_vector(seen));

  // From the camera's space to the world's.
  const dmat3& axes = out.camera.rotation;
  for (int k = 0; k < 3; ++k) g.mean[k] = float(detail::dot(axes[k], seen));
  const DQuaternion to_camera = quaternion_of(axes);
  g.rotation =
      rounded(unit(DQuaternion{to_camera.w, -to_camera.x, -to_camera.y, -to_camera.z} * seen_rotation));
  add(out.scene, g);
  return out;
}

/// `direction`, off by a small angle.
inline dvec3 nearly(Random& random, dvec3 direction) {
  const double angle = random.below(4) ? random.scale(1e-8, 1) : 0;
  const dvec3 off{random.in(-1, 1), random.in(-1, 1), random.in(-1, 1)};
  return unit_vector(direction + off * angle);
}

/// A turn about `axis` by any angle, or none.
inline DQuaternion spin(Random& random, dvec3 axis) {
  const double half = random.below(4) ? random.in(-1.6, 1.6) : 0, s = std::sin(half);
  return {std::cos(half), s * axis.x, s * axis.y, s * axis.z};
}

/// Gaussians whose longest axis points nearly at the camera.
inline StressCase pointing_needles(double ratio, std::uint64_t seed, ImageSize size) {
  return lone_case(ratio, seed, size, [](Random& random, Gaussian&, const auto& local, dvec3 ray) {
    const DQuaternion spun = spin(random, local.first);
    return turn_between(local.first, nearly(random, ray)) * spun;
  });
}

/// Flat Gaussians that the camera sees nearly edge-on.
inline StressCase edge_on_disks(double ratio, std::uint64_t seed, ImageSize size) {
  return lone_case(ratio, seed, size, [](Random& random, Gaussian& g, const auto& local, dvec3 ray) {
    float longest = 0, thinnest = 0;
    for (int k = 0; k < 3; ++k) longest = g.scale[k] > longest ? g.scale[k] : longest;
    const float flatness = float(random.scale(1e-8, 1e-2)), side = float(random.scale(0.01, 1));
    thinnest = longest * flatness;
    for (int k = 0; k < 3; ++k)
      g.scale[k] = local.first[k] != 0 ? longest : local.second[k] != 0 ? thinnest : longest * side;
    const dvec3 across = detail::cross(ray, random.point(-1, 1));
    const DQuaternion spun = spin(random, local.second);
    return turn_between(local.second, nearly(random, unit_vector(across))) * spun;
  });
}

/// Gaussians of any shape, turned anywhere.
inline StressCase any_shapes(double ratio, std::uint64_t seed, ImageSize size) {
  return lone_case(ratio, seed, size,
                   [](Random& random, Gaussian&, const auto&, dvec3) { return any_rotation(random); });
}

/// The families above.
inline const std::vector<StressFamily>& lone_families() {
  static const std::vector<double> ratios{0.1, 1, 8, 100, 1e4, 1e6};
  static const std::vector<StressFamily> families{
      {"pointing-needles", "largest scale over depth", ratios, pointing_needles},
      {"edge-on-disks", "largest scale over depth", ratios, edge_on_disks},
      {"any-shapes", "largest scale over depth", ratios, any_shapes},
  };
  return families;
}

}  // namespace swiftgs::stress
