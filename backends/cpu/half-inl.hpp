// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_HALF_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_HALF_INL
#undef SWIFTGS_CPU_HALF_INL
#else
#define SWIFTGS_CPU_HALF_INL
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include <swiftgs/frame/half.hpp>

#include "raster_block-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

using F16 = hn::Rebind<hwy::float16_t, F32>;
using U16 = hn::Rebind<std::uint16_t, F32>;

/// Rounds to the nearest half, as `to_half` does.
HWY_INLINE hn::Vec<U16> ToHalf(Vec v) {
#if HWY_ARCH_X86 && HWY_TARGET >= HWY_SSE4
  // Where the processor has no such conversion, Highway's truncates and has no infinity.
  alignas(64) float values[lanes];
  alignas(64) std::uint16_t bits[lanes];
  hn::Store(v, F32(), values);
  for (std::size_t i = 0; i < lanes; ++i) bits[i] = to_half(values[i]).bits;
  return hn::Load(U16(), bits);
#else
  return hn::BitCast(U16(), hn::DemoteTo(F16(), v));
#endif
}

/// Values of halves that are numbers, as `to_float` has them.
HWY_INLINE Vec ToFloat(hn::Vec<F16> halves) {
  const F32 d;
  const Vec v = hn::PromoteTo(d, halves);
#if HWY_ARCH_X86 && HWY_TARGET >= HWY_SSE4
  // Highway's form for such processors takes infinity for 65,536.
  return hn::IfThenElse(hn::Ge(hn::Abs(v), hn::Set(d, 65536.0f)), hn::CopySign(hn::Inf(d), v), v);
#else
  return v;
#endif
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
