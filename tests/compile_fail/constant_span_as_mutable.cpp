// SPDX-License-Identifier: Apache-2.0
// clang-format off
// expected constant_span_as_mutable: (could not convert|conversion from|no viable conversion).*Span<const float>
// clang-format on
#include <swiftgs/frame/span.hpp>

float first_of(swiftgs::Span<const float> values) {
#ifndef constant_span_as_mutable
  const swiftgs::Span<const float> same = values;
#else
  const swiftgs::Span<float> same = values;
#endif
  return same[0];
}
