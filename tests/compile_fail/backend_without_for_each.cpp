// SPDX-License-Identifier: Apache-2.0
// expected: b\.for_each\(
#include <utility>

#include <swiftgs/swiftgs.hpp>

/// All of `Serial` but its loop.
class Still : public swiftgs::Serial {
 public:
  template <class Key>
  void sort_pairs(swiftgs::Pairs<Still, Key>&, swiftgs::Count, int) const {}
#ifndef SWIFTGS_EXPECT_COMPILE
 private:
  using swiftgs::Serial::for_each;
#endif
};

using Refused = swiftgs::Renderer<Still, swiftgs::EarlySort, swiftgs::PerPixel, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
