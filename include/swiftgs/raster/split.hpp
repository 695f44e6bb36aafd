// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The paper's split of an exponent into a term of the column, one of the row and a product of both.

#include <string_view>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/half.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/raster/exponents.hpp>

namespace swiftgs {

/// The paper's split in float: s = (a x^2 + d x) + (c y^2 + e y + g) + (b x) y, with x and y measured from
/// the raster block's centre: a distant mean costs only its own digits. The three parts may still cancel;
/// negative s is set to 0. With u = l0 dx + l1 dy and v = l2 dy at a pixel, the error of s is at most 2^-18
/// ((|u| + 16 l0 + 16 |l1|)^2 + (|v| + 16 l2)^2), beside what the rounding of u and v at the raster block's
/// centre makes of it, as in every representation.
struct SWIFTGS_API FloatSplit {
  static constexpr std::string_view name = "float-split";
  struct X {
    float square, mixed;  ///< a x^2 + d x, b x
  };
  struct Y {
    float square, offset;  ///< c y^2 + e y + g, y
  };

  SWIFTGS_HD FloatSplit(const SplatShape& s, vec2 centre) : centre_(centre) {
    const vec2 from_mean = s.from_mean(centre);
    const float u = s.l0 * from_mean.x + s.l1 * from_mean.y, v = s.l2 * from_mean.y;
    a_ = s.l0 * s.l0, b_ = 2 * s.l0 * s.l1, c_ = s.l1 * s.l1 + s.l2 * s.l2;
    d_ = 2 * s.l0 * u, e_ = 2 * (s.l1 * u + s.l2 * v), g_ = u * u + v * v;
  }
  SWIFTGS_HD X x_term(float at) const {
    const float x = at - centre_.x;
    return {(a_ * x + d_) * x, b_ * x};
  }
  SWIFTGS_HD Y y_term(float at) const {
    const float y = at - centre_.y;
    return {(c_ * y + e_) * y + g_, y};
  }
  SWIFTGS_HD static float exponent(X x, Y y) {
    const float s = x.square + y.square + x.mixed * y.offset;
    return s < 0 ? 0 : s;
  }

 private:
  vec2 centre_;
  float a_, b_, c_, d_, e_, g_;
};

namespace detail {
/// The terms of the paper's split before they are rounded to half.
struct MeanSplit {
  const SplatShape& shape;
  float a, b, c;  ///< s = a dx^2 + b dx dy + c dy^2

  SWIFTGS_HD explicit MeanSplit(const SplatShape& s)
      : shape(s), a(s.l0 * s.l0), b(2 * s.l0 * s.l1), c(s.l1 * s.l1 + s.l2 * s.l2) {}
  SWIFTGS_HD vec2 x_term(float at) const {
    const float dx = shape.right_of_mean(at);
    return {a * dx * dx, b * dx};
  }
  SWIFTGS_HD vec2 y_term(float at) const {
    const float dy = shape.below_mean(at);
    return {c * dy * dy, dy};
  }
};
}  // namespace detail

/// The paper's split as the paper stores it (SwiftGS, section 5.1): a dx^2, c dy^2, b dx and dy in IEEE half,
/// measured from the splat's mean, which may lie far outside the raster block. Rounding costs accuracy on
/// every large splat, and a term beyond 65,504 is infinite. If two infinite terms cancel, the pixel skips the
/// splat.
struct SWIFTGS_API HalfSplit {
  static constexpr std::string_view name = "half-split";
  struct X {
    Half square, mixed;
  };
  struct Y {
    Half square, offset;
  };

  SWIFTGS_HD HalfSplit(const SplatShape& s, vec2) : terms_(s) {}
  SWIFTGS_HD X x_term(float at) const {
    const vec2 term = terms_.x_term(at);
    return {to_half(term.x), to_half(term.y)};
  }
  SWIFTGS_HD Y y_term(float at) const {
    const vec2 term = terms_.y_term(at);
    return {to_half(term.x), to_half(term.y)};
  }
  SWIFTGS_HD static float exponent(X x, Y y) {
    return to_float(x.square) + to_float(y.square) + to_float(x.mixed) * to_float(y.offset);
  }

 private:
  detail::MeanSplit terms_;
};

static_assert(ExponentPolicy<HalfSplit> && ExponentPolicy<FloatSplit>);

}  // namespace swiftgs
