// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "blending.hpp"

namespace swiftgs::kernels {

/// Dims a pixel by one splat, and returns the splat's weight; `alpha` is in units of alpha_max, and 0 where
/// the pixel skips the splat.
SWIFTGS_HD inline float weigh(Pixel& pixel, float alpha, float alpha_max) {
  if (!(alpha > 0)) return 0;
  const float weight = alpha * pixel.transmittance;
  const float left = Pixel::dimmed_relative(pixel.transmittance, weight, alpha_max);
  if (left < pixel.stop_below) {
    pixel.stop();
    return 0;
  }
  pixel.transmittance = left;
  return weight * alpha_max;
}

}  // namespace swiftgs::kernels
