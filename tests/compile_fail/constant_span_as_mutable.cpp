// SPDX-License-Identifier: Apache-2.0
// expected: (could not convert|conversion from|no viable conversion).*Span<const float>
#include <swiftgs/span.hpp>

float first_of(swiftgs::Span<const float> values) {
#ifdef SWIFTGS_EXPECT_COMPILE
  const swiftgs::Span<const float> same = values;
#else
  const swiftgs::Span<float> same = values;
#endif
  return same[0];
}
