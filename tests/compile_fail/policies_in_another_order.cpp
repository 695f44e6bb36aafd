// SPDX-License-Identifier: Apache-2.0
// expected policies_in_another_order: sort: expected .template <class B> struct Scratch
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

#ifndef policies_in_another_order
using Refused = Renderer<Serial, EarlySort, PerPixel, Ellipse>;
#else
using Refused = Renderer<Serial, PerPixel, EarlySort, Ellipse>;
#endif
constexpr auto name = Refused::name;
