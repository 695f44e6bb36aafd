// SPDX-License-Identifier: Apache-2.0
// expected: rasterizer: expected a type .Kernel., or a function rasterize
#include <swiftgs/swiftgs.hpp>

struct Nameless {
  static constexpr std::string_view name = "nameless";
#ifdef SWIFTGS_EXPECT_COMPILE
  using Kernel = swiftgs::PerPixel::Kernel;
#endif
};

using Refused = swiftgs::Renderer<swiftgs::Serial, swiftgs::EarlySort, Nameless, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
