// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_BATCH_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_BATCH_INL
#undef SWIFTGS_CPU_BATCH_INL
#else
#define SWIFTGS_CPU_BATCH_INL
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include <swiftgs/frame/splats.hpp>

#include "raster_block-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// Splats that are prepared together: their terms stay in the first-level cache while groups traverse them.
/// With 96 or 128, rasterizing takes 0.98 and 0.99 of the time in fox, and 1.04 and 1.06 in herz and garden.
constexpr std::size_t batch_size = 64;

/// Splats whose alphas are evaluated together. With AVX-512, rasterizing takes as long with three or four,
/// and 1.06 of the time with one.
constexpr std::size_t at_once = 2;

/// A batch, without what each exponent representation prepares of it.
struct alignas(64) Batch {
  std::uint32_t group_masks[batch_size];                       ///< bit g: the splat touches group g
  const std::uint32_t* splats;                                 ///< numbers of its splats in the frame
  SplatShape shapes[batch_size];                               ///< copies, loaded by registers
  float colours[batch_size][4];                                ///< RGB, depth
  std::uint32_t lists[raster_block_side][batch_size + lanes];  ///< for each group the splats that touch it
  std::size_t list_sizes[raster_block_side];
};

/// Turns one mask of groups a splat into one list of splats a group.
HWY_INLINE void ListGroups(Batch& HWY_RESTRICT batch, std::size_t splats) {
  const hn::CappedTag<std::uint32_t, raster_block_side> d;
  for (std::size_t group = 0; group < raster_block_side; ++group) {
    std::size_t size = 0;
    for (std::size_t first = 0; first < splats; first += lanes) {
      const auto touched = hn::TestBit(hn::Load(d, batch.group_masks + first), hn::Set(d, 1u << group));
      const auto index = hn::Iota(d, std::uint32_t(first));
      size += hn::CompressStore(index, touched, d, batch.lists[group] + size);
    }
    batch.list_sizes[group] = size;
    // Alphas are evaluated beyond the end, of whatever splat.
    for (std::size_t i = 0; i + 1 < at_once; ++i) batch.lists[group][size + i] = 0;
  }
}

/// The splats that a batch lists for a group, on one register of the group's pixels.
struct alignas(64) Evaluated {
  float before[lanes];  ///< transmittance in front of the batch; negative as in a state
  /// 0 where a pixel skips the splat. Not stored where `BlendGroup` evaluates them.
  float alphas[batch_size + at_once][lanes];
  // Where `BlendGroup` keeps them:
  float weights[batch_size][lanes], most[lanes];  ///< that it blended with, and the largest
  const std::uint32_t* list;                      ///< @shape{size} of the batch's splats
  std::size_t size;
  std::size_t group, first;  ///< of the pixels: their array in a plane, and the first of them in it

  /// Loads the alphas of splats [i, i + at_once) of the list.
  HWY_INLINE void operator()(std::size_t i, Vec (&alpha)[at_once]) const {
    for (std::size_t j = 0; j < at_once; ++j) alpha[j] = hn::Load(F32(), alphas[i + j]);
  }
};

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
