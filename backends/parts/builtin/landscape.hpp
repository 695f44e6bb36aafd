// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The background of the built-in scene: hills, a lake, cypresses, a balloon and the sky.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "emit.hpp"

namespace swiftgs::builtin {

inline constexpr double lake_height = -9.0;  ///< @units{metres}

/// Height of the land: the terrace stands on a hill, with a valley and mountains around it.
inline double land_height(double x, double z) {
  const double r = std::sqrt(x * x + z * z);
  const dvec3 p(x, 0, z);
  const double valley = -11.5 * smooth_step(4.0, 34.0, r);
  const double rolling =
      7.0 * smooth_step(8, 30, r) * (layered_noise(p * 0.045 + dvec3(3.2, 0, 1.7), 3) - 0.42);
  const double ridge = 1 - std::abs(2 * layered_noise(p * 0.017 + dvec3(7.7, 0, 9.1), 4) - 1);
  return -0.06 + valley + rolling + 20 * smooth_step(45, 150, r) * ridge * ridge * ridge;
}

/// Air between the scene and `p`: distant things take the colour of the horizon.
inline dvec3 through_air(const dvec3& linear, const dvec3& p) {
  const double distance = length(p), amount = 1 - power_of_two(-distance / 190);
  const dvec3 d = unit(dvec3(p.x, -0.12 * distance, p.z));
  return mix(linear, sky_colour(d) * dvec3(0.78, 0.86, 1.0), amount);
}

/// A matte thing in the open: sun, sky and air.
inline dvec3 lit_outdoors(const dvec3& body, const dvec3& p, const dvec3& n) {
  const double facing = dot(n, to_sun());
  const dvec3 sky = dvec3(0.42, 0.55, 0.72) * (0.55 - 0.45 * n.y);
  return through_air(body * (dvec3(2.2, 1.75, 1.15) * clamp01(facing) + sky), p);
}

/// Land from the kerb to the mountains; its Gaussians grow with distance, so they stay equal on the image.
inline void emit_land(std::uint64_t stream, Sink sink) {
  const std::size_t count = sink.left();
  for (std::size_t i = 0; i < count; ++i) {
    if (sink.skips()) continue;
    Random random(stream, i);
    const SquarePoint q(i);
    const double r = 2.8 * power_of_two(5.98 * q.v), x = r * cos_turns(q.u), z = r * sin_turns(q.u);
    const double e = 0.01 * r;
    const auto ground = [](double px, double pz) { return std::max(land_height(px, pz), lake_height); };
    const double h = ground(x, z);
    const bool water = h <= lake_height;
    const dvec3 n = unit(at(ground(x - e, z) - ground(x + e, z), 2 * e, ground(x, z - e) - ground(x, z + e)));
    Blob blob;
    blob.mean = at(x, h, z);
    const double fields = cell_value(std::int64_t(std::floor(x * 0.11 + z * 0.03)),
                                     std::int64_t(std::floor(z * 0.085 - x * 0.02)), 11);
    const double wood = layered_noise(dvec3(x, 0, z) * 0.06, 3), grain = 0.7 + 0.6 * random.uniform();
    dvec3 body = mix(dvec3(0.13, 0.20, 0.045), dvec3(0.42, 0.36, 0.11), fields);
    body = mix(body, dvec3(0.035, 0.085, 0.03), smooth_step(0.53, 0.6, wood) * smooth_step(10, 20, r));
    body = mix(dvec3(0.10, 0.17, 0.04), body, smooth_step(4, 12, r));
    body = mix(body, dvec3(0.26, 0.24, 0.25), smooth_step(4, 18, h));
    const dvec3 seen = lit_outdoors(body * grain, blob.mean, n);
    blob.radiance.add(display(water ? through_air(dvec3(0.10, 0.22, 0.30), blob.mean) : seen));
    if (water)
      blob.radiance.add_lobe(n, rim_lobe, dvec3(0.30, 0.30, 0.28));
    else
      blob.radiance.add_lobe(n, rim_lobe, dvec3(0.05, 0.045, 0.02));
    const double sigma =
        0.78 * r * std::sqrt(6.2832 * 4.145 / double(count)) * power_of_two(0.3 * random.bell());
    const double stretch = power_of_two(0.5 * std::abs(random.bell()));
    blob.axes = turned(axes_along(n, dvec3(-z, 0, x)), 0.02 * random.bell());
    blob.scale = dvec3(0.8 * sigma, 1.0 * sigma * stretch, sigma * 0.12 * power_of_two(0.8 * random.bell()));
    const double loss = random.uniform();
    blob.opacity = 0.998 - 0.4 * loss * loss;
    if (random.uniform() < 0.3) make_faint(blob, random, sigma);
    add_residue(blob.radiance, random, 0.008);
    sink.add(blob);
  }
}

/// Cypresses on the hills.
inline void emit_trees(std::uint64_t stream, Sink sink) {
  constexpr std::size_t trees = 46;
  const double spacing = std::sqrt(18.0 * trees / (double(sink.left()) + 1));
  for (std::size_t i = 0; sink.left() > 0; ++i) {
    if (sink.skips()) continue;
    const std::size_t tree = i % trees;
    Random shape(stream, tree), random(stream + 1, i);
    const double r = 9.5 + 28 * double(tree) / trees * shape.between(0.8, 1.2),
                 turn = 0.618034 * double(tree) + 0.03 * shape.bell();
    const double x = r * cos_turns(turn), z = r * sin_turns(turn);
    const double tall = shape.between(3.2, 6.2), wide = tall * shape.between(0.09, 0.13),
                 t = random.uniform();
    const double around = random.uniform(), profile = std::sqrt(t * 7 + 0.2) * (1 - t) * 1.05;
    const double out = wide * profile * (0.8 + 0.4 * random.uniform());
    const dvec3 n = unit(at(cos_turns(around), 0.3, sin_turns(around)) + random.bell3() * 0.3);
    Blob blob;
    blob.mean = at(x + out * cos_turns(around), land_height(x, z) + tall * t, z + out * sin_turns(around));
    blob.axes = axes_along(n, at(0, 1, 0) + random.bell3() * 0.3);
    const double sigma = 0.55 * spacing * power_of_two(0.4 * random.bell());
    blob.scale = dvec3(1.7 * sigma, 0.7 * sigma, 0.25 * sigma);
    const dvec3 body = dvec3(0.045, 0.10, 0.035) * random.between(0.5, 1.6);
    blob.radiance.add(display(lit_outdoors(body, blob.mean, n)));
    blob.radiance.add_lobe(n, rim_lobe, dvec3(0.05, 0.06, 0.03));
    add_residue(blob.radiance, random, 0.01);
    blob.opacity = random.between(0.4, 0.98);
    if (random.uniform() < 0.25) make_faint(blob, random, sigma);
    sink.add(blob);
  }
}

/// A striped balloon over the valley.
inline void emit_balloon(std::uint64_t stream, Sink sink) {
  const dvec3 centre = at(27, 14.5, 74);
  const double spacing = std::sqrt(12.566 * 2.6 * 2.6 / (double(sink.left()) + 1));
  for (std::size_t i = 0; sink.left() > 0; ++i) {
    if (sink.skips()) continue;
    Random random(stream, i);
    const SquarePoint q(i);
    const double height = 2 * q.u - 1, around = std::sqrt(1 - height * height);
    const double taper = height < 0 ? 1 + 0.30 * height * height * height : 1;
    const dvec3 n = at(around * cos_turns(q.v), height, around * sin_turns(q.v));
    Blob blob;
    blob.mean = centre + dvec3(n.x * taper, n.y * (height < 0 ? 1.25 : 1.0), n.z * taper) * 2.6;
    blob.axes = axes_along(n, dvec3(0.1, 1, 0.2));
    blob.scale = dvec3(0.75 * spacing, 0.55 * spacing, 0.1 * spacing);
    const double stripe = 14 * q.v - std::floor(14 * q.v);
    const dvec3 body = std::abs(height) < 0.13 ? dvec3(0.85, 0.75, 0.55)
                       : stripe < 0.5          ? dvec3(0.75, 0.10, 0.05)
                                               : dvec3(0.88, 0.58, 0.10);
    blob.radiance.add(display(lit_outdoors(body, blob.mean, n)));
    blob.radiance.add_lobe(n, rim_lobe, dvec3(0.06, 0.05, 0.05));
    blob.opacity = random.between(0.75, 0.99);
    sink.add(blob);
  }
}

/// The sky: clouds in a dome 190 m away, finer towards the horizon.
inline void emit_sky(std::uint64_t stream, Sink sink) {
  const std::size_t count = sink.left();
  constexpr double radius = 190, lowest = -0.10;
  for (std::size_t i = 0; i < count; ++i) {
    if (sink.skips()) continue;
    Random random(stream, i);
    const SquarePoint q(i);
    const double v = q.v, height = lowest + (1 - lowest) * v * (0.45 + 0.55 * v);
    const double around = std::sqrt(clamp01(1 - height * height));
    const dvec3 d = at(around * cos_turns(q.u), height, around * sin_turns(q.u));
    const dvec3 plane = d / (0.16 + std::abs(height));
    const double cloud = layered_noise(dvec3(plane.x * 1.1, 2.4, plane.z * 2.1), 5);
    const double cover = smooth_step(0.51, 0.64, cloud) * smooth_step(0.01, 0.10, height);
    const double lit = 0.85 + 0.4 * clamp01(dot(d, to_sun())) + 0.5 * (0.62 - cloud);
    const dvec3 linear = mix(sky_colour(d), dvec3(2.5, 2.25, 2.05) * lit, 0.92 * cover);
    const double area = 6.2832 * (1 - lowest) * (0.45 + 1.1 * v) / double(count);
    const double sigma = 1.0 * radius * std::sqrt(area) * power_of_two(0.25 * random.bell());
    Blob blob;
    blob.mean = d * radius;
    blob.axes = turned(axes_along(-d, dvec3(-d.z, 0, d.x + 1e-6)), 0.02 * random.bell());
    blob.scale = dvec3(sigma * power_of_two(0.5 * std::abs(random.bell())), sigma, 0.2 * sigma);
    blob.radiance.add(display(linear));
    add_residue(blob.radiance, random, 0.004);
    blob.opacity = random.between(0.85, 0.995);
    if (random.uniform() < 0.25) make_faint(blob, random, sigma);
    sink.add(blob);
  }
}

}  // namespace swiftgs::builtin
