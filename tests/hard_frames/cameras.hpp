// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "hard_frames/case.hpp"

/// @file
/// Families of hard cameras.

namespace swiftgs::stress {

/// Gaussians some pixels large wherever `camera`, at the origin, shows them.
inline void add_in_view_of(Scene& scene, const Camera& camera, Random& random, int count) {
  for (int i = 0; i < count; ++i) {
    const double z = random.in(2, 10), pixel_x = z / camera.fx, pixel_y = z / camera.fy;
    const auto side = [&] { return float(std::sqrt(pixel_x * pixel_y) * random.scale(0.5, 12)); };
    add(scene, {.mean = {float((random.in(-0.1, 1.1) * camera.width - camera.cx) * pixel_x),
                         float((random.in(-0.1, 1.1) * camera.height - camera.cy) * pixel_y), float(z)},
                .scale = {side(), side(), side()},
                .rotation = random.rotation(),
                .opacity = float(random.scale(0.02, 1)),
                .rgb = random_colour(random)});
  }
}

/// Gaussians in view of a camera of focal length `focal`, once `change` has made the case hard.
template <class Change>
StressCase lens_case(std::uint64_t seed, ImageSize size, double focal, const Change& change) {
  Random random(seed);
  StressCase out;
  out.camera = forward_camera(size, focal);
  change(out);
  add_in_view_of(out.scene, out.camera, random, 60);
  return out;
}

/// Short focal lengths; severity: the inverse of the focal length. @units{1/pixels}
inline StressCase wide_angles(double inverse, std::uint64_t seed, ImageSize size) {
  return lens_case(seed, size, 1 / inverse, [=](StressCase& out) {
    if (seed % 2) out.conventions = Conventions::inria(), out.conventions.footprint = {};
  });
}

/// Long focal lengths. @units{pixels}
inline StressCase long_lenses(double focal, std::uint64_t seed, ImageSize size) {
  return lens_case(seed, size, focal, [](StressCase&) {});
}

/// Principal points far from the image; severity: how far. @units{pixels}
inline StressCase principal_points(double distance, std::uint64_t seed, ImageSize size) {
  return lens_case(seed, size, usual_focal(size), [=](StressCase& out) {
    out.camera.cx += seed % 2 ? distance : -0.3 * distance;
    out.camera.cy += seed % 3 ? -distance : 0.1 * distance;
    if (seed % 5 == 0) out.camera.cx = -distance, out.camera.cy = 0.5 * size.height;
  });
}

/// Focal lengths that differ; severity: their ratio.
inline StressCase uneven_focals(double ratio, std::uint64_t seed, ImageSize size) {
  return lens_case(seed, size, usual_focal(size),
                   [=](StressCase& out) { (seed % 2 ? out.camera.fx : out.camera.fy) *= ratio; });
}

/// A usual scene and its camera, both turned and moved: `rotation` and `distance` from the world's origin.
inline StressCase moved_case(Random& random, ImageSize size, double distance) {
  StressCase out = usual_case(random, size, 60, 3);
  const dvec3 offset = distant_point(random, distance);
  for (vec3& mean : out.scene.means)
    for (int k = 0; k < 3; ++k) mean[k] = float(double(mean[k]) + offset[k]);
  out.camera.translation = -offset;
  return out;
}

/// A world far from its origin, the camera there too; severity: how far.
inline StressCase world_offsets(double distance, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = moved_case(random, size, distance);
  // Floats step by the distance's last place there: a world of steps' size shows nothing.
  const float step = float(std::fmax(1.0, distance * 0x1p-16));
  for (std::size_t i = 0; i < out.scene.size(); ++i) {
    vec3& mean = out.scene.means[i];
    for (int k = 0; k < 3; ++k)
      mean[k] =
          float(double(step) * (double(mean[k]) + out.camera.translation[k]) - out.camera.translation[k]);
    out.scene.scales[i] *= step;
  }
  return out;
}

/// A world around its origin and a camera far from it, every second one beside its axis; severity: how far.
/// Floats hold the means exactly to many more digits than their places seen from the camera.
inline StressCase distant_cameras(double distance, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out;
  out.scene.sh_degree = 2;
  const double pixel = 2.0 / size.width;  // of the world
  out.camera = forward_camera(size, distance / pixel);
  out.camera.translation.z = distance;
  if (seed % 2) {
    const double x = distance * random.in(-1, 1), y = distance * random.in(-1, 1);
    out.camera.translation.x = x, out.camera.cx -= x / pixel;
    out.camera.translation.y = y, out.camera.cy -= y / pixel;
  }
  for (int i = 0; i < 60; ++i) {
    const auto side = [&] { return float(pixel * random.scale(0.3, 12)); };
    add(out.scene, {.mean = {random.f(-1, 1), random.f(-1, 1), random.f(-1, 1)},
                    .scale = {side(), side(), side()},
                    .rotation = random.rotation(),
                    .opacity = float(random.scale(0.02, 1)),
                    .rgb = random_colour(random)});
  }
  for (float& v : out.scene.sh_rest) v = random.f(-0.1, 0.1);
  return out;
}

/// Rotations that are not orthonormal; severity: by how much. Every third is a mirror.
inline StressCase skewed_rotations(double skew, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = usual_case(random, size, 60, 3);
  turn(out, random.in(-3, 3));
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) out.camera.rotation[column][row] += random.in(-skew, skew);
  if (seed % 3 == 0)
    for (int column = 0; column < 3; ++column) out.camera.rotation[column].x *= -1;
  return out;
}

}  // namespace swiftgs::stress
