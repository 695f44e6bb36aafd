// SPDX-License-Identifier: Apache-2.0
// expected: OpacityBox>::view\(\).*SortJob<swiftgs::Ellipse>|no viable conversion from .*OpacityBox>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

#ifdef SWIFTGS_EXPECT_COMPILE
using Projected = Ellipse;
#else
using Projected = OpacityBox;
#endif

SortJob<Ellipse> job_of(const Splats<Serial>& splats, const Footprints<Serial, Projected>& footprints) {
  return {splats.view(), footprints.view(), FrameKey{}};
}
