// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The foreground of the built-in scene: a glazed knot on a drum, a fluted vase, a nautilus, three glass
/// balls.

#include <array>
#include <cmath>
#include <cstddef>

#include "emit.hpp"

namespace swiftgs::builtin {

/// Radius and height along an outline that is turned about a vertical axis.
struct OutlinePoint {
  double radius, height;
};

/// A smooth curve through `points` (Catmull-Rom), `t` from 0 at the first to 1 at the last.
template <std::size_t N>
OutlinePoint along_outline(const std::array<OutlinePoint, N>& points, double t) {
  const double x = clamp01(t) * double(N - 1);
  const std::size_t k = std::size_t(x) > N - 2 ? N - 2 : std::size_t(x);
  const double f = x - double(k);
  const auto &b = points[k], &c = points[k + 1];
  const auto &a = k > 0 ? points[k - 1] : b, &d = k + 2 < N ? points[k + 2] : c;
  const auto blend = [f](double p, double q, double r, double s) {
    return q + 0.5 * f * (r - p + f * (2 * p - 5 * q + 4 * r - s + f * (3 * (q - r) + s - p)));
  };
  return {blend(a.radius, b.radius, c.radius, d.radius), blend(a.height, b.height, c.height, d.height)};
}

/// A solid of revolution around `foot`, with `flutes` grooves of relative depth `depth`.
template <std::size_t N>
auto turned_solid(dvec3 foot, std::array<OutlinePoint, N> outline, int flutes = 0, double depth = 0) {
  return [=](double u, double v) {
    const OutlinePoint o = along_outline(outline, u);
    const double belly = smooth_step(0.12, 0.2, u) * (1 - smooth_step(0.56, 0.64, u));
    const double radius = o.radius * (1 + depth * belly * std::abs(sin_turns(0.5 * flutes * v)));
    return foot + at(radius * cos_turns(v), o.height, radius * sin_turns(v));
  };
}

/// A round pedestal of veined marble.
inline Surface drum() {
  constexpr std::array<OutlinePoint, 17> outline{{{0.50, 0.0},
                                                  {0.50, 0.07},
                                                  {0.495, 0.085},
                                                  {0.46, 0.10},
                                                  {0.44, 0.125},
                                                  {0.41, 0.14},
                                                  {0.40, 0.16},
                                                  {0.40, 0.26},
                                                  {0.40, 0.36},
                                                  {0.40, 0.42},
                                                  {0.42, 0.44},
                                                  {0.45, 0.46},
                                                  {0.47, 0.48},
                                                  {0.475, 0.53},
                                                  {0.46, 0.545},
                                                  {0.30, 0.55},
                                                  {0.0, 0.55}}};
  Surface s;
  s.point = turned_solid(dvec3(0.0), outline);
  s.material = [](double, double, dvec3& p) {
    const double vein = std::abs(layered_noise(p * 2.6, 4) - 0.5) * 2;
    const dvec3 body = mix(dvec3(0.34, 0.31, 0.30), dvec3(0.72, 0.67, 0.60), smooth_step(0.0, 0.16, vein));
    return Material{.body = body, .highlight = dvec3(0.10), .rim = dvec3(0.10, 0.11, 0.13)};
  };
  s.stretch = 0.3;
  return s;
}

/// A trefoil knot that stands on the drum: cobalt and turquoise glaze with a line of gold around it.
inline Surface knot() {
  const auto centre_line = [](double t) {
    const double r = 0.37 + 0.155 * cos_turns(3 * t);
    return at(r * cos_turns(2 * t + 0.125), 1.17 + r * sin_turns(2 * t + 0.125), 0.17 * sin_turns(3 * t));
  };
  Surface s;
  s.point = [centre_line](double u, double v) {
    const dvec3 c = centre_line(u), tangent = unit(centre_line(u + 1e-3) - centre_line(u - 1e-3));
    const dvec3 a = unit(cross(tangent, dvec3(0, 0, 1))), b = cross(tangent, a);
    const double radius = 0.108 + 0.006 * cos_turns(3 * v + 8 * u);
    return c + (a * cos_turns(v) + b * sin_turns(v)) * radius;
  };
  s.material = [](double u, double v, dvec3& p) {
    const double phase = 3 * v + 8 * u, gold_distance = std::abs(phase - std::floor(phase) - 0.5);
    const double cloud = layered_noise(p * 5.0, 3) + 0.22 * cos_turns(2 * u);
    if (gold_distance > 0.447)
      return Material{.body = dvec3(0.86, 0.52, 0.13),
                      .highlight = dvec3(0.95, 0.72, 0.34),
                      .rim = dvec3(0.28, 0.18, 0.06)};
    const dvec3 body = mix(dvec3(0.012, 0.055, 0.33), dvec3(0.03, 0.40, 0.42), smooth_step(0.3, 0.72, cloud));
    return Material{.body = body,
                    .highlight = dvec3(0.85, 0.84, 0.80),
                    .rim = dvec3(0.32, 0.42, 0.55),
                    .interference = dvec3(0.10, -0.02, 0.06)};
  };
  s.cover = 0.6;
  s.roughness = 0.03;
  return s;
}

/// A fluted vase of celadon over terracotta.
inline Surface vase() {
  constexpr std::array<OutlinePoint, 15> outline{{{0.0, 0.0},
                                                  {0.15, 0.0},
                                                  {0.165, 0.03},
                                                  {0.15, 0.07},
                                                  {0.20, 0.18},
                                                  {0.275, 0.34},
                                                  {0.305, 0.50},
                                                  {0.275, 0.66},
                                                  {0.185, 0.79},
                                                  {0.12, 0.88},
                                                  {0.115, 0.95},
                                                  {0.165, 1.02},
                                                  {0.155, 1.03},
                                                  {0.095, 0.95},
                                                  {0.08, 0.80}}};
  Surface s;
  s.point = turned_solid(at(-1.28, 0, 0.42), outline, 24, 0.06);
  s.material = [](double u, double v, dvec3& p) {
    const double drip = 0.60 + 0.05 * sin_turns(5 * v + 0.3) + 0.04 * sin_turns(11 * v);
    const bool glazed = u < drip - 0.36 || u > drip - 0.12;
    const double band = 24 * v - std::floor(24 * v);
    if (u > 0.87) return Material{.body = dvec3(0.08, 0.05, 0.04)};
    if (glazed)
      return Material{
          .body = mix(dvec3(0.26, 0.46, 0.36), dvec3(0.56, 0.72, 0.56), layered_noise(p * 8.0, 3)),
          .highlight = dvec3(0.55),
          .rim = dvec3(0.22, 0.28, 0.28)};
    const double groove = std::abs(band - 0.5);
    return Material{
        .body = dvec3(0.58, 0.22, 0.10) * (0.75 + 0.5 * noise(p * 20.0)) * (groove > 0.44 ? 0.6 : 1.0),
        .highlight = dvec3(0.10),
        .rim = dvec3(0.08, 0.06, 0.05)};
  };
  return s;
}

/// A nautilus: each turn of the spiral is 2.9 times as large as the one before.
inline Surface nautilus() {
  Surface s;
  s.point = [](double u, double v) {
    const double turns = 2.15 * u, outer = 0.44 * power_of_two(1.536 * (turns - 2.15));
    const double angle = turns + 0.02, across = 0.345 * outer, middle = outer - across;
    const double out = middle + across * cos_turns(v), wide = -0.43 * outer * sin_turns(v);
    const dvec3 flat = at(-out * cos_turns(angle), out * sin_turns(angle), wide);
    const dvec3 yawed(flat.x * 0.88 + flat.z * 0.475, flat.y, flat.z * 0.88 - flat.x * 0.475);
    return yawed + at(1.22, 0.335, -0.42);
  };
  s.material = [](double u, double v, dvec3& p) {
    const double side = std::abs(v - std::floor(v + 0.5)) * 2;  // 0 on the back, 1 inside
    const double wave = 17 * u + 0.5 * side * side + 0.35 * noise(p * 9.0);
    const double flame = std::abs(2 * (wave - std::floor(wave)) - 1);
    const double fade = (1 - smooth_step(0.45, 0.72, side)) * (1 - smooth_step(0.80, 0.90, u));
    const dvec3 body =
        mix(dvec3(0.86, 0.77, 0.63), dvec3(0.52, 0.15, 0.04), fade * smooth_step(0.45, 0.6, flame));
    return Material{.body = body,
                    .highlight = dvec3(0.42),
                    .rim = dvec3(0.24, 0.20, 0.24),
                    .interference = dvec3(0.07, -0.05, 0.05) * (1.5 - fade)};
  };
  s.cover = 0.6;
  return s;
}

inline Surface ball(const dvec3& centre, double radius, const dvec3& tint) {
  Surface s;
  s.point = [=](double u, double v) {
    const double height = 2 * u - 1, around = std::sqrt(clamp01(1 - height * height));
    return centre + at(around * cos_turns(v), height, around * sin_turns(v)) * radius;
  };
  s.material = [=](double, double, dvec3& p) {
    const double swirl = layered_noise(p * (0.55 / radius) + dvec3(0, 3 * p.x, 0), 3);
    return Material{.body = tint * (0.45 + 0.9 * smooth_step(0.35, 0.65, swirl)),
                    .highlight = dvec3(0.95),
                    .rim = dvec3(0.34, 0.40, 0.46),
                    .interference = dvec3(0.05, 0.0, -0.05)};
  };
  return s;
}

}  // namespace swiftgs::builtin
