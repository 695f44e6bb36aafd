// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_PICK_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_PICK_INL
#undef SWIFTGS_CPU_PICK_INL
#else
#define SWIFTGS_CPU_PICK_INL
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include <swiftgs/frame/raster.hpp>
#include <swiftgs/functor/blend.hpp>
#include <swiftgs/plane/picks.hpp>

#include "batch-inl.hpp"
#include "blend-inl.hpp"
#include "raster_block-inl.hpp"
#include "store-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// `SplatPicks` of a raster block's pixels.
struct alignas(64) PickState {
  PlaneOf<std::uint32_t> first, median, largest;
  Plane weight;
};

HWY_INLINE void ClearPicks(PickState& picks) {
  for (auto* plane : {&picks.first, &picks.median, &picks.largest})
    std::fill_n(&(*plane)[0][0], raster_block_side * raster_block_side, SplatPicks::none);
  Fill(picks.weight, 0);
}

/// Offers what `BlendGroup` blended of `of`, with its weights, to the picks of the pixels; `state` is as it
/// left it.
HWY_INLINE void PickGroup(const Batch& HWY_RESTRICT batch, const BlendRules& rules,
                          const Evaluated& HWY_RESTRICT of, const RasterBlockState& HWY_RESTRICT state,
                          PickState& HWY_RESTRICT picks) {
  const F32 d;
  const hn::RebindToUnsigned<F32> du;
  const auto splat = [&](std::size_t i) HWY_ATTR { return hn::Set(du, batch.splats[of.list[i]]); };

  // Weights fall with the transmittance, so most batches behind the first few hold no larger one.
  float* const weights = picks.weight[of.group] + of.first;
  const Vec weight = hn::Load(d, weights), most = hn::Load(d, of.most);
  const Mask found = hn::Gt(most, weight);
  if (!hn::AllFalse(d, found)) {
    std::uint32_t* const to = picks.largest[of.group] + of.first;
    const Vec sought = hn::IfThenElse(found, most, hn::NaN(d));
    auto largest = hn::Load(du, to);
    for (std::size_t i = of.size; i-- > 0;) {  // of equal weights the first
      const Mask equal = hn::Eq(hn::Load(d, of.weights[i]), sought);
      largest = hn::IfThenElse(hn::RebindMask(du, equal), splat(i), largest);
    }
    hn::Store(largest, du, to);
    hn::Store(hn::Max(most, weight), d, weights);
  }

  // Transmittance only falls, so that at both ends of the batch tells whether a splat took it below a limit.
  const Vec first_below = hn::Set(d, rules.first_below), half = hn::Set(d, median_below);
  const Vec before = hn::Load(d, of.before);
  const Vec after = hn::Abs(hn::Load(d, state.transmittance[of.group] + of.first));
  const Mask first_crossed = hn::And(hn::Ge(before, first_below), hn::Lt(after, first_below));
  const Mask median_crossed = hn::And(hn::Ge(before, half), hn::Lt(after, half));
  if (hn::AllFalse(d, hn::Or(first_crossed, median_crossed))) return;
  auto first = hn::Zero(du), median = first;  // the last splats that found it above the limit
  Vec through = before;  // as if pixels did not stop, which those do behind the splats that are sought
  for (std::size_t i = 0; i < of.size; ++i) {
    first = hn::IfThenElse(hn::RebindMask(du, hn::Ge(through, first_below)), splat(i), first);
    median = hn::IfThenElse(hn::RebindMask(du, hn::Ge(through, half)), splat(i), median);
    through = Dimmed(through, hn::Load(d, of.alphas[i]));
  }
  hn::BlendedStore(first, hn::RebindMask(du, first_crossed), du, picks.first[of.group] + of.first);
  hn::BlendedStore(median, hn::RebindMask(du, median_crossed), du, picks.median[of.group] + of.first);
}

/// Writes a plane of what `from` holds of each pixel's splat, and `none` where there is none. `splats` lie in
/// rows.
template <class T>
HWY_INLINE void StorePicked(const RasterBlockOfView& block, const PlaneOf<std::uint32_t>& splats,
                            const T* from, T none, swiftgs::Plane<T> to) {
  if (!to.data) return;
  const hn::CappedTag<T, raster_block_side> d;
  const hn::RebindToSigned<decltype(d)> di;
  for (std::size_t row = 0; row < std::size_t(block.rows); ++row) {
    alignas(64) T found[raster_block_side];
    for (std::size_t first = 0; first < raster_block_side; first += lanes) {
      const auto index = hn::BitCast(di, hn::Load(hn::RebindToUnsigned<decltype(d)>(), splats[row] + first));
      const auto some = hn::Ne(index, hn::Set(di, std::int32_t(SplatPicks::none)));
      auto values = hn::Set(d, none);
      if (!hn::AllFalse(di, some)) {
        const auto gathered = hn::GatherIndex(d, from, hn::IfThenElseZero(some, index));
        values = hn::IfThenElse(hn::RebindMask(d, some), gathered, values);
      }
      hn::Store(values, d, found + first);
    }
    StreamWords(to.row(std::size_t(block.y0) + row) + block.x0, found,
                std::size_t(block.columns) * sizeof(T));
  }
}

/// Writes the planes of picks that are asked for, as `store_picks` does. Turns `picks` into rows.
template <class Groups>
HWY_INLINE void StorePicks(const RasterJob& job, const RasterBlockOfView& block, PickState& picks) {
  const FrameView& frame = block.view.frame;
  for (auto* plane : {&picks.first, &picks.median, &picks.largest}) Groups::ToRows(*plane);
  const ViewConstants& camera = block.view.camera;
  if ((camera.depth_along_ray || camera.order_is_distance) &&
      (frame.first_depth.data || frame.median_depth.data)) {
    for (std::size_t row = 0; row < std::size_t(block.rows); ++row)
      for (std::size_t column = 0; column < std::size_t(block.columns); ++column)
        store_picks(job, block.view, std::size_t(block.x0) + column, std::size_t(block.y0) + row,
                    {picks.first[row][column], picks.median[row][column], picks.largest[row][column]});
    return;
  }
  StorePicked(block, picks.first, job.splats.depths.data, 0.0f, frame.first_depth);
  StorePicked(block, picks.median, job.splats.depths.data, 0.0f, frame.median_depth);
  StorePicked(block, picks.median, job.splats.gaussians.data, no_gaussian, frame.median_id);
  StorePicked(block, picks.largest, job.splats.gaussians.data, no_gaussian, frame.id);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
