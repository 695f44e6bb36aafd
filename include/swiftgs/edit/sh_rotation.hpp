// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include <swiftgs/math.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/sh.hpp>

namespace swiftgs {

/// Rotates spherical harmonics: with the rotated coefficients, a Gaussian looks along a rotated direction as
/// it did along the direction itself. Exact in all bands, up to the rounding of coefficients to float.
class ShRotation {
 public:
  /// For bands 1 to `degree`, 0 to 3, and an orthonormal matrix, which may be a mirror. Throws
  /// `InvalidArgument` for any other degree.
  ShRotation(const dmat3& rotation, int degree) : degree_(degree) {
    if (degree < 0 || degree > max_sh_degree)
      detail::refuse("ShRotation: degree is ", degree, ", expected 0 to 3");
    // Entry (m, n) of a band's matrix is the integral of Y_m(R d) Y_n(d) over all directions d. A product of
    // two functions of band 3 is a polynomial of degree 6, and this rule is exact up to degree 7: Gauss and
    // Legendre's four heights, with eight directions at each.
    constexpr double heights[] = {-0.86113631159405258, -0.33998104358485626, 0.33998104358485626,
                                  0.86113631159405258};
    constexpr double weights[] = {0.34785484513745386, 0.65214515486254614, 0.65214515486254614,
                                  0.34785484513745386};
    constexpr int around = 8;
    constexpr double turn = 2 * 3.14159265358979323846 / around;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < around; ++j) {
        const double z = heights[i], radius = std::sqrt(1 - z * z);
        const dvec3 from(radius * std::cos(turn * j), radius * std::sin(turn * j), z);
        double before[sh_rest_count(max_sh_degree)], after[sh_rest_count(max_sh_degree)];
        sh_basis(degree, from, before);
        sh_basis(degree, rotation * from, after);
        for_each_entry(entries_, [&](double& entry, int m, int n) {
          entry += weights[i] * turn * after[m] * before[n];
        });
      }
  }

  /// Rotates the coefficients of a Gaussian in place. @shape{sh_rest_count(degree), 3}
  void apply(float* rest) const {
    std::array<double, 3 * sh_rest_count(max_sh_degree)> rotated{};
    for_each_entry(entries_, [&](double entry, int m, int n) {
      for (int channel = 0; channel < 3; ++channel)
        rotated[std::size_t(3 * m + channel)] += entry * double(rest[3 * n + channel]);
    });
    for (int k = 0; k < 3 * sh_rest_count(degree_); ++k) rest[k] = float(rotated[std::size_t(k)]);
  }

 private:
  /// f(entry, m, n) for each entry of each band's matrix; m and n count from the first function of band 1.
  template <class Entries, class F>
  void for_each_entry(Entries& entries, const F& f) const {
    std::size_t k = 0;
    for (int band = 1; band <= degree_; ++band)
      for (int m = sh_rest_count(band - 1); m < sh_rest_count(band); ++m)
        for (int n = sh_rest_count(band - 1); n < sh_rest_count(band); ++n) f(entries[k++], m, n);
  }

  int degree_;
  std::array<double, 9 + 25 + 49> entries_{};
};

}  // namespace swiftgs
