// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Thin and faint things of the built-in scene: grass and flowers, plumes in the vase, floaters in the air.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "landscape.hpp"

namespace swiftgs::builtin {

/// Blades of grass with flowers among them. Their number and the number of Gaussians along each both grow as
/// the square root of the count, and a blade gets thinner accordingly: the same meadow in finer detail.
inline void emit_grass(std::uint64_t stream, Sink sink, double fineness) {
  const std::size_t segments = std::size_t(std::max(3.0, std::floor(4 * fineness + 0.5)));
  for (std::size_t blade = 0; sink.left() > 0; ++blade) {
    if (sink.skips(segments)) continue;
    Random random(stream, blade);
    const double out = random.uniform(), turn = random.uniform();
    const double clump = noise(at(7 * cos_turns(turn), 0, 7 * sin_turns(turn)));
    const double r = 3.0 + 4.2 * out * out, x = r * cos_turns(turn), z = r * sin_turns(turn);
    const double height = (0.14 + 0.34 * clump) * random.between(0.55, 1.25);
    const dvec3 root = at(x, land_height(x, z) - 0.02, z);
    const double lean_turn = random.uniform(), lean = height * random.between(0.1, 0.7);
    const dvec3 side = at(cos_turns(lean_turn) + 0.5, 0, sin_turns(lean_turn)) * lean;
    const dvec3 green =
        mix(dvec3(0.11, 0.22, 0.03), dvec3(0.46, 0.42, 0.12), random.uniform() * random.uniform());
    const double flower = random.uniform();
    const bool blooms = flower < 0.16 && clump > 0.4;
    for (std::size_t k = 0; k < segments && sink.left() > 0; ++k) {
      const double t = (double(k) + 0.5) / double(segments);
      const dvec3 along = at(0, height, 0) + side * (2 * t);
      Blob blob;
      blob.mean = root + at(0, height * t, 0) + side * (t * t);
      blob.axes = axes_along(unit(cross(along, dvec3(cos_turns(turn), 0.1, sin_turns(turn)))), along);
      const double thin = 0.0042 / fineness * (1.3 - t) * power_of_two(0.5 * random.bell());
      blob.scale = dvec3(length(along) / double(segments) * 0.42, thin, thin * random.between(0.2, 0.9));
      dvec3 body = green * (0.35 + 1.2 * t);
      blob.opacity = random.between(0.15, 0.95);
      if (blooms && k + 1 == segments) {
        const double size = 0.017 * power_of_two(0.3 * random.bell()) / std::sqrt(fineness);
        body = flower < 0.09   ? dvec3(0.85, 0.05, 0.03)
               : flower < 0.13 ? dvec3(0.90, 0.82, 0.70)
                               : dvec3(0.45, 0.20, 0.75);
        blob.scale = dvec3(size * 1.2, size, size * 0.35);
      }
      const dvec3 n = unit(at(0, 0.8, 0) + to_sun());
      blob.radiance.add(display(lit_outdoors(body, dvec3(0.001, 0, 0), n)));
      // Blades glow when the sun shines through them towards the eye.
      blob.radiance.add_lobe(-to_sun(), highlight_lobe, body * dvec3(0.5, 0.5, 0.2));
      add_residue(blob.radiance, random, 0.01);
      sink.add(blob);
    }
  }
}

/// Plumes of dry grass in the vase: stems with long fine hairs.
inline void emit_plumes(std::uint64_t stream, Sink sink, double fineness) {
  constexpr int stems = 13;
  for (std::size_t i = 0; sink.left() > 0; ++i) {
    if (sink.skips()) continue;
    Random random(stream, i);
    const double stem = std::floor(random.uniform() * stems), turn = 0.618034 * stem;
    const double reach = 0.14 + 0.30 * cell_value(std::int64_t(stem), 5, 5),
                 rise = 0.72 + 0.45 * cell_value(std::int64_t(stem), 6, 6);
    const dvec3 foot = at(-1.28, 0.92, 0.42);
    const auto curve = [&](double t) {
      return foot +
             at(reach * cos_turns(turn) * t * t, rise * t - 0.12 * t * t, reach * sin_turns(turn) * t * t);
    };
    const double t = random.uniform();
    const bool hair = t > 0.45;
    const dvec3 along = unit(curve(t + 0.01) - curve(t - 0.01));
    const dvec3 spread = random.bell3();
    const dvec3 direction = hair ? unit(along + spread * 0.5) : along;
    const double body_width = hair ? 0.045 * sin_turns(0.5 * (t - 0.40) / 0.62) : 0.002;
    Blob blob;
    blob.mean = curve(t) + spread * body_width * 0.55;
    blob.axes = axes_along(unit(cross(direction, dvec3(0.3, 0.2, 0.9))), direction);
    const double long_side = (hair ? 0.024 : 0.03) * power_of_two(0.5 * random.bell()) / fineness;
    const double thin = (hair ? 0.0016 : 0.003) / fineness;
    blob.scale = dvec3(long_side, thin, thin * random.between(0.3, 1.0));
    const dvec3 body = hair ? mix(dvec3(0.62, 0.46, 0.30), dvec3(0.90, 0.78, 0.60), random.uniform())
                            : dvec3(0.34, 0.27, 0.10);
    blob.radiance.add(display(lit_outdoors(body, dvec3(0.001, 0, 0), unit(spread * 0.5 + to_sun()))));
    blob.radiance.add_lobe(-to_sun(), highlight_lobe, dvec3(0.30, 0.22, 0.12));
    add_residue(blob.radiance, random, 0.01);
    blob.opacity = random.between(0.03, 0.75);
    sink.add(blob);
  }
}

/// Faint Gaussians that float in the air around the still life.
inline void emit_floaters(std::uint64_t stream, Sink sink, double fineness) {
  for (std::size_t i = 0; sink.left() > 0; ++i) {
    if (sink.skips()) continue;
    Random random(stream, i);
    Blob blob;
    const double r = 2.6 * random.uniform(), turn = random.uniform(), height = 2.2 * random.uniform();
    blob.mean = at(r * cos_turns(turn), height, r * sin_turns(turn));
    const dvec3 n = unit(random.bell3() + dvec3(0.001));
    blob.axes = axes_along(n, dvec3(n.y, -n.z, n.x) + dvec3(0.002, 0, 0));
    make_faint(blob, random, 0.02 / fineness);
    blob.opacity *= 0.35;
    blob.radiance.add(display(sky_colour(n) * 0.8));
    blob.radiance.add_lobe(n, highlight_lobe, dvec3(0.3, 0.28, 0.25));
    add_residue(blob.radiance, random, 0.03);
    sink.add(blob);
  }
}

}  // namespace swiftgs::builtin
