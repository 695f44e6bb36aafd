// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What pixels pick within the segments of a list. For hosts too, which test it.

#include <cmath>
#include <cstdint>

#include <swiftgs/plane/picks.hpp>

#include "blending.hpp"

namespace swiftgs::kernels {

/// Splats that a pixel picks from some segments.
struct alignas(16) JoinedPicks {
  std::uint32_t first = SplatPicks::none, median = SplatPicks::none, largest = SplatPicks::none;
  float weight = 0;  ///< of the largest

  /// Joins the next segment, whose weights are in units of `unit`.
  SWIFTGS_HD void join(const JoinedPicks& segment, float unit) {
    if (first == SplatPicks::none) first = segment.first;
    if (median == SplatPicks::none) median = segment.median;
    const float of_segment = unit * segment.weight;
    if (of_segment > weight) weight = of_segment, largest = segment.largest;
  }
};

/// Limits of the transmittance that a pixel has not passed. A splat is picked if the transmittance is above
/// the limit in front of it, or at it, and below the limit behind it.
struct PickLimits {
  static constexpr float passed = NAN;  ///< nothing is below it, nor above

  float first = passed, median = passed;

  /// The limits left after `picks`.
  SWIFTGS_HD PickLimits behind(const JoinedPicks& picks) const {
    return {picks.first == SplatPicks::none ? first : passed,
            picks.median == SplatPicks::none ? median : passed};
  }
  /// The limits left behind a segment with transmittance `left`. `relative`: these limits in units of the
  /// segment.
  SWIFTGS_HD PickLimits behind(const PickLimits& relative, float left) const {
    return {left < relative.first ? passed : first, left < relative.median ? passed : median};
  }
  SWIFTGS_HD bool some_above(float left) const { return left < first || left < median; }

  /// In units of segment k, which has transmittance `before` in front of it. None is above the segment's
  /// first transmittance: only a splat passes a limit.
  SWIFTGS_HD PickLimits in_segment(float before, std::uint32_t k) const {
    const float unit = before * scale_of_segment(k), most = 1 / scale_of_segment(k);
    const auto scaled = [&](float limit) {
      return limit > 0 ? unit > 0 ? fminf(limit / unit, most) : most : passed;
    };
    return {scaled(first), scaled(median)};
  }
};

}  // namespace swiftgs::kernels
