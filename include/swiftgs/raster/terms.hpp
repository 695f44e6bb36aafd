// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <string_view>

#include <swiftgs/half.hpp>
#include <swiftgs/splats.hpp>

namespace swiftgs {

/// Form and precision of the terms that axis-shared rasterization computes once a column and once a row.
/// `exponent` joins the two to s, base 2; where it is negative or not a number the pixel skips the splat.
template <class T>
concept TermsPolicy = requires(const SplatShape& shape, float at, typename T::X x, typename T::Y y) {
  { T::name } -> std::convertible_to<std::string_view>;
  { T::x_term(shape, at) } -> std::same_as<typename T::X>;
  { T::y_term(shape, at) } -> std::same_as<typename T::Y>;
  { T::exponent(x, y) } -> std::same_as<float>;
};

/// s = (a dx^2) + (c dy^2) + (b dx) dy: the paper's split. The three terms cancel where a splat is long and
/// oblique.
struct FloatSplit {
  static constexpr std::string_view name = "float-split";
  struct X {
    float square, mixed;  ///< a dx^2, b dx
  };
  struct Y {
    float square, offset;  ///< c dy^2, dy
  };
  SWIFTGS_HD static X x_term(const SplatShape& s, float x) {
    const float dx = x - s.mean.x;
    return {s.l0 * s.l0 * dx * dx, 2 * s.l0 * s.l1 * dx};
  }
  SWIFTGS_HD static Y y_term(const SplatShape& s, float y) {
    const float dy = y - s.mean.y;
    return {(s.l1 * s.l1 + s.l2 * s.l2) * dy * dy, dy};
  }
  SWIFTGS_HD static float exponent(X x, Y y) { return x.square + y.square + x.mixed * y.offset; }
};

/// The same split stored as IEEE half (SwiftGS, section 5.1). Offsets are measured from the splat's mean,
/// which may lie far outside the tile, so rounding costs accuracy where splats are large, and beyond 65,504 a
/// term is infinite.
struct HalfSplit {
  static constexpr std::string_view name = "half-split";
  struct X {
    Half square, mixed;
  };
  struct Y {
    Half square, offset;
  };
  SWIFTGS_HD static X x_term(const SplatShape& s, float x) {
    const FloatSplit::X t = FloatSplit::x_term(s, x);
    return {to_half(t.square), to_half(t.mixed)};
  }
  SWIFTGS_HD static Y y_term(const SplatShape& s, float y) {
    const FloatSplit::Y t = FloatSplit::y_term(s, y);
    return {to_half(t.square), to_half(t.offset)};
  }
  SWIFTGS_HD static float exponent(X x, Y y) {
    return FloatSplit::exponent({to_float(x.square), to_float(x.mixed)},
                                {to_float(y.square), to_float(y.offset)});
  }
};

/// s = (p[x] + q[y])^2 + r[y]: a sum of squares by the Cholesky factor, so nothing cancels and s is never
/// negative.
struct FloatCholesky {
  static constexpr std::string_view name = "float-cholesky";
  struct X {
    float p;  ///< l0 dx
  };
  struct Y {
    float q, r;  ///< l1 dy, (l2 dy)^2
  };
  SWIFTGS_HD static X x_term(const SplatShape& s, float x) { return {s.l0 * (x - s.mean.x)}; }
  SWIFTGS_HD static Y y_term(const SplatShape& s, float y) {
    const float dy = y - s.mean.y, v = s.l2 * dy;
    return {s.l1 * dy, v * v};
  }
  SWIFTGS_HD static float exponent(X x, Y y) {
    const float u = x.p + y.q;
    return u * u + y.r;
  }
};

static_assert(TermsPolicy<HalfSplit> && TermsPolicy<FloatSplit> && TermsPolicy<FloatCholesky>);

}  // namespace swiftgs
