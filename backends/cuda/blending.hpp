// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The arithmetic of a pixel: from exponents to alpha, and from alphas to colour. For hosts too, which test
/// it.

#include <cmath>
#include <cstdint>

#include <vector_types.h>

#include <swiftgs/raster/raster.hpp>
#include <swiftgs/store_pixel.hpp>

#include "arithmetic.hpp"

namespace swiftgs::kernels {

/// Alpha of a pixel from its exponent log2(alpha), 0 where it skips the splat. With the dynamic threshold
/// (SwiftGS, section 5.2) the exponent decides, before the exponential. A lane that skips cannot leave its
/// warp: its exponential is that of minus infinity, and nothing after it asks again.
template <bool threshold>
SWIFTGS_HD float alpha_of(float exponent, const BlendRules& rules) {
  if constexpr (threshold) {
    const bool kept = exponent >= rules.log2_alpha_min;
    return fminf(exp2_approx(kept ? exponent : -INFINITY), rules.alpha_max);
  } else {
    const float alpha = exp2_approx(exponent);
    return alpha >= rules.alpha_min ? fminf(alpha, rules.alpha_max) : 0.0f;
  }
}

/// Alpha of a pixel from s, where log2(alpha) = log2(opacity) - s, of which `reach` is the largest that is
/// kept; 0 where the pixel skips the splat. With the threshold s decides, and lanes that skip leave out the
/// exponential.
template <bool threshold>
SWIFTGS_HD float alpha_of_square(float s, float reach, float opacity, const BlendRules& rules) {
  float alpha = 0;
  if constexpr (threshold) {
    if (s >= 0 && s <= reach) alpha = fminf(opacity * exp2_approx(-s), rules.alpha_max);
  } else {
    const float whole = opacity * exp2_approx(-s);
    if (s >= 0 && whole >= rules.alpha_min) alpha = fminf(whole, rules.alpha_max);
  }
  return alpha;
}

/// A pixel while splats are blended into it. When it stops, its transmittance moves to `last` and becomes
/// zero, so that whatever follows adds nothing, and `stop_below` becomes negative, so that it does not stop
/// again.
struct Pixel {
  float red = 0, green = 0, blue = 0, depth = 0;
  float transmittance = 0, last = 1;
  float stop_below = -1;

  SWIFTGS_HD void start(float stop) { transmittance = 1, stop_below = stop; }
  SWIFTGS_HD bool live() const { return stop_below >= 0; }
  SWIFTGS_HD void stop() { stop_with(transmittance); }
  SWIFTGS_HD void stop_with(float left) { last = left, transmittance = 0, stop_below = -1; }

  SWIFTGS_HD void add(float weight, float r, float g, float b) {
    red = fmaf(weight, r, red), green = fmaf(weight, g, green), blue = fmaf(weight, b, blue);
  }

  /// What is left of 1, of which `alpha` was covered.
  SWIFTGS_HD static float dimmed(float transmittance, float alpha) {
    return fmaf(-alpha, transmittance, transmittance);
  }

  SWIFTGS_HD BlendedPixel blended() const {
    return {vec3(red, green, blue), live() ? transmittance : last, depth};
  }
};

/// Counts of one thread.
struct ThreadCounts {
  std::uint32_t pairs = 0, stopped = 0;
};

/// Blends one splat into a pixel, front to back; `alpha` is 0 where the pixel skips it.
template <bool extras>
SWIFTGS_HD void blend(Pixel& pixel, float alpha, const float4& colour, float occluder, ThreadCounts& counts) {
  if (!(alpha > 0)) return;
  const float left = Pixel::dimmed(pixel.transmittance, alpha);
  if (left < pixel.stop_below || (extras && pixel.live() && colour.w >= occluder)) {
    if (extras) ++counts.stopped;
    pixel.stop();
    return;
  }
  const float weight = alpha * pixel.transmittance;
  pixel.add(weight, colour.x, colour.y, colour.z);
  if (extras) pixel.depth = fmaf(weight, colour.w, pixel.depth), counts.pairs += pixel.live();
  pixel.transmittance = left;
}

/// Splats that are blended together, and looked at for pixels that stop.
inline constexpr unsigned group_size = 4;

/// Dims a pixel by the alphas of a group, and finds the weights of its colours. Whether the pixel stops is
/// looked at once for the whole group, since transmittance only falls; where it does, the splats from the one
/// on that would have stopped it are taken back.
SWIFTGS_HD inline void weigh_group(Pixel& pixel, const float (&alphas)[group_size],
                                   float (&weights)[group_size]) {
  float left[group_size + 1];
  left[0] = pixel.transmittance;
  for (unsigned k = 0; k < group_size; ++k) {
    weights[k] = alphas[k] * left[k];
    left[k + 1] = Pixel::dimmed(left[k], alphas[k]);
  }
  pixel.transmittance = left[group_size];
  if (left[group_size] < pixel.stop_below) {
    float last = left[group_size - 1];
    weights[group_size - 1] = 0;
    for (unsigned k = group_size - 1; k-- > 0;)
      if (left[k + 1] < pixel.stop_below) last = left[k], weights[k] = 0;
    pixel.stop_with(last);
  }
}

}  // namespace swiftgs::kernels
