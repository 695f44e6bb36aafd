// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "blending.hpp"

namespace swiftgs::kernels {

/// Dims a pixel by one splat as `blend` does, and returns the splat's weight; `alpha` is 0 where the pixel
/// skips the splat.
SWIFTGS_HD inline float weigh(Pixel& pixel, float alpha) {
  if (!(alpha > 0)) return 0;
  const float left = Pixel::dimmed(pixel.transmittance, alpha);
  if (left < pixel.stop_below) {
    pixel.stop();
    return 0;
  }
  const float weight = alpha * pixel.transmittance;
  pixel.transmittance = left;
  return weight;
}

}  // namespace swiftgs::kernels
