// SPDX-License-Identifier: Apache-2.0
// expected backend_without_for_each: b\.for_each\(
#include <utility>

#include <swiftgs/swiftgs.hpp>

/// All of `Serial` but its loop.
class Still : public swiftgs::Serial {
 public:
  template <class Key>
  void sort_pairs(swiftgs::Pairs<Still, Key>&, swiftgs::Count, int) const {}
#ifdef backend_without_for_each
 private:
  using swiftgs::Serial::for_each;
#endif
};

using Refused = swiftgs::Renderer<Still, swiftgs::EarlySort, swiftgs::PerPixel, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
