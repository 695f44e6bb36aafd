// SPDX-License-Identifier: Apache-2.0
// expected: sort: expected Scratch that can be made empty and moved
#include <swiftgs/swiftgs.hpp>

struct Unsorted {
  static constexpr std::string_view name = "unsorted";
  template <class B>
  struct Scratch {
    std::size_t bytes() const { return 0; }
#ifndef SWIFTGS_EXPECT_COMPILE
    int& outside;
#endif
  };
  template <class B, class Bounds>
  void build(B&, const swiftgs::SortJob&, const Bounds&, Scratch<B>&, swiftgs::TileLists<B>&) {}
};

using Refused = swiftgs::Renderer<swiftgs::Serial, Unsorted, swiftgs::PerPixel, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
