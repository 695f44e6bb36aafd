// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The arithmetic of a pixel: from exponents to alpha, and from alphas to colour. For hosts too, which test
/// it.

#include <cmath>
#include <cstdint>

#include <vector_types.h>

#include <swiftgs/frame/raster.hpp>
#include <swiftgs/raster/store.hpp>

#include "exponents.hpp"

namespace swiftgs::kernels {

/// Alpha / alpha_max of a pixel from its log2; 0 where the pixel skips the splat. In this unit a device's
/// saturation cuts alpha. With the dynamic threshold (SwiftGS, section 5.2) the exponent decides, not its
/// exponential. A lane that skips multiplies the exponential by 0 instead of branching.
template <bool threshold>
SWIFTGS_HD float relative_alpha(float exponent, const BlendRules& rules) {
  // Every lane evaluates the exponential. Measured on an H200 when chosen: rasterizing garden takes 157 us
  // so, and 167 if lanes that skip leave it out.
  //
  // If alphas below the threshold were flushed to zero as denormal numbers, the loop would have eight
  // instructions less, and rasterizing garden would take 122 us, not 125 (measured likewise). But exponents
  // would lie near -126, where floats are coarse: squared errors of the worst views of garden, herz and fox
  // would be 1.15 to 1.5 times as large.
  const float alpha = exp2_approx(exponent), least = rules.log2_relative_min;
  const bool kept = threshold ? exponent >= least : alpha >= exp2_approx(least);
  return saturate(alpha * (kept ? 1.0f : 0.0f));
}

/// Alpha of a pixel from s, where log2(alpha) = log2(opacity) - s; 0 where the pixel skips the splat. With
/// the threshold, s <= `cutoff` decides, and lanes that skip leave out the exponential.
template <bool threshold>
SWIFTGS_HD float alpha_of_square(float s, float cutoff, float opacity, const BlendRules& rules) {
  float alpha = 0;
  if constexpr (threshold) {
    if (s >= 0 && s <= cutoff) alpha = fminf(opacity * exp2_approx(-s), rules.alpha_max);
  } else {
    const float whole = opacity * exp2_approx(-s);
    if (s >= 0 && whole >= rules.alpha_min) alpha = fminf(whole, rules.alpha_max);
  }
  return alpha;
}

/// A pixel while splats are blended into it. When it stops, its transmittance becomes 0, so later splats add
/// nothing. `stop_below` then holds the transmittance, negated, so the pixel does not stop again.
///
/// Kernels of `FloatCholesky` and `FloatSplit`, and contributions, blend alphas, weights, colours and depths
/// in units of alpha_max, but not transmittances. Other kernels blend alphas as they are.
///
/// Keep pixels in arrays of one dimension: in a two-dimensional local array of a struct with default member
/// values, nvcc 13.0 sets these values in the first row only, as its PTX shows.
struct Pixel {
  float red = 0, green = 0, blue = 0, depth = 0;
  float transmittance = 0;
  float stop_below = -1;

  SWIFTGS_HD void start(float stop, float from = 1) { transmittance = from, stop_below = stop; }
  SWIFTGS_HD bool live() const { return !std::signbit(stop_below); }
  SWIFTGS_HD void stop() { stop_with(transmittance); }
  SWIFTGS_HD void stop_with(float left) { transmittance = 0, stop_below = -left; }

  SWIFTGS_HD void add(float weight, float r, float g, float b) {
    red = fmaf(weight, r, red), green = fmaf(weight, g, green), blue = fmaf(weight, b, blue);
  }

  /// What a splat leaves of a transmittance.
  SWIFTGS_HD static float dimmed(float transmittance, float alpha) {
    return fmaf(-alpha, transmittance, transmittance);
  }
  /// The same where alphas are in units of alpha_max, by the splat's weight. The weight is rounded, by less
  /// than alpha is.
  SWIFTGS_HD static float dimmed_relative(float transmittance, float weight, float alpha_max) {
    return fmaf(-alpha_max, weight, transmittance);
  }

  SWIFTGS_HD BlendedPixel blended() const {
    return {vec3(red, green, blue), live() ? transmittance : -stop_below, depth};
  }
};

/// Splats of the first segment of a list, and of each further one. Each segment is blended by itself and
/// joined to those in front of it, so many warps may blend the segments of one list, with the bits of one
/// warp that blends them all. Most lists end within the first segment and are never cut.
/// Measured on an H200: if the first segment has 128 splats too, frames of garden and fox take 2.7 % longer.
inline constexpr unsigned first_segment_size = 512, segment_size = 128;

/// Splats before segment k.
SWIFTGS_HD constexpr std::uint32_t begin_of_segment(std::uint32_t k) {
  return k == 0 ? 0 : first_segment_size + (k - 1) * segment_size;
}

/// Segment k starts with transmittance 1 / `scale_of_segment(k)`, between 1/2 and 1, so that rounding errors
/// of segments do not correlate; compositing divides the factor out. The first starts with 1.
SWIFTGS_HD inline float scale_of_segment(std::uint32_t k) {
  return __builtin_bit_cast(float, 0x3f800000u | (k * 0x9e3779b9u) >> 9);  // one and a fraction
}

/// Transmittance within segment k below which a pixel stops; `before` is its transmittance in front of the
/// segment. Never above the segment's first transmittance: a pixel stops only when a splat dims it.
SWIFTGS_HD inline float stop_of_segment(float stop_below, float before, std::uint32_t k) {
  const float scale = scale_of_segment(k), scaled = before * scale;
  return fminf(scaled > 0 ? stop_below / scaled : 0.0f, 1 / scale);
}

/// Starts a pixel of segment k that has transmittance `before` in front of it.
SWIFTGS_HD inline void start_segment(Pixel& pixel, float stop_below, float before, std::uint32_t k) {
  pixel.start(stop_of_segment(stop_below, before, k), 1 / scale_of_segment(k));
}

/// Transmittance behind a segment, with its sign set where the pixel stops within the segment.
SWIFTGS_HD inline float mark_stopped(float transmittance, bool stopped) {
  return stopped ? -transmittance : transmittance;
}

/// Whether a pixel stops in segment k that has `before` in front of it, by the marked transmittance `left`
/// behind the segment. The segment may have been blended with more in front of it.
SWIFTGS_HD inline bool stops_in_segment(float left, float stop_below, float before, std::uint32_t k) {
  if (std::signbit(left)) return true;
  // Divide only where rounding may matter.
  return !(before * scale_of_segment(k) * left > 1.00001f * stop_below) &&
         left < stop_of_segment(stop_below, before, k);
}

/// An upper bound of the transmittance before each segment of a round: a segment that hides nothing may raise
/// it by a rounding.
SWIFTGS_HD inline float most_before(float before_round) { return before_round * 1.0001f; }

/// A pixel behind some segments.
struct JoinedPixel {
  float4 total{0, 0, 0, 1};  ///< RGB, transmittance
  float depth = 0;

  /// Joins segment k, the next.
  SWIFTGS_HD void join(const BlendedPixel& segment, std::uint32_t k) {
    const float before = total.w * scale_of_segment(k);
    total.x = fmaf(before, segment.colour.x, total.x);
    total.y = fmaf(before, segment.colour.y, total.y);
    total.z = fmaf(before, segment.colour.z, total.z);
    depth = fmaf(before, segment.depth, depth);
    total.w = before * segment.transmittance;
  }
  SWIFTGS_HD BlendedPixel blended() const { return {vec3(total.x, total.y, total.z), total.w, depth}; }

  /// The same as a pixel that has stopped.
  SWIFTGS_HD Pixel stopped() const {
    Pixel pixel;
    pixel.red = total.x, pixel.green = total.y, pixel.blue = total.z, pixel.depth = depth;
    pixel.stop_with(total.w);
    return pixel;
  }
};

/// Blends one splat into a pixel, front to back; `alpha` is 0 where the pixel skips it, and `left` the
/// transmittance behind it.
template <bool extras>
SWIFTGS_HD void blend(Pixel& pixel, float alpha, float left, const float4& colour, float occluder) {
  if (!(alpha > 0)) return;
  if (left < pixel.stop_below || (extras && pixel.live() && colour.w >= occluder)) {
    pixel.stop();
    return;
  }
  const float weight = alpha * pixel.transmittance;
  pixel.add(weight, colour.x, colour.y, colour.z);
  if (extras) pixel.depth = fmaf(weight, colour.w, pixel.depth);
  pixel.transmittance = left;
}

/// Splats of a group: they are blended together, with one test for pixels that stop.
inline constexpr unsigned group_size = 4;

/// Dims pixels by the alphas of a group of splats and finds the weights of their colours. Tests once per
/// group for stopping, since transmittance only falls; if a pixel stopped, undoes its weights from the
/// stopping splat on. One test lets the compiler evaluate all alphas before it branches.
/// Measured on an H200: with one test per pixel, frames take 1 % longer.
/// `left`: the transmittances in front of each splat, and behind the last, as if no pixel stopped.
template <unsigned count>
SWIFTGS_HD void weigh_group(Pixel (&pixels)[count], const float (&alphas)[count][group_size], float alpha_max,
                            float (&weights)[count][group_size], float (&left)[count][group_size + 1]) {
  bool some_stop = false;
  for (unsigned p = 0; p < count; ++p) {
    left[p][0] = pixels[p].transmittance;
    for (unsigned k = 0; k < group_size; ++k) {
      weights[p][k] = alphas[p][k] * left[p][k];
      left[p][k + 1] = Pixel::dimmed_relative(left[p][k], weights[p][k], alpha_max);
    }
    pixels[p].transmittance = left[p][group_size];
    some_stop = some_stop || left[p][group_size] < pixels[p].stop_below;
  }
  if (!some_stop) return;
  for (unsigned p = 0; p < count; ++p) {
    if (!(left[p][group_size] < pixels[p].stop_below)) continue;
    float last = left[p][group_size - 1];
    weights[p][group_size - 1] = 0;
    for (unsigned k = group_size - 1; k-- > 0;)
      if (left[p][k + 1] < pixels[p].stop_below) last = left[p][k], weights[p][k] = 0;
    pixels[p].stop_with(last);
  }
}

}  // namespace swiftgs::kernels
