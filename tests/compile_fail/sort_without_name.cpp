// SPDX-License-Identifier: Apache-2.0
// expected: sort: expected .static constexpr std::string_view name
#include <swiftgs/swiftgs.hpp>

struct Unsorted {
#ifdef SWIFTGS_EXPECT_COMPILE
  static constexpr std::string_view name = "unsorted";
#endif
  template <class B>
  struct Scratch {
    std::size_t bytes() const { return 0; }
  };
  template <class B, class Bounds>
  void build(B&, const swiftgs::SortJob&, const Bounds&, Scratch<B>&, swiftgs::TileLists<B>&) {}
};

using Refused = swiftgs::Renderer<swiftgs::Serial, Unsorted, swiftgs::PerPixel, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
