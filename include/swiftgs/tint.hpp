// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <swiftgs/finite.hpp>
#include <swiftgs/math.hpp>

namespace swiftgs {

/// A colour that is mixed into the colours of a scene's Gaussians, such as a highlight. By default nothing is
/// mixed in.
struct Tint {
  vec3 colour{1.0f};  ///< RGB, in the scene's own values, 0 or more
  float amount = 0;   ///< 0 to 1: 0 leaves the Gaussians' colours, 1 shows `colour` alone

  /// Says what was expected, or is null if it is valid.
  SWIFTGS_HD const char* unmet() const {
    if (!(amount >= 0 && amount <= 1)) return "a tint with an amount of 0 to 1";
    const bool shown = colour.x >= 0 && colour.y >= 0 && colour.z >= 0;
    return shown && detail::is_finite(colour) ? nullptr : "a tint with a finite colour of 0 or more";
  }
  SWIFTGS_HD bool is_none() const { return amount == 0; }

  /// (1 - amount) `from` + amount `colour`, where `from` is finite and 0 or more, and so is the result. All
  /// backends answer alike.
  SWIFTGS_HD vec3 mixed_into(vec3 from) const {
    const float most = 3.4028234663852886e38f;  // rounding may pass it
    vec3 mixed;
    for (int c = 0; c < 3; ++c) {
      const float sum = std::fma(amount, colour[c], (1 - amount) * from[c]);
      mixed[c] = sum < most ? sum : most;
    }
    return mixed;
  }
};

}  // namespace swiftgs
