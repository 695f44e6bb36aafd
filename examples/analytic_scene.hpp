// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the host renderers of the examples draw: two spheres and a chequered floor among the still life of
/// the built-in scene, ray-traced by functions that the host and a device both run.

#include <cmath>
#include <cstdint>
#include <limits>

#include <swiftgs/camera.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/store_pixel.hpp>

namespace analytic {

using swiftgs::dmat3, swiftgs::dvec3;

inline constexpr float nowhere = std::numeric_limits<float>::infinity();

SWIFTGS_HD inline double dot(dvec3 a, dvec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SWIFTGS_HD inline dvec3 unit(dvec3 v) { return v / std::sqrt(dot(v, v)); }
SWIFTGS_HD inline double above_zero(double v) { return v > 0 ? v : 0; }

/// Where a ray ends; at infinity where it meets nothing.
struct Hit {
  double t = nowhere;
  dvec3 normal{0}, colour{0};
};

SWIFTGS_HD inline Hit trace(dvec3 from, dvec3 along) {
  const struct {
    dvec3 centre;  ///< y points down, as in the scene
    double radius;
    dvec3 colour;
  } spheres[] = {{dvec3(0.02, -1.16, 0.02), 0.30, dvec3(1.0, 0.55, 0.10)},      // in the knot
                 {dvec3(-0.03, -0.28, -1.20), 0.22, dvec3(0.75, 0.08, 0.25)}};  // on the floor
  constexpr double floor_y = -0.06, floor_radius = 1.75;

  Hit hit;
  for (const auto& sphere : spheres) {
    const dvec3 offset = from - sphere.centre;
    const double a = dot(along, along), b = dot(offset, along);
    const double root = b * b - a * (dot(offset, offset) - sphere.radius * sphere.radius);
    const double t = root > 0 ? (-b - std::sqrt(root)) / a : -1;
    if (t > 1e-6 && t < hit.t) hit = {t, (offset + t * along) / sphere.radius, sphere.colour};
  }
  const double t = (floor_y - from.y) / along.y;
  const dvec3 at = from + t * along;
  if (t > 1e-6 && t < hit.t && at.x * at.x + at.z * at.z < floor_radius * floor_radius) {
    const bool dark = (int(std::floor(3 * at.x)) + int(std::floor(3 * at.z))) % 2 == 0;
    hit = {t, dvec3(0, -1, 0), dark ? dvec3(0.10, 0.11, 0.13) : dvec3(0.75, 0.73, 0.68)};
  }
  return hit;
}

/// Light that comes back: sun with shadow and highlight, and sky from above.
SWIFTGS_HD inline dvec3 shade(const Hit& hit, dvec3 at, dvec3 along) {
  const dvec3 sun = unit(dvec3(-0.74, -0.52, -0.34));
  const bool lit = trace(at + 1e-4 * hit.normal, sun).t == nowhere;
  const double sunlight = lit ? above_zero(dot(hit.normal, sun)) : 0.0;
  const dvec3 half_way = unit(sun - unit(along));
  const double highlight = lit ? std::pow(above_zero(dot(hit.normal, half_way)), 80.0) : 0.0;
  const dvec3 sky = dvec3(0.20, 0.26, 0.36) * (0.6 - 0.4 * hit.normal.y);
  return hit.colour * (sky + dvec3(1.0, 0.88, 0.70) * sunlight) + 0.6 * highlight;
}

/// A camera in numbers alone, which a kernel can be given.
struct View {
  dvec3 eye{0};
  dmat3 rotation{1.0};
  double fx = 1, fy = 1, cx = 0, cy = 0;
};

inline View view_of(const swiftgs::Camera& camera) {
  return {camera.centre(), camera.rotation, camera.fx, camera.fy, camera.cx, camera.cy};
}

/// A pixel of the host's image.
struct alignas(4) Rgba8 {
  std::uint8_t r = 0, g = 0, b = 0, a = 0;
  bool operator==(const Rgba8&) const = default;
};

/// What the host draws at a pixel before splats come.
struct Surface {
  Rgba8 colour;
  float depth = nowhere;  ///< camera-space z, with which splats are compared
};

SWIFTGS_HD inline Surface draw_pixel(const View& view, int x, int y) {
  // A ray whose camera-space z is 1: where it ends is the depth.
  const dvec3 along = dvec3((x + 0.5 - view.cx) / view.fx, (y + 0.5 - view.cy) / view.fy, 1) * view.rotation;
  const Hit hit = trace(view.eye, along);
  if (hit.t == nowhere) return {};
  const dvec3 light = shade(hit, view.eye + hit.t * along, along);
  const auto display = [](double v) { return swiftgs::to_unorm8(float(std::sqrt(v))); };
  return {{display(light.x), display(light.y), display(light.z), 255}, float(hit.t)};
}

}  // namespace analytic
