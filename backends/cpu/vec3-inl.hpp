// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_VEC3_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_VEC3_INL
#undef SWIFTGS_CPU_VEC3_INL
#else
#define SWIFTGS_CPU_VEC3_INL
#endif

#include <cstddef>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A lane a Gaussian.
using F32 = hn::CappedTag<float, 16>;
using Vec = hn::Vec<F32>;
constexpr std::size_t lanes = hn::MaxLanes(F32());

/// As many vectors of the scene as there are lanes.
struct Vec3 {
  Vec x, y, z;
};
HWY_INLINE Vec Dot(const Vec3& a, const Vec3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Vec3 Scale(const Vec3& a, Vec s) { return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)}; }

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
