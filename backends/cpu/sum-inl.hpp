// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_SUM_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_SUM_INL
#undef SWIFTGS_CPU_SUM_INL
#else
#define SWIFTGS_CPU_SUM_INL
#endif

#include <cmath>
#include <cstddef>

#include <hwy/highway.h>

#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/raster/raster.hpp>

#include "batch-inl.hpp"
#include "raster_block-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// Sums of the attributes of a raster block's pixels.
struct alignas(64) AttributeState {
  Plane sums[AttributesView::most];
};

HWY_INLINE void ClearSums(const AttributesView& attributes, AttributeState& state) {
  for (std::size_t i = 0; i < attributes.rows * AttributeRow::channels; ++i) Fill(state.sums[i], 0);
}

/// Adds attributes by the weights that `BlendGroup` blended `of` with.
HWY_INLINE void SumGroup(const AttributesView& attributes, const Batch& HWY_RESTRICT batch,
                         const Evaluated& HWY_RESTRICT of, AttributeState& HWY_RESTRICT state) {
  static_assert(AttributeRow::channels == 4);
  const F32 d;
  for (unsigned r = 0; r < attributes.rows; ++r) {
    float* to[AttributeRow::channels];
    for (unsigned c = 0; c < AttributeRow::channels; ++c)
      to[c] = state.sums[r * AttributeRow::channels + c][of.group] + of.first;
    Vec sum0 = hn::Load(d, to[0]), sum1 = hn::Load(d, to[1]);
    Vec sum2 = hn::Load(d, to[2]), sum3 = hn::Load(d, to[3]);
    for (std::size_t i = 0; i < of.size; ++i) {
      const float* HWY_RESTRICT values = attributes.row(r, batch.splats[of.list[i]]).values;
      const Vec weight = hn::Load(d, of.weights[i]);
      sum0 = hn::MulAdd(weight, hn::Set(d, values[0]), sum0);
      sum1 = hn::MulAdd(weight, hn::Set(d, values[1]), sum1);
      sum2 = hn::MulAdd(weight, hn::Set(d, values[2]), sum2);
      sum3 = hn::MulAdd(weight, hn::Set(d, values[3]), sum3);
    }
    hn::Store(sum0, d, to[0]), hn::Store(sum1, d, to[1]);
    hn::Store(sum2, d, to[2]), hn::Store(sum3, d, to[3]);
  }
}

/// Writes the planes of attributes. `transmittance` lies in rows; turns `state` into rows.
template <class Groups>
HWY_INLINE void StoreSums(const RasterJob& job, const PlacedRasterBlock& block, const Plane& transmittance,
                          AttributeState& state) {
  for (std::size_t i = 0; i < job.attributes.rows * AttributeRow::channels; ++i)
    Groups::ToRows(state.sums[i]);
  for (std::size_t row = 0; row < std::size_t(block.rows); ++row)
    for (std::size_t column = 0; column < std::size_t(block.columns); ++column) {
      float sums[AttributesView::most];
      for (std::size_t i = 0; i < job.attributes.rows * AttributeRow::channels; ++i)
        sums[i] = state.sums[i][row][column];
      store_attributes(block.view.frame, job.attributes, std::size_t(block.x0) + column,
                       std::size_t(block.y0) + row, std::abs(transmittance[row][column]), sums);
    }
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
