// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What training stores, turned into what is rendered.

#include <cmath>

#include <swiftgs/math.hpp>

namespace swiftgs {

/// The opacity of a logit.
SWIFTGS_HD inline float sigmoid(float logit) { return 1 / (1 + std::exp(-logit)); }

/// The rotation of a quaternion of any length. Zero, which has no direction, becomes the identity; a
/// quaternion that is not finite yields a NaN.
SWIFTGS_HD inline Quaternion normalised(float w, float x, float y, float z) {
  const double squared = double(w) * w + double(x) * x + double(y) * y + double(z) * z;
  if (squared == 0) return {};
  const double inverse = inverse_sqrt(squared);
  return {float(w * inverse), float(x * inverse), float(y * inverse), float(z * inverse)};
}
SWIFTGS_HD inline Quaternion normalised(Quaternion q) { return normalised(q.w, q.x, q.y, q.z); }

}  // namespace swiftgs
