// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The oracle's projection in long double, written from docs/conventions.md. Beside each number it bounds how
/// far double arithmetic may stray from it.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/scene.hpp>

#include "reference/oracle_harmonics.hpp"

namespace swiftgs::test {

using Real3 = std::array<Real, 3>;

/// Half the distance from 1 to the next double: the relative error of one operation.
inline constexpr Real unit = 0x1p-53L;

/// Pixels [x_begin, x_end) x [y_begin, y_end).
struct PixelRect {
  int x_begin = 0, x_end = 0, y_begin = 0, y_end = 0;
  bool holds(int x, int y) const { return x >= x_begin && x < x_end && y >= y_begin && y < y_end; }
};

/// Limits of what double arithmetic may find for a splat.
struct SplatDoubt {
  Real position_x = 0, position_y = 0;  ///< error of the mean @units{pixels}
  Real x_weight = 0, y_weight = 0;      ///< relative errors of the weights of the two squares
  Real shear = 0, opacity = 0;          ///< absolute, relative
  Real z = 0;                           ///< absolute
  Real3 colour{};                       ///< absolute
  Real normal = 0;                      ///< absolute; 2 where rounding may turn it to the other side
  float nearest = 0, furthest = 0;      ///< what orders the splat, z or distance, as a float
  Real slope = 0;                       ///< length of the error, absolute
  PixelRect surely;                     ///< part of `footprint` in any case
  bool drawn = false;                   ///< whether the Gaussian is drawn at all is in doubt
};

/// A projected Gaussian. Its covariance is L L^T with L = (l00, 0; l10, l11).
struct OracleSplat {
  Real x = 0, y = 0, z = 0, l00 = 0, l10 = 0, l11 = 0, opacity = 0;
  Real3 colour{}, normal{};
  Real slope_x = 0, slope_y = 0;  ///< of depth along the ray
  Span<const float> features{};
  float depth = 0, order = 0;
  std::size_t index = 0;
  bool drawn = true;    ///< false where only a doubt keeps the splat in the list
  PixelRect footprint;  ///< what the convention's footprint leaves; in doubt, the larger of two
  Real x_weight = 0, y_weight = 0, shear = 0;  ///< of the reference's form, which errors are bounded for
  SplatDoubt doubt;
};

inline Real dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Real3 cross(const Real3& a, const Real3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Real3 magnitudes(const Real3& a) { return {std::abs(a[0]), std::abs(a[1]), std::abs(a[2])}; }

/// Row `row` of a rotation.
inline Real3 row_of(const dmat3& rotation, int row) {
  return {rotation[0][row], rotation[1][row], rotation[2][row]};
}
inline Real3 row_of(const Camera& camera, int row) { return row_of(camera.rotation, row); }

/// `v` turned by q as it is stored: v + 2 w (u x v) + 2 u x (u x v).
inline Real3 turn(Quaternion q, const Real3& v) {
  const Real3 u{q.x, q.y, q.z}, once = cross(u, v), twice = cross(u, once);
  Real3 turned;
  for (std::size_t k = 0; k < 3; ++k) turned[k] = v[k] + 2 * q.w * once[k] + 2 * twice[k];
  return turned;
}

/// How a Gaussian's unit sphere maps to the image, and the error of each number.
struct ImageFactor {
  Real3 x, y, x_error, y_error;
};

/// The Cholesky factor of the covariance, by Givens rotations of (factor | root of blur times identity): the
/// covariance itself is never formed.
struct Triangle {
  Real l00 = 0, l10 = 0, l11 = 0;

  Triangle(const ImageFactor& f, Real blur) {
    const Real root = std::sqrt(blur);
    std::array<Real, 5> x{f.x[0], f.x[1], f.x[2], root, 0}, y{f.y[0], f.y[1], f.y[2], 0, root};
    for (std::size_t k = 1; k < 5; ++k) {
      const Real length = std::hypot(x[0], x[k]);
      if (length == 0) continue;
      const Real c = x[0] / length, s = x[k] / length, turned = c * y[0] + s * y[k];
      y[k] = c * y[k] - s * y[0], y[0] = turned, x[0] = length;
    }
    l00 = x[0], l10 = y[0];
    for (std::size_t k = 1; k < 5; ++k) l11 = std::hypot(l11, y[k]);
  }
  Real xx() const { return l00 * l00; }
  Real xy() const { return l00 * l10; }
  Real yy() const { return l10 * l10 + l11 * l11; }
  Real determinant() const { return l00 * l00 * l11 * l11; }
};

/// Errors of what double makes of `f`: variances, determinants with and without blur, relative opacity.
/// First-order bounds: each number's own error carried through, plus a few units for each operation.
inline void bound_shape(const ImageFactor& f, const Triangle& l, const Triangle& sharp, const Conventions& k,
                        OracleSplat& s) {
  Real xx = 0, xy = 0, yy = 0, det_sharp = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Real x = std::abs(f.x[i]), y = std::abs(f.y[i]), ex = f.x_error[i], ey = f.y_error[i];
    xx += 2 * x * ex + ex * ex, yy += 2 * y * ey + ey * ey,
        xy += x * ey + y * ex + ex * ey + 4 * unit * x * y;
    for (std::size_t j = i + 1; j < 3; ++j) {
      const Real v = std::abs(f.y[j]), u = std::abs(f.x[j]);
      const Real minor = std::abs(f.x[i] * f.y[j] - f.x[j] * f.y[i]);
      const Real error = x * f.y_error[j] + v * ex + u * ey + y * f.x_error[j] + 2 * unit * (x * v + u * y);
      det_sharp += 2 * minor * error + error * error;
    }
  }
  xx += 4 * unit * l.xx(), yy += 4 * unit * l.yy(), det_sharp += 4 * unit * sharp.determinant();
  const Real det = det_sharp + k.blur.value_or(0.3f) * (xx + yy) + 8 * unit * l.determinant();

  s.x_weight = l.yy() / l.determinant(), s.y_weight = 1 / l.yy(), s.shear = l.xy() / l.yy();
  // The rotations here lose digits of long double too, as many as the splat is long in widths.
  const Real own = 64 * 0x1p-64L * std::sqrt(l.xx() * l.yy() / l.determinant());
  s.doubt.y_weight = yy / l.yy() + 4 * unit;
  s.doubt.x_weight = s.doubt.y_weight + det / l.determinant() + own;
  s.doubt.shear = xy / l.yy() + std::abs(s.shear) * s.doubt.y_weight;
  s.doubt.opacity = 8 * unit;
  if (k.antialiased.value_or(false)) {
    const Real ratio = sharp.determinant() / l.determinant();
    s.doubt.opacity +=
        (det_sharp + ratio * det) / l.determinant() / std::max(ratio, Real(k.min_compensation));
  }
}

/// The tiles that INRIA's square selects, as its code has them: pixel centres are whole numbers there, and
/// conversions to int cut towards zero.
inline PixelRect inria_square(const OracleSplat& s, Real radius, Real shrink, const Camera& camera) {
  const auto tile = [](Real value, int side) {
    const Real limited = std::min(std::max(value / 16, Real(0)), Real((side + 15) / 16));
    return std::min(side, 16 * int(limited));
  };
  const Real x = s.x - 0.5L, y = s.y - 0.5L;
  return {tile(x - radius + shrink, camera.width), tile(x + radius + 15 - shrink, camera.width),
          tile(y - radius + shrink, camera.height), tile(y + radius + 15 - shrink, camera.height)};
}

inline void set_footprint(OracleSplat& s, const Triangle& l, const Camera& camera, const Conventions& k) {
  s.footprint = s.doubt.surely = {0, camera.width, 0, camera.height};
  if (k.footprint != Conventions::Footprint::three_sigma_square) return;
  const Real half = (l.xx() - l.yy()) / 2, gap = std::max(Real(0.1), half * half + l.xy() * l.xy());
  const Real sides = 3 * std::sqrt((l.xx() + l.yy()) / 2 + std::sqrt(gap));
  const Real slack = sides * (s.doubt.x_weight + s.doubt.y_weight + 16 * unit);
  const Real shift =
      s.doubt.position_x + s.doubt.position_y + 32 * unit * (std::abs(s.x) + std::abs(s.y) + sides);
  s.footprint = inria_square(s, std::ceil(sides + slack), -shift, camera);
  s.doubt.surely = inria_square(s, std::ceil(sides - slack), shift, camera);
}

}  // namespace swiftgs::test
