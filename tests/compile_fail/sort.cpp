// SPDX-License-Identifier: Apache-2.0
// clang-format off
// expected sort_without_name: sort: expected .static constexpr std::string_view name
// expected sort_without_build: sort: expected .build\(B&, const SortJob&, const Bounds&, Scratch<B>&, TileLists<B>&\)
// expected sort_with_scratch_of_unknown_size: sort: expected Scratch with .static auto buffers
// expected sort_with_scratch_that_cannot_be_emptied: sort: expected Scratch that can be made empty and moved
// clang-format on
#include <swiftgs/swiftgs.hpp>

struct Unsorted {
#ifndef sort_without_name
  static constexpr std::string_view name = "unsorted";
#endif
  template <class B>
  struct Scratch {
    int x = 0;
#ifdef sort_with_scratch_that_cannot_be_emptied
    int& outside;
#endif
#ifndef sort_with_scratch_of_unknown_size
    std::size_t bytes() const { return 0; }
#endif
  };
#ifndef sort_without_build
  template <class B, class Bounds>
  void build(B&, const swiftgs::SortJob&, const Bounds&, Scratch<B>&, swiftgs::TileLists<B>&) {}
#endif
};

using Refused = swiftgs::Renderer<swiftgs::Serial, Unsorted, swiftgs::PerPixel, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
