// SPDX-License-Identifier: Apache-2.0
// expected: sort: expected .build\(B&, const SortJob&, const Bounds&, Scratch<B>&, TileLists<B>&\)
#include <swiftgs/swiftgs.hpp>

struct Unsorted {
  static constexpr std::string_view name = "unsorted";
  template <class B>
  struct Scratch {
    std::size_t bytes() const { return 0; }
  };
#ifdef SWIFTGS_EXPECT_COMPILE
  template <class B, class Bounds>
  void build(B&, const swiftgs::SortJob&, const Bounds&, Scratch<B>&, swiftgs::TileLists<B>&) {}
#endif
};

using Refused = swiftgs::Renderer<swiftgs::Serial, Unsorted, swiftgs::PerPixel, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
