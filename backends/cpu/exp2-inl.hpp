// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_EXP2_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_EXP2_INL
#undef SWIFTGS_CPU_EXP2_INL
#else
#define SWIFTGS_CPU_EXP2_INL
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// 2^v for v in [-126, 126], within 2e-7 of the true value, relative: 1.72e-7 with fused
/// multiply-adds, 1.94e-7 without. Outside, an arbitrary float.
///
/// Each step of n vectors stands before the next step: a step waits for the one before, so n of them keep the
/// processor busy where one would not.
template <std::size_t n, class D, class V = hn::Vec<D>>
HWY_INLINE void Exp2(D d, V (&v)[n]) {
  const hn::RebindToSigned<D> di;
  // Adding 1.5 2^23 leaves round(v) in the low bits of the significand.
  const V magic = hn::Set(d, 12582912.0f);
  V shifted[n], p[n];
  for (std::size_t i = 0; i < n; ++i) shifted[i] = hn::Add(v[i], magic);
  for (std::size_t i = 0; i < n; ++i) v[i] = hn::Sub(v[i], hn::Sub(shifted[i], magic));
  // Minimax polynomial of 2^f on [-1/2, 1/2], relative error 9.1e-8, exact at 0.
  for (std::size_t i = 0; i < n; ++i) p[i] = hn::Set(d, 1.3264726e-3f);
  const auto next = [&](float coefficient) HWY_ATTR {
    for (std::size_t i = 0; i < n; ++i) p[i] = hn::MulAdd(p[i], v[i], hn::Set(d, coefficient));
  };
  next(9.6715130e-3f), next(5.5507336e-2f), next(2.4022242e-1f), next(6.9314700e-1f), next(1.0f);
  for (std::size_t i = 0; i < n; ++i)
    v[i] = hn::BitCast(d, hn::Add(hn::BitCast(di, p[i]), hn::ShiftLeft<23>(hn::BitCast(di, shifted[i]))));
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
