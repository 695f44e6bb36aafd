// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Gaussians and views that projection is searched over.

#include <string>
#include <vector>

#include <swiftgs/project/project.hpp>

#include "stability/exact_projection.hpp"
#include "stability/search.hpp"

namespace swiftgs::test {

/// A camera of double precision turned by a random quaternion.
inline Camera turned_camera(Camera camera, Random& random, double distance) {
  double q[4], squares = 0;
  for (double& v : q) v = random.in(-1, 1), squares += v * v;
  for (double& v : q) v /= std::sqrt(squares);
  const Real wide[4] = {q[0], q[1], q[2], q[3]};
  for (int k = 0; k < 3; ++k) {
    Real3 axis{};
    axis[std::size_t(k)] = 1;
    axis = turned(wide, axis);
    camera.rotation[k] = dvec3(double(axis[0]), double(axis[1]), double(axis[2]));
  }
  const double z = random.in(-1, 1), y = random.in(-1, 1), x = random.in(-1, 1);
  camera.translation = dvec3(x, y, z) * distance;
  return camera;
}

struct NamedCamera {
  std::string name;
  Camera camera;
};

/// Along the axes; turned; far from the world's origin; so wide that rows of the Jacobian are nearly
/// parallel.
inline std::vector<NamedCamera> searched_cameras() {
  Random random(11);
  const Camera forward = forward_camera(128, 96);
  Camera wide = forward_camera(128, 96, 6);
  wide.cx = 20;
  return {{"forward", forward},
          {"turned", turned_camera(forward, random, 2)},
          {"far", turned_camera(forward, random, 20000)},
          {"wide", turned_camera(wide, random, 2)}};
}

/// A Gaussian in or near the view; of three, one is seen exactly edge-on.
inline Gaussian draw_gaussian(Random& random, const ViewConstants& v) {
  Gaussian g;
  const double size = random.scale(1e-4, 10), flat = random.scale(1e-6, 1), thin = random.scale(1e-4, 1);
  const double sizes[3] = {size, size * thin, size * flat};
  const std::size_t first = random.bits() % 3;
  for (std::size_t k = 0; k < 3; ++k) g.scale[int(k)] = float(sizes[(first + k) % 3]);
  g.rotation = random_rotation(random);
  g.opacity = float(random.scale(0.004, 1));

  const double z = random.scale(0.02, 100);
  const double tx = random.in(1.2 * v.limits.least_u, 1.2 * v.limits.most_u);
  const double ty = random.in(1.2 * v.limits.least_v, 1.2 * v.limits.most_v);
  double p[3] = {tx * z, ty * z, z};
  double world[3] = {};
  for (int k = 0; k < 3; ++k)
    for (int r = 0; r < 3; ++r) world[k] += v.rotation[r][k] * p[r];
  if (random.bits() % 3 == 0) {
    // Take a direction within the plane of two of the Gaussian's axes, where that is in front of the camera.
    const LocalAxes<float> axes(g.rotation);
    const double angle = random.in(0, 6.2831853);
    double ahead = 0, along[3];
    for (int k = 0; k < 3; ++k) {
      along[k] = std::cos(angle) * double(axes.column[(first + 0) % 3][k]) +
                 std::sin(angle) * double(axes.column[(first + 1) % 3][k]);
      ahead += v.rotation[2][k] * along[k];
    }
    for (int k = 0; k < 3 && std::abs(ahead) > 0.05; ++k) world[k] = along[k] * z / ahead;
  }
  for (int k = 0; k < 3; ++k) g.mean[k] = float(world[k] + v.centre[k]);
  return g;
}

inline void nudge(Random& random, Gaussian& g) {
  for (int k = 0; k < 3; ++k) nudge(random, g.mean[k]), nudge(random, g.scale[k]);
  for (int k = 0; k < 3; ++k) g.scale[k] = std::abs(g.scale[k]);
  nudge(random, g.rotation);
  nudge(random, g.opacity);
  g.opacity = std::fmin(1.0f, std::abs(g.opacity));
}

inline std::string text_of(const Gaussian& g) {
  return text("mean %.9g %.9g %.9g scale %.9g %.9g %.9g rotation %.9g %.9g %.9g %.9g opacity %.9g",
              double(g.mean.x), double(g.mean.y), double(g.mean.z), double(g.scale.x), double(g.scale.y),
              double(g.scale.z), double(g.rotation.w), double(g.rotation.x), double(g.rotation.y),
              double(g.rotation.z), double(g.opacity));
}

}  // namespace swiftgs::test
