// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Blending in double, pixel by pixel over all splats: what the rasterizers are compared with.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "policies/rasterizers.hpp"

namespace swiftgs::test {

struct DoubleDrawing {
  std::vector<double> colour, alpha, depth;
  std::uint64_t contributing_pairs = 0, pixels_stopped = 0;
};

/// Draws `splats` from their own numbers: no tiles, no bounds.
inline DoubleDrawing draw_in_double(const SplatSet& splats, int width, int height,
                                    const DrawSettings& settings = {}) {
  std::vector<std::size_t> order(splats.shapes.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return splats.depths[a] < splats.depths[b]; });
  DoubleDrawing out;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double colour[3] = {}, depth = 0, transmittance = 1;
      for (const std::size_t i : order) {
        const SplatShape& shape = splats.shapes[i];
        const double dx = x + 0.5 - shape.exact_mean().x, dy = y + 0.5 - shape.exact_mean().y;
        const double u = double(shape.l0) * dx + double(shape.l1) * dy, v = double(shape.l2) * dy;
        const double alpha =
            std::min(double(shape.opacity) * std::exp2(-(u * u + v * v)), double(settings.rules.alpha_max));
        if (alpha < double(settings.rules.alpha_min)) continue;
        const double next = transmittance * (1 - alpha);
        if (next < double(settings.rules.stop_below)) {
          ++out.pixels_stopped;
          break;
        }
        const double weight = alpha * transmittance;
        for (int c = 0; c < 3; ++c) colour[c] += weight * double(splats.colours[i].rgb[c]);
        depth += weight * double(splats.colours[i].depth);
        transmittance = next;
        ++out.contributing_pairs;
      }
      for (int c = 0; c < 3; ++c)
        out.colour.push_back(colour[c] + transmittance * double(settings.background[c]));
      out.alpha.push_back(1 - transmittance);
      out.depth.push_back(transmittance < 1 ? depth / (1 - transmittance) : 0);
    }
  return out;
}

/// How two images differ.
struct Difference {
  double largest = 0;
  double part_above = 0;  ///< of all values, those that differ by more than `limit`
};

/// `limit`: what rounding alone may do. A value that is not a number differs infinitely.
template <class A, class B>
Difference difference(const A& a, const B& b, double limit) {
  Difference out;
  for (std::size_t i = 0; i < a.size(); ++i) {
    double d = std::abs(double(a[i]) - double(b[i]));
    if (!(d >= 0)) d = INFINITY;
    out.largest = std::max(out.largest, d);
    out.part_above += d > limit;
  }
  out.part_above /= double(a.size());
  return out;
}

/// Splats of the sizes that trained scenes have, colours up to 1, all in front.
inline SplatSet usual_splats(std::size_t count, int width, int height, std::uint64_t seed) {
  Random random(seed);
  SplatSet set;
  for (std::size_t i = 0; i < count; ++i)
    set.add(usual_splat(random, width, height), random.f(0.5, 20),
            vec3(random.f(0, 1), random.f(0, 1), random.f(0, 1)));
  return set;
}

/// Adds needles through an image of 64 x 64 pixels whose centres lie far outside: squared terms beyond the
/// largest half.
inline void add_needles(SplatSet& splats, std::uint64_t seed) {
  Random random(seed);
  for (int i = 0; i < 300; ++i) {
    const double angle = random.in(0, 3.14159), away = random.in(-3000, 3000);
    splats.add(make_splat(32 + away * std::cos(angle), 32 + away * std::sin(angle), 4000, 0.6, angle, 0.9),
               random.f(1, 2));
  }
}

}  // namespace swiftgs::test
