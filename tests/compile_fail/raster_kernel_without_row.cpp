// SPDX-License-Identifier: Apache-2.0
// expected: rasterizer: expected .void Kernel::start_row\(float y\)
#include <swiftgs/swiftgs.hpp>

struct Flat {
  static constexpr std::string_view name = "flat";
  struct Kernel {
    Kernel(const swiftgs::SplatShape&, swiftgs::vec2, swiftgs::BlendRules) {}
#ifdef SWIFTGS_EXPECT_COMPILE
    void start_row(float) {}
#endif
    float alpha(int) const { return 0.5f; }
  };
};

using Refused = swiftgs::Renderer<swiftgs::Serial, swiftgs::EarlySort, Flat, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
