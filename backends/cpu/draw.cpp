// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu/stages.hpp>

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "draw.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "blend-inl.hpp"
#include "draw-inl.hpp"
#include "store-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

template <Blending kBlending>
void DrawGroup(const RasterJob& job, const Batch& batch, const BlendRules& rules, Evaluated& of,
               RasterBlockState& state, const PlaneStates& planes, RasterCounts& counts) {
  if constexpr (KeepsWeights(kBlending))
    if (planes.rays) HideGroup(job.attributes, batch, *planes.rays, of);
  BlendGroup<kBlending>(batch, rules, of, state, counts, of, planes.sums);
  if constexpr (KeepsWeights(kBlending)) {
    if (planes.picks) PickGroup(batch, rules, of, state, *planes.picks);
    if (planes.sums) SumGroup(job.attributes, of, *planes.sums);
  }
}

DrawFunction DrawFunctionOf(Blending blending) {
  static constexpr DrawFunction functions[] = {
      DrawGroup<Blending::colours>,    DrawGroup<Blending::depths>,  DrawGroup<Blending::occluded>,
      DrawGroup<Blending::row>,        DrawGroup<Blending::weighed>, DrawGroup<Blending::all_weighed>,
      DrawGroup<Blending::all_counted>};
  return functions[int(blending)];
}

template <class Groups>
void Begin(const RasterJob& job, const RasterBlockOfView& block, Blending blending, RasterBlockState& state,
           const PlaneStates& planes) {
  Clear<Groups>(block, blending, state);
  if (planes.picks) ClearPicks(*planes.picks);
  if (planes.sums) ClearSums(job.attributes, *planes.sums);
  if (planes.rays) PrepareRays<Groups>(block, *planes.rays);
}

template <class Groups>
void End(const RasterJob& job, const RasterBlockOfView& block, RasterBlockState& state,
         const PlaneStates& planes) {
  if (!job.only_attributes)
    StoreRasterBlock<Groups>(block.view, block, state);
  else
    Groups::ToRows(state.transmittance);
  if (planes.picks) StorePicks<Groups>(job, block, *planes.picks);
  if (planes.sums) StoreSums<Groups>(job, block, state.transmittance, *planes.sums);
}

template void Begin<Rows>(const RasterJob&, const RasterBlockOfView&, Blending, RasterBlockState&,
                          const PlaneStates&);
template void Begin<Blocks>(const RasterJob&, const RasterBlockOfView&, Blending, RasterBlockState&,
                            const PlaneStates&);
template void End<Rows>(const RasterJob&, const RasterBlockOfView&, RasterBlockState&, const PlaneStates&);
template void End<Blocks>(const RasterJob&, const RasterBlockOfView&, RasterBlockState&, const PlaneStates&);

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
