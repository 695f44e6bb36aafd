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
#include <cstring>

#include <hwy/highway.h>

#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/raster/raster.hpp>

#include "batch-inl.hpp"
#include "raster_block-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// Sums of the attributes of a raster block's pixels, and attributes of a batch.
struct alignas(64) AttributeState {
  Plane sums[AttributesView::most];
  float values[batch_size][AttributesView::most];  ///< of each splat
};

HWY_INLINE void ClearSums(const AttributesView& attributes, AttributeState& state) {
  for (std::size_t i = 0; i < attributes.rows * AttributeRow::channels; ++i) Fill(state.sums[i], 0);
}

/// Takes the attributes of the batch's k-th splat.
HWY_INLINE void LoadAttributes(const AttributesView& attributes, std::size_t splat, std::size_t k,
                               AttributeState& HWY_RESTRICT state) {
  for (unsigned r = 0; r < attributes.rows; ++r)
    std::memcpy(state.values[k] + r * AttributeRow::channels, &attributes.row(r, splat),
                sizeof(AttributeRow));
}

/// Rows that are summed together: as many as there are registers for.
constexpr unsigned rows_at_once = lanes == 16 ? AttributesView::most_rows : 2;

/// Adds `kRows` rows of attributes, from `row` on.
template <unsigned kRows>
HWY_INLINE void SumRows(unsigned row, const Evaluated& HWY_RESTRICT of, AttributeState& HWY_RESTRICT state) {
  constexpr std::size_t count = kRows * AttributeRow::channels;
  const F32 d;
  const std::size_t first = row * AttributeRow::channels;
  Vec sums[count];
  for (std::size_t c = 0; c < count; ++c) sums[c] = hn::Load(d, state.sums[first + c][of.group] + of.first);
  for (std::size_t i = 0; i < of.size; ++i) {
    const float* HWY_RESTRICT values = state.values[of.list[i]] + first;
    const Vec weight = hn::Load(d, of.weights[i]);
    for (std::size_t c = 0; c < count; ++c) sums[c] = hn::MulAdd(weight, hn::Set(d, values[c]), sums[c]);
  }
  for (std::size_t c = 0; c < count; ++c) hn::Store(sums[c], d, state.sums[first + c][of.group] + of.first);
}

/// Adds attributes by the weights that `BlendGroup` blended `of` with.
HWY_INLINE void SumGroup(const AttributesView& attributes, const Evaluated& HWY_RESTRICT of,
                         AttributeState& HWY_RESTRICT state) {
  static_assert(AttributesView::most_rows % rows_at_once == 0);
  if (attributes.rows == 1) return SumRows<1>(0, of, state);
  for (unsigned row = 0; row < attributes.rows; row += rows_at_once) SumRows<rows_at_once>(row, of, state);
}

/// Writes means that depend on the place, by `sum(sums, place)` of the `count` sums of a pixel. Turns these
/// into rows.
template <class Groups, int count, class Sum>
HWY_INLINE void StoreAlongRay(const PlacedRasterBlock& block, const Plane& transmittance, Plane* sums,
                              swiftgs::Plane<float> to, const Sum& sum) {
  if (!to.data) return;
  for (int k = 0; k < count; ++k) Groups::ToRows(sums[k]);
  for (std::size_t row = 0; row < std::size_t(block.rows); ++row)
    for (std::size_t column = 0; column < std::size_t(block.columns); ++column) {
      const std::size_t x = std::size_t(block.x0) + column, y = std::size_t(block.y0) + row;
      float of_pixel[count];
      for (int k = 0; k < count; ++k) of_pixel[k] = sums[k][row][column];
      const float alpha = 1 - std::abs(transmittance[row][column]);
      to.row(y)[x] = alpha > 0 ? sum(of_pixel, place_of(block.view, x, y)) / alpha : 0.0f;
    }
}

/// As `store_attributes`, a channel of all pixels at a time. `transmittance` lies in rows; turns `state` into
/// rows.
template <class Groups>
HWY_INLINE void StoreSums(const RasterJob& job, const PlacedRasterBlock& block, const Plane& transmittance,
                          AttributeState& state) {
  const View& view = block.view;
  const FrameView& frame = view.frame;
  for (unsigned i = 0; i < job.attributes.rows * AttributeRow::channels; ++i) {
    const Attribute to = attribute(view, job.attributes.first + int(i));
    if (to.of == Attribute::Of::nothing) return;
    if (to.of == Attribute::Of::ray_depth) {
      StoreAlongRay<Groups, RayDepth::terms>(block, transmittance, state.sums + i, frame.depth,
                                             [](const float* sums, vec2 at) {
                                               return RayDepth{sums[0], sums[1], sums[2]}.at(at);
                                             });
      i += RayDepth::terms - 1;
      continue;
    }
    if (to.of == Attribute::Of::squared_ray_depth) {
      StoreAlongRay<Groups, RayDepth::squares>(block, transmittance, state.sums + i, frame.squared_depth,
                                               sum_of_squares);
      i += RayDepth::squares - 1;
      continue;
    }
    const bool of_normal = to.of == Attribute::Of::normal, is_mean = to.of == Attribute::Of::squared_depth;
    const auto& plane = of_normal ? frame.normal : is_mean ? frame.squared_depth : frame.features;
    const std::size_t stride = of_normal ? 3 : is_mean ? 1 : std::size_t(frame.feature_channels);
    Plane& sums = state.sums[i];
    Groups::ToRows(sums);
    for (std::size_t row = 0; row < std::size_t(block.rows); ++row) {
      float* const first =
          plane.row(std::size_t(block.y0) + row) + stride * std::size_t(block.x0) + to.channel;
      for (std::size_t column = 0; column < std::size_t(block.columns); ++column) {
        const float alpha = 1 - std::abs(transmittance[row][column]), sum = sums[row][column];
        first[stride * column] = !is_mean ? sum : alpha > 0 ? sum / alpha : 0.0f;
      }
    }
  }
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
