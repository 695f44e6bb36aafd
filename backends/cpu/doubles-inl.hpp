// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_DOUBLES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_DOUBLES_INL
#undef SWIFTGS_CPU_DOUBLES_INL
#else
#define SWIFTGS_CPU_DOUBLES_INL
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "vec3-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F64 = hn::Repartition<double, F32>;
using Vec64 = hn::Vec<F64>;

struct DoublesMask {
  hn::Mask<F64> m;

  friend HWY_INLINE DoublesMask operator&(DoublesMask a, DoublesMask b) { return {hn::And(a.m, b.m)}; }
};

/// A vector of doubles that the formulas of lenses take as their number.
struct Doubles {
  Vec64 v;

  Doubles() = default;
  HWY_INLINE Doubles(Vec64 each) : v(each) {}
  HWY_INLINE Doubles(double all) : v(hn::Set(F64(), all)) {}

  friend HWY_INLINE Doubles operator+(Doubles a, Doubles b) { return hn::Add(a.v, b.v); }
  friend HWY_INLINE Doubles operator-(Doubles a, Doubles b) { return hn::Sub(a.v, b.v); }
  friend HWY_INLINE Doubles operator*(Doubles a, Doubles b) { return hn::Mul(a.v, b.v); }
  friend HWY_INLINE Doubles operator/(Doubles a, Doubles b) { return hn::Div(a.v, b.v); }
  friend HWY_INLINE Doubles operator-(Doubles a) { return hn::Neg(a.v); }
  friend HWY_INLINE DoublesMask operator<(Doubles a, Doubles b) { return {hn::Lt(a.v, b.v)}; }
  friend HWY_INLINE DoublesMask operator>(Doubles a, Doubles b) { return {hn::Gt(a.v, b.v)}; }
  friend HWY_INLINE DoublesMask operator==(Doubles a, Doubles b) { return {hn::Eq(a.v, b.v)}; }
};

HWY_INLINE Doubles mul_add(Doubles a, Doubles b, Doubles c) { return hn::MulAdd(a.v, b.v, c.v); }
HWY_INLINE Doubles mul_sub(Doubles a, Doubles b, Doubles c) { return hn::MulSub(a.v, b.v, c.v); }
HWY_INLINE Doubles neg_mul_add(Doubles a, Doubles b, Doubles c) { return hn::NegMulAdd(a.v, b.v, c.v); }
HWY_INLINE Doubles square_root(Doubles a) { return hn::Sqrt(a.v); }
HWY_INLINE Doubles inverse(Doubles a) { return Doubles(1.0) / a; }
HWY_INLINE Doubles inverse_sqrt(Doubles a) { return inverse(square_root(a)); }
/// As std::round: halves away from 0.
HWY_INLINE Doubles rounded(Doubles a) {
  const Vec64 whole = hn::Trunc(a.v), one = hn::CopySign(hn::Set(F64(), 1.0), a.v);
  const auto up = hn::Ge(hn::Abs(hn::Sub(a.v, whole)), hn::Set(F64(), 0.5));
  return hn::Add(whole, hn::IfThenElseZero(up, one));
}
HWY_INLINE Doubles choose(DoublesMask first, Doubles a, Doubles b) {
  return hn::IfThenElse(first.m, a.v, b.v);
}
HWY_INLINE bool all(DoublesMask mask) { return hn::AllTrue(F64(), mask.m); }

/// atan2, to some units in the last place.
HWY_INLINE Doubles angle(Doubles y, Doubles x) {
  constexpr double pi = 3.141592653589793;
  const Doubles across = hn::Abs(y.v), along = hn::Abs(x.v), none = 0.0;
  const Doubles larger = hn::Max(across.v, along.v), smaller = hn::Min(across.v, along.v);
  Doubles turn = hn::CallAtan(F64(), choose(larger == none, none, smaller / larger).v);
  turn = choose(across > along, pi / 2 - turn, turn);
  turn = choose(x < none, pi - turn, turn);
  return hn::CopySign(turn.v, y.v);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
