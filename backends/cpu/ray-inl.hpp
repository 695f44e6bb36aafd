// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_RAY_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_RAY_INL
#undef SWIFTGS_CPU_RAY_INL
#else
#define SWIFTGS_CPU_RAY_INL
#endif

#include <cstddef>

#include <hwy/highway.h>

#include <swiftgs/frame/raster.hpp>
#include <swiftgs/plane/attributes.hpp>

#include "batch-inl.hpp"
#include "raster_block-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// Where the rays of a raster block's pixels meet the image, and the occluder.
struct alignas(64) RayState {
  Plane x, y, occluder;
};

template <class Groups>
HWY_INLINE void PrepareRays(const RasterBlockOfView& block, RayState& rays) {
  const F32 d;
  const vec2 first = point_of(block.view, std::size_t(block.x0), std::size_t(block.y0));
  for (std::size_t row = 0; row < raster_block_side; ++row)
    for (std::size_t column = 0; column < raster_block_side; column += lanes) {
      hn::Store(hn::Iota(d, first.x + float(column)), d, rays.x[row] + column);
      hn::Store(hn::Set(d, first.y + float(row)), d, rays.y[row] + column);
    }
  Groups::FromRows(rays.x), Groups::FromRows(rays.y);
  LoadOccluder<Groups>(block, rays.occluder);
}

/// Takes splats of `of` from the pixels where they lie at the occluder or behind it.
HWY_INLINE void HideGroup(const AttributesView& attributes, const Batch& HWY_RESTRICT batch,
                          const RayState& HWY_RESTRICT rays, Evaluated& HWY_RESTRICT of) {
  const F32 d;
  const Vec x = hn::Load(d, rays.x[of.group] + of.first), y = hn::Load(d, rays.y[of.group] + of.first);
  const Vec occluder = hn::Load(d, rays.occluder[of.group] + of.first);
  for (std::size_t i = 0; i < of.size; ++i) {
    const RayDepth depth = attributes.ray_depth(batch.splats[of.list[i]]);
    const Vec across = hn::MulAdd(hn::Set(d, depth.x), x, hn::Mul(hn::Set(d, depth.y), y));
    const Mask hidden = hn::Ge(hn::Add(hn::Set(d, depth.middle), across), occluder);
    hn::Store(hn::IfThenZeroElse(hidden, hn::Load(d, of.alphas[i])), d, of.alphas[i]);
  }
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
