// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace swiftgs::io {

/// A coordinate as SOG stores it, `sign(x) log(1 + |x|)`: rounding is finest near zero.
inline double signed_logarithm(double value) { return std::copysign(std::log1p(std::abs(value)), value); }

/// The coordinate of a signed logarithm.
inline double signed_exponential(double logarithm) {
  return std::copysign(std::exp(std::abs(logarithm)) - 1, logarithm);
}

}  // namespace swiftgs::io
