// SPDX-License-Identifier: Apache-2.0
// expected: T::exponent\(x, y\)
#include <swiftgs/raster/axis_shared.hpp>

struct DoubleTerms : swiftgs::FloatCholesky {
  static constexpr std::string_view name = "double-terms";
  using FloatCholesky::FloatCholesky;
#ifdef SWIFTGS_EXPECT_COMPILE
  using Exponent = float;
#else
  using Exponent = double;
#endif
  static Exponent exponent(X x, Y y) { return Exponent(x.p + y.q) * (x.p + y.q) + y.r; }
};

constexpr auto name = swiftgs::AxisShared<DoubleTerms>::name;
