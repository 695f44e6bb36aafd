// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <string_view>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/splats.hpp>

namespace swiftgs {

/// Exponent representation of axis-shared rasterization, which computes one term per column and one per row.
/// An object is made for one splat, which outlives it, and the centre of a raster block. `x_term` and
/// `y_term` take the coordinate of a column and of a row @units{pixels}. `exponent` joins two terms to s,
/// base 2. If s is negative or not a number, the pixel skips the splat.
template <class T>
concept ExponentPolicy = requires(const T& terms, const SplatShape& shape, vec2 centre, float at,
                                  typename T::X x, typename T::Y y) {
  { T::name } -> std::convertible_to<std::string_view>;
  T(shape, centre);
  { terms.x_term(at) } -> std::same_as<typename T::X>;
  { terms.y_term(at) } -> std::same_as<typename T::Y>;
  { T::exponent(x, y) } -> std::same_as<float>;
};

/// s = (p[x] + q[y])^2 + r[y]: a sum of squares by the Cholesky factor, so nothing cancels and s is never
/// negative.
struct SWIFTGS_API FloatCholesky {
  static constexpr std::string_view name = "float-cholesky";
  struct X {
    float p;  ///< l0 dx
  };
  struct Y {
    float q, r;  ///< l1 dy, (l2 dy)^2
  };

  SWIFTGS_HD FloatCholesky(const SplatShape& s, vec2) : shape_(s) {}
  SWIFTGS_HD X x_term(float at) const { return {shape_.l0 * shape_.right_of_mean(at)}; }
  SWIFTGS_HD Y y_term(float at) const {
    const float dy = shape_.below_mean(at), v = shape_.l2 * dy;
    return {shape_.l1 * dy, v * v};
  }
  SWIFTGS_HD static float exponent(X x, Y y) {
    const float u = x.p + y.q;
    return u * u + y.r;
  }

 private:
  const SplatShape& shape_;
};

static_assert(ExponentPolicy<FloatCholesky>);

}  // namespace swiftgs
