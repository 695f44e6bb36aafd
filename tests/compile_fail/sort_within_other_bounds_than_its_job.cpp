// SPDX-License-Identifier: Apache-2.0
// expected: deduced conflicting types for parameter .*Bounds
#include <swiftgs/serial.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

#ifdef SWIFTGS_EXPECT_COMPILE
using Sorted = Ellipse;
#else
using Sorted = OpacityBox;
#endif

void sort(Serial& serial, const SortJob<Ellipse>& job, EarlySort::Scratch<Serial>& scratch,
          TileLists<Serial>& lists) {
  EarlySort().build(serial, job, Sorted(), scratch, lists);
}
