// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The terrace of the built-in scene: mosaic and kerb.

#include <cmath>

#include "emit.hpp"

namespace swiftgs::builtin {

/// Terrace: tiles in rings around the drum, laid in a sunburst, with joints between them.
inline Surface terrace_tiles() {
  Surface s;
  s.point = [](double u, double v) {
    const double r = 2.7 * std::sqrt(v);
    return at(r * cos_turns(u), 0, r * sin_turns(u));
  };
  s.material = [](double u, double v, dvec3& p) {
    constexpr double width = 0.225;
    const double r = 2.7 * std::sqrt(v), ring = std::floor(r / width);
    const double tiles = std::floor(6.2832 * (ring + 0.5)), tile = std::floor(u * tiles);
    const double across = r / width - ring - 0.5, beside = u * tiles - tile - 0.5;
    if (std::abs(across) > 0.44 || std::abs(beside) > 0.44)
      return Material{.body = dvec3(0.17, 0.15, 0.13) * (0.7 + 0.6 * noise(p * 30.0))};
    // Draw the point towards the middle of its tile, away from the joint.
    const double r2 = width * (ring + 0.5 + across * 0.9), u2 = (tile + 0.5 + beside * 0.9) / tiles;
    p = at(r2 * cos_turns(u2), 0.004 + 0.006 * cell_value(int(ring), int(tile), 3), r2 * sin_turns(u2));
    const double shade_of_tile = cell_value(int(ring), int(tile), 1), middle = (tile + 0.5) / tiles;
    const double ray = std::abs(2 * (14 * middle - std::floor(14 * middle)) - 1);
    const double reach = (ring - 4) / 5;
    dvec3 colour(0.62, 0.53, 0.41);
    if (ring < 3)
      colour = dvec3(0.30, 0.25, 0.22);
    else if (ring == 3 || ring == 10)
      colour = dvec3(0.06, 0.15, 0.30);
    else if (ring == 11)
      colour = std::fmod(tile, 2) < 1 ? dvec3(0.74, 0.66, 0.52) : dvec3(0.08, 0.28, 0.36);
    else if (ring == 4 || ring == 9)
      colour = dvec3(0.50, 0.20, 0.11);
    else if (ring < 9)
      colour = ray > reach ? dvec3(0.70, 0.61, 0.47) : dvec3(0.13, 0.32, 0.36);
    colour *= 0.82 + 0.36 * shade_of_tile;
    const bool glazed = shade_of_tile > 0.8;
    return Material{.body = colour, .highlight = dvec3(glazed ? 0.22 : 0.08), .rim = dvec3(0.10, 0.12, 0.15)};
  };
  s.cover = 0.64;
  s.stretch = 0.2;
  s.faint = 0.38;
  s.roughness = 0.02;
  return s;
}

/// A rounded kerb around the terrace.
inline Surface kerb() {
  Surface s;
  s.point = [](double u, double v) {
    const double r = 2.82 + 0.15 * cos_turns(0.55 * (0.5 - v) + 0.25),
                 h = 0.14 * sin_turns(0.55 * (0.5 - v) + 0.25);
    return at(r * cos_turns(u), h - 0.02, r * sin_turns(u));
  };
  s.material = [](double u, double, dvec3& p) {
    const double joint = std::abs(40 * u - std::floor(40 * u) - 0.5);
    const double grain = 0.75 + 0.4 * layered_noise(p * 7.0, 3);
    return Material{.body = dvec3(0.60, 0.54, 0.46) * (joint > 0.485 ? 0.4 : grain), .rim = dvec3(0.06)};
  };
  return s;
}

}  // namespace swiftgs::builtin
