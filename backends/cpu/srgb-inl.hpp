// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_SRGB_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_SRGB_INL
#undef SWIFTGS_CPU_SRGB_INL
#else
#define SWIFTGS_CPU_SRGB_INL
#endif

#include <cstddef>

#include <hwy/highway.h>

#include <swiftgs/frame/srgb.hpp>
#include <swiftgs/raster/store.hpp>

#include "raster_block-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

#if HWY_NATIVE_FMA
/// `detail::inverse_root`, with its bits, as of all functions here.
template <int n>
HWY_INLINE Vec InverseRoot(Vec x) {
  using R = detail::InverseRoot<n>;
  const F32 d;
  const hn::RebindToSigned<F32> di;
  const auto part = hn::ConvertTo(di, hn::Mul(hn::ConvertTo(d, hn::BitCast(di, x)), hn::Set(d, R::part)));
  Vec y = hn::BitCast(d, hn::Sub(hn::Set(di, R::start), part));
  for (int step = 0; step < 2; ++step) {
    const Vec y2 = hn::Mul(y, y), y4 = hn::Mul(y2, y2);
    const Vec missing = hn::NegMulAdd(hn::Mul(x, y4), hn::Mul(y4, n == 10 ? y2 : y4), hn::Set(d, 1.0f));
    const Vec series = hn::MulAdd(missing, hn::Set(d, R::c3), hn::Set(d, R::c2));
    y = hn::MulAdd(hn::Mul(y, missing), hn::MulAdd(missing, series, hn::Set(d, R::c1)), y);
  }
  return y;
}

/// x^(1/2 - 1/n) of x >= 0.
template <int n>
HWY_INLINE Vec RootOverRoot(Vec x) {
  const F32 d;
  return hn::Mul(hn::Sqrt(x), InverseRoot<n>(hn::Min(x, hn::Set(d, detail::largest_float))));
}

HWY_INLINE Vec ToSrgb(Vec linear) {
  const F32 d;
  const Vec x = hn::Abs(linear);
  const Vec curved = hn::MulAdd(hn::Set(d, 1.055f), RootOverRoot<12>(x), hn::Set(d, -0.055f));
  const Vec straight = hn::Mul(hn::Set(d, 12.92f), x);
  return hn::CopySign(hn::IfThenElse(hn::Le(x, hn::Set(d, 0.0031308f)), straight, curved), linear);
}

HWY_INLINE Vec FromSrgb(Vec encoded) {
  const F32 d;
  const Vec x = hn::Abs(encoded);
  const Vec base = hn::MulAdd(x, hn::Set(d, float(1 / 1.055)), hn::Set(d, float(0.055 / 1.055)));
  const Vec curved = hn::Mul(hn::Mul(base, base), RootOverRoot<10>(base));
  const Vec straight = hn::Mul(x, hn::Set(d, float(1 / 12.92)));
  return hn::CopySign(hn::IfThenElse(hn::Le(x, hn::Set(d, 0.04045f)), straight, curved), encoded);
}

/// `detail::convert_channel` of a register.
HWY_INLINE Vec ConvertChannel(Vec channel, Vec alpha, bool encode) {
  const Vec straight = hn::Div(channel, alpha);
  const Vec converted = hn::Mul(encode ? ToSrgb(straight) : FromSrgb(straight), alpha);
  return hn::IfThenElseZero(hn::Gt(alpha, hn::Zero(F32())), converted);
}
#else
HWY_INLINE Vec ConvertChannel(Vec channel, Vec alpha, bool encode) {
  const F32 d;
  alignas(64) float channels[lanes], alphas[lanes];
  hn::Store(channel, d, channels), hn::Store(alpha, d, alphas);
  for (std::size_t i = 0; i < lanes; ++i)
    channels[i] = detail::convert_channel(channels[i], alphas[i], encode);
  return hn::Load(d, channels);
}
#endif

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
