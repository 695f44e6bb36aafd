// SPDX-License-Identifier: Apache-2.0
// expected: rasterizer: expected .static constexpr std::string_view name
#include <swiftgs/swiftgs.hpp>

struct Nameless {
#ifdef SWIFTGS_EXPECT_COMPILE
  static constexpr std::string_view name = "nameless";
#endif
  using Kernel = swiftgs::PerPixel::Kernel;
};

using Refused = swiftgs::Renderer<swiftgs::Serial, swiftgs::EarlySort, Nameless, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
