// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Light of the built-in scene: what a surface sends back, baked into spherical harmonics.

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "arithmetic.hpp"

namespace swiftgs::builtin {

/// Direction to the sun: low, from the left.
inline dvec3 to_sun() { return unit(at(-0.74, 0.52, -0.34)); }

/// Colour of the sky without clouds, linear light, in direction `d` (unit).
inline dvec3 sky_colour(const dvec3& d) {
  const double height = -d.y, towards_sun = dot(d, to_sun());
  const dvec3 zenith(0.08, 0.22, 0.62), middle(0.24, 0.50, 0.95), horizon(0.92, 0.80, 0.66);
  dvec3 colour = mix(middle, zenith, smooth_step(0.15, 0.9, height));
  colour = mix(horizon, colour, smooth_step(-0.03, 0.20, height));
  const double glow = clamp01(0.5 + 0.5 * towards_sun);
  return colour + dvec3(0.75, 0.42, 0.16) * (glow * glow * glow * glow * 0.7);
}

/// Linear light to what a screen is sent: highlights roll off.
inline dvec3 display(const dvec3& linear) {
  const auto curve = [](double x) { return std::sqrt(1 - power_of_two(-1.55 * (x < 0 ? 0 : x))); };
  return {curve(linear.x), curve(linear.y), curve(linear.z)};
}

/// Where light along one direction is blocked: the occluder nearest to the light over a square grid.
class ShadowMap {
 public:
  ShadowMap(const dvec3& to_light, double half_extent, int side)
      : z_(to_light),
        x_(unit(cross(dvec3(0.31, 0.11, 0.94), z_))),
        y_(cross(z_, x_)),
        cells_per_metre_(side / (2 * half_extent)),
        side_(side),
        nearest_(std::size_t(side) * side, -1e30) {}

  void add(const dvec3& p) {
    const int column = cell(dot(p, x_)), row = cell(dot(p, y_));
    const double depth = dot(p, z_);
    for (int r = row - 1; r <= row + 1; ++r)
      for (int c = column - 1; c <= column + 1; ++c)
        if (r >= 0 && c >= 0 && r < side_ && c < side_ && nearest_[std::size_t(r) * side_ + c] < depth)
          nearest_[std::size_t(r) * side_ + c] = depth;
  }

  /// The part of the light that reaches `p`, 0 to 1, softened over `radius` cells.
  double reaches(const dvec3& p, int radius) const {
    const int column = cell(dot(p, x_)), row = cell(dot(p, y_));
    const double depth = dot(p, z_) + 3.5 / cells_per_metre_;
    int lit = 0, all = 0;
    for (int r = row - radius; r <= row + radius; ++r)
      for (int c = column - radius; c <= column + radius; ++c, ++all)
        lit += r < 0 || c < 0 || r >= side_ || c >= side_ || nearest_[std::size_t(r) * side_ + c] <= depth;
    return double(lit) / all;
  }

 private:
  int cell(double metres) const {
    const double c = std::floor(metres * cells_per_metre_) + side_ / 2;
    return c < -8 ? -8 : c > side_ + 8 ? side_ + 8 : int(c);
  }

  dvec3 z_, x_, y_;
  double cells_per_metre_;
  int side_;
  std::vector<double> nearest_;
};

/// Sun and sky over the still life, with shadows and the darkening of corners.
class Light {
 public:
  Light() : sun_(to_sun(), 3.2, 800) {
    for (int k = 0; k < sky_directions; ++k) {
      const double height = (k + 0.5) / sky_directions, around = std::sqrt(1 - height * height);
      const dvec3 d = at(around * cos_turns(0.618034 * k), height, around * sin_turns(0.618034 * k));
      sky_.emplace_back(d, 3.2, 160);
      directions_.push_back(d);
    }
  }

  void add_occluder(const dvec3& p) {
    sun_.add(p);
    for (ShadowMap& map : sky_) map.add(p);
  }

  /// Light that falls on a surface at `p` with normal `n`.
  dvec3 falls_on(const dvec3& p, const dvec3& n) const {
    const double facing = dot(n, to_sun());
    dvec3 sum(0.0);
    if (facing > 0) sum += dvec3(2.3, 1.86, 1.32) * (facing * sun_.reaches(p, 2));
    for (int k = 0; k < sky_directions; ++k) {
      const double cosine = dot(n, directions_[k]);
      if (cosine > 0)
        sum += sky_colour(directions_[k]) * (1.9 / sky_directions * cosine * sky_[k].reaches(p, 1));
    }
    // Ground and walls send warm light back up.
    return sum + dvec3(0.20, 0.15, 0.10) * (0.6 + 0.4 * n.y);
  }

  double sun_reaches(const dvec3& p) const { return sun_.reaches(p, 2); }

 private:
  static constexpr int sky_directions = 14;
  ShadowMap sun_;
  std::vector<ShadowMap> sky_;
  std::vector<dvec3> directions_;
};

/// Colour as a function of the viewing direction: coefficients of the 16 SH functions of degree 0 to 3.
struct Radiance {
  std::array<dvec3, 16> coefficients{};

  /// The same colour from everywhere.
  void add(const dvec3& rgb) { coefficients[0] += rgb / 0.28209479177387814; }

  /// Adds `rgb` times the sum over l of `legendre[l]` P_l(cos a), a the angle between `towards` and the
  /// direction from the surface to the eye. By the addition theorem a coefficient is 4 pi / (2 l + 1)
  /// Y(axis).
  void add_lobe(const dvec3& towards, const std::array<double, 4>& legendre, const dvec3& rgb) {
    const double x = -towards.x, y = -towards.y, z = -towards.z, xx = x * x, yy = y * y, zz = z * z;
    const double basis[16] = {0.28209479177387814,
                              -0.4886025119029199 * y,
                              0.4886025119029199 * z,
                              -0.4886025119029199 * x,
                              1.0925484305920792 * x * y,
                              -1.0925484305920792 * y * z,
                              0.31539156525252005 * (2 * zz - xx - yy),
                              -1.0925484305920792 * x * z,
                              0.5462742152960396 * (xx - yy),
                              -0.5900435899266435 * y * (3 * xx - yy),
                              2.890611442640554 * x * y * z,
                              -0.4570457994644658 * y * (4 * zz - xx - yy),
                              0.3731763325901154 * z * (2 * zz - 3 * xx - 3 * yy),
                              -0.4570457994644658 * x * (4 * zz - xx - yy),
                              1.445305721320277 * z * (xx - yy),
                              -0.5900435899266435 * x * (xx - 3 * yy)};
    for (int l = 0, i = 0; l < 4; ++l) {
      const double weight = legendre[std::size_t(l)] * 12.566370614359172 / (2 * l + 1);
      for (int m = -l; m <= l; ++m, ++i) coefficients[std::size_t(i)] += rgb * (weight * basis[i]);
    }
  }
};

/// (1 - t^2)(1 - t): a rim as of Fresnel's law, nothing face on, nothing from behind.
inline constexpr std::array<double, 4> rim_lobe{2.0 / 3, -0.4, -2.0 / 3, 0.4};
/// A highlight: the narrowest lobe of degree 3 without visible rings, 1 at its peak.
inline constexpr std::array<double, 4> highlight_lobe{0.115, 0.295, 0.345, 0.245};
/// The same with alternating signs, so that two colours alternate across the surface.
inline constexpr std::array<double, 4> interference_lobe{0, -0.45, 0.1, 0.55};

}  // namespace swiftgs::builtin
