// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What training stores, turned into what is rendered.

#include <cmath>

#include <swiftgs/math.hpp>
#include <swiftgs/sh.hpp>

namespace swiftgs {

/// The opacity of a logit.
SWIFTGS_HD inline float sigmoid(float logit) { return 1 / (1 + std::exp(-logit)); }

/// The rotation of a quaternion of any length. Zero, which has no direction, becomes the identity; a
/// quaternion that is not finite becomes NaN.
SWIFTGS_HD inline Quaternion normalised(float w, float x, float y, float z) {
  const double squared = double(w) * w + double(x) * x + double(y) * y + double(z) * z;
  if (squared == 0) return {};
  if (!std::isfinite(squared)) return {.w = __builtin_nanf("")};
  const double inverse = 1 / std::sqrt(squared);
  return {float(w * inverse), float(x * inverse), float(y * inverse), float(z * inverse)};
}

/// The SH coefficient of band 0 of a Gaussian whose colour is the same from everywhere.
SWIFTGS_HD inline vec3 sh0_of(vec3 colour) {
  const auto coefficient = [](float value) { return float((double(value) - 0.5) / sh::c0); };
  return {coefficient(colour.x), coefficient(colour.y), coefficient(colour.z)};
}

}  // namespace swiftgs
