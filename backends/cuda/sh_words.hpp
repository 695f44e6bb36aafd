// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/frame/math.hpp>

namespace swiftgs::kernels {

/// Quadruples of floats that hold the SH coefficients of a Gaussian and `lead` floats before them.
SWIFTGS_HD constexpr unsigned rest_words(int degree, unsigned lead = 0) {
  return (lead + 3u * unsigned(sh_rest_count(degree)) + 3) / 4;
}

/// Words of 16 bytes that hold the SH coefficients of a Gaussian where rows are padded to them.
SWIFTGS_HD constexpr unsigned packed_words(HarmonicFormat format, int degree) {
  return unsigned(padded_row(format, degree) / 16);
}

/// How many quadruples those of two Gaussians lie apart in shared memory: an odd number, so that lanes that
/// read a quadruple each have no bank conflicts.
SWIFTGS_HD constexpr unsigned rest_pitch(int degree) { return rest_words(degree, 3) | 1; }

}  // namespace swiftgs::kernels
