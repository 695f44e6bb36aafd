// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <swiftgs/edit/transform.hpp>
#include <swiftgs/frame/placing.hpp>

#include "hard_frames/case.hpp"
#include "hard_frames/shapes.hpp"
#include "hard_frames/thresholds.hpp"

/// @file
/// Families of placed scenes.

namespace swiftgs::stress {

/// Takes the scene to a space of its own, from which a pose of this scale brings it back.
inline void place(StressCase& drawn, Random& random, double scale) {
  const Quaternion q = random.rotation();
  Similarity& pose = drawn.world_from_scene;
  pose.rotation = matrix_of(unit(DQuaternion{q.w, q.x, q.y, q.z})), pose.scale = scale;
  pose.translation = random.point(-3, 3);
  transform(drawn.scene, inverse(pose), dvec3(0.0));
}

/// A scene of a size of its own, placed far from the world's origin, and a camera beside its own; severity:
/// how far. Every third is 1e6 times as large where it is placed, every third a millionth.
inline StressCase placed_scenes(double distance, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = usual_case(random, size, 60, 3);
  turn(out, random.in(-3, 3));
  const double scales[] = {random.scale(0.1, 10), 1e6, 1e-6};
  place(out, random, scales[seed % 3]);
  const dvec3 offset = distant_point(random, distance);
  out.world_from_scene.translation += offset, out.camera.translation -= out.camera.rotation * offset;
  return out;
}

/// Splats of millimetres, of scenes in units of their own, and a camera before them that looks along an axis
/// of the world, so that no product with its rotation rounds; severity: how far they are from the origin.
inline StressCase far_millimetres(double distance, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = usual_case(random, size, 60, 2);
  place(out, random, random.scale(1e-3, 1e3));
  out.conventions.near_plane = 1e-5f;
  const double cosines[] = {1, 0, -1, 0}, c = cosines[seed % 4], s = cosines[(seed + 1) % 4];
  out.camera.rotation = dmat3(c, 0, s, 0, 1, 0, -s, 0, c);
  const dvec3 offset = distant_point(random, distance);
  const dmat3 back = glm::transpose(out.camera.rotation);
  Similarity& pose = out.world_from_scene;
  pose.rotation = back * pose.rotation, pose.scale *= 1e-3;
  pose.translation = offset + 1e-3 * (back * pose.translation);
  out.camera.translation = -(out.camera.rotation * offset);
  return out;
}

/// `mean`, moved to where `value`, its distance from a border along the unit vector `along`, is `to`.
inline vec3 moved_along(const vec3& mean, const dvec3& along, double value, double to) {
  return vec3(dvec3(mean) + (to - value) * along);
}

/// Needles and flat Gaussians of which a box, a sphere or half-spaces leave some out, in scenes of 1e-3 to
/// 1e3 times the world's size; severity: how far their means are from its border, inside or outside.
/// @units{last places of the mean}
inline StressCase clipped_scenes(double steps, std::uint64_t seed, ImageSize size) {
  constexpr std::size_t usual = 10;
  StressCase out = shaped_case(seed, size, usual, 40, [=](Random& random, Gaussian& g) {
    g.mean = point_in_view(random, size, random.in(2, 6));
    const bool needle = random.below(2);
    const double side = needle ? random.in(1, 10) : random.in(0.2, 3), thin = side * random.scale(1e-8, 1e-2);
    g.scale = {float(side), float(needle ? thin : side * random.in(0.3, 1)), float(thin)};
  });
  Random random(seed + 1);
  turn(out, random.in(-3, 3));
  place(out, random, random.scale(1e-3, 1e3));
  const Similarity& pose = out.world_from_scene;
  const dvec3 middle = inverse(pose)(glm::transpose(out.camera.rotation) * dvec3(0, 0, 4));
  const vec3 low(middle - 1.2 / pose.scale), high(middle + 0.9 / pose.scale), centre(middle);
  Clip& clip = out.clip;
  if (seed % 3 == 0) clip = Clip::box(low, high);
  if (seed % 3 == 1) clip = Clip::sphere(centre, float(1.5 / pose.scale));
  if (seed % 3 == 2) {
    clip.half_space_count = 2;
    for (int i = 0; i < 2; ++i) {
      const dvec3 axis = pose.rotation[i] + 0.5 * pose.rotation[2];
      const vec3 normal(axis / std::sqrt(detail::dot(axis, axis)));
      clip.half_spaces[i] = vec4(normal.x, normal.y, normal.z, float(-detail::dot(dvec3(normal), middle)));
    }
  }
  for (std::size_t i = usual; i < out.scene.size(); ++i) {
    vec3& mean = out.scene.means[i];
    const int k = random.below(3), side = random.below(2) ? 1 : -1;
    const float largest = std::max({std::abs(mean.x), std::abs(mean.y), std::abs(mean.z)});
    const double off = side * steps * std::ldexp(double(largest), -23);
    if (seed % 3 == 0) {  // by whole last places, which floats tell
      mean[k] = stepped(random.below(2) ? low[k] : high[k], side * int(steps));
    } else if (seed % 3 == 1) {
      const dvec3 from = dvec3(mean) - dvec3(centre);
      const double length = std::sqrt(detail::dot(from, from));
      mean = moved_along(mean, from / length, length, double(clip.radius) + off);
    } else {
      const vec4& h = clip.half_spaces[k % 2];
      const dvec3 normal(double(h.x), double(h.y), double(h.z));
      mean = moved_along(mean, normal, detail::dot(normal, dvec3(mean)) + double(h.w), off);
    }
  }
  return out;
}

}  // namespace swiftgs::stress
