// SPDX-License-Identifier: Apache-2.0
// expected exponent_in_double: T::exponent\(x, y\)
#include <swiftgs/raster/axis_shared.hpp>

struct DoubleExponent : swiftgs::FloatCholesky {
  static constexpr std::string_view name = "double-exponent";
  using FloatCholesky::FloatCholesky;
#ifndef exponent_in_double
  using Exponent = float;
#else
  using Exponent = double;
#endif
  static Exponent exponent(X x, Y y) { return Exponent(x.p + y.q) * (x.p + y.q) + y.r; }
};

constexpr auto name = swiftgs::AxisShared<DoubleExponent>::name;
