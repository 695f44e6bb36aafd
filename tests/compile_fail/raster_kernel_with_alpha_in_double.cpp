// SPDX-License-Identifier: Apache-2.0
// expected: rasterizer: expected .Kernel::alpha\(int column\). that returns a float
#include <swiftgs/swiftgs.hpp>

struct Flat {
  static constexpr std::string_view name = "flat";
  struct Kernel {
    Kernel(const swiftgs::SplatShape&, swiftgs::vec2, swiftgs::BlendRules) {}
    void start_row(float) {}
#ifdef SWIFTGS_EXPECT_COMPILE
    float alpha(int) const { return 0.5f; }
#else
    double alpha(int) const { return 0.5; }
#endif
  };
};

using Refused = swiftgs::Renderer<swiftgs::Serial, swiftgs::EarlySort, Flat, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
