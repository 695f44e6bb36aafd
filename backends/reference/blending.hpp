// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include <swiftgs/conventions.hpp>

#include "projection.hpp"

namespace swiftgs::reference {

/// What a pixel has collected so far.
struct Pixel {
  Eigen::Vector3d colour = Eigen::Vector3d::Zero();  ///< sum of weight * colour
  double transmittance = 1;
  double weight = 0;  ///< sum of weights
  double depth = 0;   ///< sum of weight * depth
  bool stopped = false;
  float occluder = std::numeric_limits<float>::infinity();  ///< a splat of this depth or more is hidden
};

/// Offers `splat`, whose exponent and depth at this pixel are `sigma` and `depth`, to `pixel`; true when it
/// contributed.
inline bool blend(Pixel& pixel, const Splat& splat, double sigma, double depth, const Conventions& k) {
  const double alpha = std::min(double(k.alpha_max), splat.opacity * std::exp(-sigma));
  if (!(alpha >= double(k.alpha_min))) return false;
  const double next = pixel.transmittance * (1 - alpha), stop = k.stop;
  // Depths are compared as they are sorted, rounded to float. Where they are those of means, all that follow
  // are hidden as well.
  const bool hidden = float(depth) >= pixel.occluder, along_ray = k.depth_at == Conventions::DepthAt::ray;
  if (hidden && along_ray) return false;
  if (hidden || (k.stop_at_equal ? next <= stop : next < stop)) {
    pixel.stopped = true;
    return false;
  }
  const double weight = alpha * pixel.transmittance;
  pixel.colour += weight * splat.colour;
  pixel.weight += weight;
  pixel.depth += weight * depth;
  pixel.transmittance = next;
  return true;
}

/// Offers `splat` to the pixels of image row `y`, of which `pixels` is the first; returns to how many it
/// contributed.
inline std::uint64_t blend_row(Pixel* pixels, int y, const Splat& splat, const Conventions& k) {
  const double dy = y + 0.5 - splat.y;
  const double y_term = splat.y_weight * dy * dy;
  const double left = splat.cutoff - y_term;
  if (!(left >= 0)) return 0;

  // Solve 2 sigma <= cutoff for x; the slack is far above what rounding can move the two roots.
  const double offset = splat.shear * dy, half = std::sqrt(left / splat.x_weight);
  const double slack = 1 + 1e-9 * (std::abs(offset) + half);
  const double middle = splat.x + offset - 0.5;
  const auto column = [&](double x) {
    return int(std::clamp(x, double(splat.x_begin), double(splat.x_end)));
  };
  const int begin = column(std::ceil(middle - half - slack));
  const int end = column(std::floor(middle + half + slack) + 1);

  std::uint64_t contributions = 0;
  for (int x = begin; x < end; ++x) {
    if (pixels[x].stopped) continue;
    const double dx = x + 0.5 - splat.x;
    const double along = dx - offset;
    const double twice_sigma = splat.x_weight * along * along + y_term;
    if (twice_sigma > splat.cutoff) continue;
    contributions += blend(pixels[x], splat, 0.5 * twice_sigma, splat.depth_at(x, y), k);
  }
  return contributions;
}

}  // namespace swiftgs::reference
