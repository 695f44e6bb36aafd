// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_BLEND_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_BLEND_INL
#undef SWIFTGS_CPU_BLEND_INL
#else
#define SWIFTGS_CPU_BLEND_INL
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include <swiftgs/frame/raster.hpp>

#include "batch-inl.hpp"
#include "raster_block-inl.hpp"
#include "sum-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// As `dimmed`, in one rounding where the target has fused multiply-adds.
HWY_INLINE Vec Dimmed(Vec transmittance, Vec alpha) {
  const Vec difference = hn::NegMulAdd(alpha, transmittance, transmittance);
#if HWY_NATIVE_FMA
  return difference;
#else
  const F32 d;
  const Vec product = hn::Mul(transmittance, hn::Sub(hn::Set(d, 1.0f), alpha));
  return hn::IfThenElse(hn::Gt(alpha, hn::Set(d, 0.5f)), product, difference);
#endif
}

/// Blends the splats of `of` into its pixels. The state stays in registers, so a splat costs its arithmetic
/// and the loads of its alphas and colour. `alphas_from(i, alpha)` sets the alphas of splats [i, i + at_once)
/// of the list. If it evaluates them, the processor does so while a splat waits for the one before.
template <Blending kBlending, class AlphasFrom>
HWY_INLINE void BlendGroup(const Batch& HWY_RESTRICT batch, const BlendRules& rules, Evaluated& of,
                           RasterBlockState& HWY_RESTRICT state, RasterCounts& counts,
                           const AlphasFrom& alphas_from, AttributeState* HWY_RESTRICT attributes = nullptr) {
  constexpr bool kDepth = SumsDepth(kBlending), kOccluder = IsOccluded(kBlending);
  constexpr bool kWeighed = KeepsWeights(kBlending);
  constexpr std::size_t kAttributes = kBlending == Blending::row ? AttributeRow::channels : 0;
  const F32 d;
  const std::size_t group = of.group, first = of.first, n = of.size;
  const std::uint32_t* HWY_RESTRICT list = of.list;
  Vec transmittance = hn::Load(d, of.before);
  // Transmittance as if pixels did not stop. It only falls, so it alone tells whether a pixel stopped, and
  // each splat waits only for its multiply-add. NaN if the pixel stopped before.
  Vec through = hn::IfThenElse(hn::Lt(transmittance, hn::Zero(d)), hn::NaN(d), transmittance);
  Vec red = hn::Load(d, state.red[group] + first);
  Vec green = hn::Load(d, state.green[group] + first);
  Vec blue = hn::Load(d, state.blue[group] + first);
  Vec depth = kDepth ? hn::Load(d, state.depth[group] + first) : hn::Zero(d);
  const Vec occluder = kOccluder ? hn::Load(d, state.occluder[group] + first) : hn::Zero(d);
  Vec most = hn::Zero(d), sums[AttributeRow::channels];
  for (std::size_t c = 0; c < kAttributes; ++c) sums[c] = hn::Load(d, attributes->sums[c][group] + first);
  const Vec stop_below = hn::Set(d, rules.stop_below);

  const auto blend = [&](std::size_t i, Vec alpha) HWY_ATTR {
    const float* HWY_RESTRICT colour = batch.colours[list[i]];
    const Vec before = through;
    through = Dimmed(before, alpha);

    // A pixel ends without this splat if the splat would bring it below the limit, or if the caller's surface
    // hides the splat. A mask, not a branch: most pixels take it once, and no processor predicts when.
    const Mask kept = hn::Gt(alpha, hn::Zero(d));
    if constexpr (kOccluder)
      through = hn::IfThenElse(hn::And(kept, hn::Ge(hn::Set(d, colour[3]), occluder)), hn::NaN(d), through);
    const Mask goes_on = hn::Ge(through, stop_below);
    const Vec weight = hn::IfThenElseZero(goes_on, hn::Mul(alpha, before));
    if constexpr (kWeighed) hn::Store(weight, d, of.weights[i]), most = hn::Max(most, weight);
    if constexpr (kBlending == Blending::all_counted) {
      counts.pixels_stopped += hn::CountTrue(d, hn::AndNot(goes_on, hn::Ge(before, stop_below)));
      counts.contributing_pairs += hn::CountTrue(d, hn::And(goes_on, kept));
    }
    transmittance = hn::IfThenElse(goes_on, through, transmittance);
    red = hn::MulAdd(weight, hn::Set(d, colour[0]), red);
    green = hn::MulAdd(weight, hn::Set(d, colour[1]), green);
    blue = hn::MulAdd(weight, hn::Set(d, colour[2]), blue);
    if constexpr (kDepth) depth = hn::MulAdd(weight, hn::Set(d, colour[3]), depth);
    for (std::size_t c = 0; c < kAttributes; ++c)
      sums[c] = hn::MulAdd(weight, hn::Set(d, attributes->values[list[i]][c]), sums[c]);
  };
  for (std::size_t i = 0; i < n; i += at_once) {
    Vec alpha[at_once];
    alphas_from(i, alpha);
    for (std::size_t j = 0; j < at_once && i + j < n; ++j) blend(i + j, alpha[j]);
  }

  const Vec sign = hn::IfThenZeroElse(hn::Ge(through, stop_below), hn::SignBit(d));
  hn::Store(hn::Or(transmittance, sign), d, state.transmittance[group] + first);
  hn::Store(red, d, state.red[group] + first);
  hn::Store(green, d, state.green[group] + first);
  hn::Store(blue, d, state.blue[group] + first);
  if constexpr (kDepth) hn::Store(depth, d, state.depth[group] + first);
  if constexpr (kWeighed) hn::Store(most, d, of.most);
  for (std::size_t c = 0; c < kAttributes; ++c) hn::Store(sums[c], d, attributes->sums[c][group] + first);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
