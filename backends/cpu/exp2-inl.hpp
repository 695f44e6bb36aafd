// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_EXP2_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_EXP2_INL
#undef SWIFTGS_CPU_EXP2_INL
#else
#define SWIFTGS_CPU_EXP2_INL
#endif

#include <cstddef>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Takes the nearest integer off v, and returns it as `TimesPower` wants it: here in the low bits of a
/// float's significand.
template <class D, class V>
HWY_INLINE V TakeWhole(D d, V& v) {
  const V magic = hn::Set(d, 12582912.0f);  // 1.5 2^23
  const V shifted = hn::Add(v, magic);
  v = hn::Sub(v, hn::Sub(shifted, magic));
  return shifted;
}
/// p 2^whole, for what `TakeWhole` returned; 0 where not `kept`.
template <class D, class V>
HWY_INLINE V TimesPower(D d, V p, V whole) {
  const hn::RebindToSigned<D> di;
  return hn::BitCast(d, hn::Add(hn::BitCast(di, p), hn::ShiftLeft<23>(hn::BitCast(di, whole))));
}
template <class D, class V>
HWY_INLINE V TimesPower(D d, V p, V whole, hn::Mask<D> kept) {
  return hn::IfThenElseZero(kept, TimesPower(d, p, whole));
}

#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
// The same with two instructions of AVX-512, three in place of five, none of them a shift, which one port
// alone takes. The integer is a float of that value.
HWY_INLINE hn::Vec512<float> TakeWhole(hn::Full512<float>, hn::Vec512<float>& v) {
  const hn::Vec512<float> fraction{_mm512_reduce_ps(v.raw, 0)}, whole = hn::Sub(v, fraction);
  v = fraction;
  return whole;
}
HWY_INLINE hn::Vec512<float> TimesPower(hn::Full512<float>, hn::Vec512<float> p, hn::Vec512<float> whole) {
  return hn::Vec512<float>{_mm512_maskz_scalef_ps(0xffff, p.raw, whole.raw)};
}
/// A power that is denormal takes a hundred times as long, unless the instruction itself masks it.
HWY_INLINE hn::Vec512<float> TimesPower(hn::Full512<float>, hn::Vec512<float> p, hn::Vec512<float> whole,
                                        hn::Mask512<float> kept) {
  return hn::Vec512<float>{_mm512_maskz_scalef_ps(kept.raw, p.raw, whole.raw)};
}
#endif

/// Sets each v to 2^v for v in [-126, 126], within 2e-7 of the true value, relative: 1.72e-7 with fused
/// multiply-adds, 1.94e-7 without. Outside, the result is arbitrary. With `kept`, an array of n masks, it is
/// 0 where they are not set, for any v.
///
/// exp2 is latency-bound, so n vectors take each step together.
template <std::size_t n, class D, class V = hn::Vec<D>, class... Masks>
HWY_INLINE void Exp2(D d, V (&v)[n], const Masks&... kept) {
  V whole[n], p[n];
  for (std::size_t i = 0; i < n; ++i) whole[i] = TakeWhole(d, v[i]);
  // Minimax polynomial of 2^f on [-1/2, 1/2], relative error 9.1e-8, exact at 0.
  for (std::size_t i = 0; i < n; ++i) p[i] = hn::Set(d, 1.3264726e-3f);
  const auto next = [&](float coefficient) HWY_ATTR {
    for (std::size_t i = 0; i < n; ++i) p[i] = hn::MulAdd(p[i], v[i], hn::Set(d, coefficient));
  };
  next(9.6715130e-3f), next(5.5507336e-2f), next(2.4022242e-1f), next(6.9314700e-1f), next(1.0f);
  for (std::size_t i = 0; i < n; ++i) v[i] = TimesPower(d, p[i], whole[i], kept[i]...);
}

template <class D, class V = hn::Vec<D>>
HWY_INLINE V Exp2(D d, V v) {
  V one[1] = {v};
  Exp2(d, one);
  return one[0];
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
