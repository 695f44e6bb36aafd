// SPDX-License-Identifier: Apache-2.0
// expected: rasterizer: expected .Kernel\(const SplatShape&, vec2 first_centre, BlendRules\)
#include <swiftgs/swiftgs.hpp>

struct Flat {
  static constexpr std::string_view name = "flat";
  struct Kernel {
#ifdef SWIFTGS_EXPECT_COMPILE
    Kernel(const swiftgs::SplatShape&, swiftgs::vec2, swiftgs::BlendRules) {}
#else
    explicit Kernel(const swiftgs::SplatShape&) {}
#endif
    void start_row(float) {}
    float alpha(int) const { return 0.5f; }
  };
};

using Refused = swiftgs::Renderer<swiftgs::Serial, swiftgs::EarlySort, Flat, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
