// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Spherical harmonics in long double, from recurrences: no polynomial is written out.

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace swiftgs::test {

using Real = long double;
static_assert(std::numeric_limits<Real>::digits >= 64, "the oracle needs more digits than double has");

inline constexpr Real pi = 3.14159265358979323846264338327950288L;

/// The factor of Y_l^m that depends on z alone: the associated Legendre function with the Condon-Shortley
/// sign, over the m-th power of the sine of the polar angle.
inline Real legendre_over_sine(int l, int m, Real z) {
  Real before = 0, value = 1;
  for (int i = 1; i <= m; ++i) value *= -Real(2 * i - 1);
  for (int n = m + 1; n <= l; ++n) {
    const Real next = (Real(2 * n - 1) * z * value - Real(n + m - 1) * before) / Real(n - m);
    before = value, value = next;
  }
  return value;
}

/// The real harmonics of bands 0 to 3 at the unit vector (x, y, z), index l^2 + l + m.
inline std::array<Real, 16> oracle_harmonics(Real x, Real y, Real z) {
  std::array<Real, 16> values{};
  // Powers of x + iy are sin^m (cos(m phi) + i sin(m phi)).
  Real cosine = 1, sine = 0;
  for (int m = 0; m <= 3; ++m) {
    for (int l = m; l <= 3; ++l) {
      Real ratio = 1;  // (l - m)! / (l + m)!
      for (int i = l - m + 1; i <= l + m; ++i) ratio /= Real(i);
      const Real norm = std::sqrt(Real(2 * l + 1) / (4 * pi) * ratio * (m == 0 ? 1 : 2));
      const Real common = norm * legendre_over_sine(l, m, z);
      values[std::size_t(l * l + l + m)] = common * cosine;
      if (m > 0) values[std::size_t(l * l + l - m)] = common * sine;
    }
    const Real turned = x * cosine - y * sine;
    sine = x * sine + y * cosine, cosine = turned;
  }
  return values;
}

}  // namespace swiftgs::test
