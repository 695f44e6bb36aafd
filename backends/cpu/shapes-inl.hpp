// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_SHAPES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_SHAPES_INL
#undef SWIFTGS_CPU_SHAPES_INL
#else
#define SWIFTGS_CPU_SHAPES_INL
#endif

#include <hwy/highway.h>

#include <swiftgs/frame/splats.hpp>

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Members of `SplatShape`, a splat a lane. `low` has its bits.
template <class V>
struct ShapesOf {
  V mean_x, mean_y, l0, l1, l2, opacity, cutoff, low;
};

/// A shape is two groups of four floats: where they are loaded as such, the first groups are in even lanes
/// and the second in odd ones.
template <class D, class V = hn::Vec<D>>
HWY_INLINE ShapesOf<V> LoadShapes(D d, const SplatShape* HWY_RESTRICT shapes) {
  static_assert(sizeof(SplatShape) == 8 * sizeof(float));
  V low[4], high[4];  // of the first half of the shapes, and of the second
  hn::LoadInterleaved4(d, &shapes[0].mean.x, low[0], low[1], low[2], low[3]);
  hn::LoadInterleaved4(d, &shapes[hn::MaxLanes(d) / 2].mean.x, high[0], high[1], high[2], high[3]);
  const auto even = [&](int i) HWY_ATTR { return hn::ConcatEven(d, high[i], low[i]); };
  const auto odd = [&](int i) HWY_ATTR { return hn::ConcatOdd(d, high[i], low[i]); };
  return {even(0), even(1), even(2), even(3), odd(0), odd(1), odd(2), odd(3)};
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
