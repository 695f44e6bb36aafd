// SPDX-License-Identifier: Apache-2.0
// expected: sort: expected .template <class B> struct Scratch
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

#ifdef SWIFTGS_EXPECT_COMPILE
using Refused = Renderer<Serial, EarlySort, PerPixel, Ellipse>;
#else
using Refused = Renderer<Serial, PerPixel, EarlySort, Ellipse>;
#endif
constexpr auto name = Refused::name;
