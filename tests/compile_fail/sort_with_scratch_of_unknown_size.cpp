// SPDX-License-Identifier: Apache-2.0
// expected: sort: expected Scratch with .static auto buffers
#include <swiftgs/swiftgs.hpp>

struct Unsorted {
  static constexpr std::string_view name = "unsorted";
  template <class B>
  struct Scratch {
    int x = 0;
#ifdef SWIFTGS_EXPECT_COMPILE
    std::size_t bytes() const { return 0; }
#endif
  };
  template <class B, class Bounds>
  void build(B&, const swiftgs::SortJob&, const Bounds&, Scratch<B>&, swiftgs::TileLists<B>&) {}
};

using Refused = swiftgs::Renderer<swiftgs::Serial, Unsorted, swiftgs::PerPixel, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
