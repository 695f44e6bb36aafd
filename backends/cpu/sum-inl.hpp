// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_SUM_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_SUM_INL
#undef SWIFTGS_CPU_SUM_INL
#else
#define SWIFTGS_CPU_SUM_INL
#endif

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <swiftgs/frame/raster.hpp>
#include <swiftgs/plane/attributes.hpp>

#include "batch-inl.hpp"
#include "raster_block-inl.hpp"
#include "store-inl.hpp"

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
  unsigned row = 0;
  // As many rows together as there are registers for.
  if constexpr (lanes == 16)
    for (; row + 4 <= attributes.rows; row += 4) SumRows<4>(row, of, state);
  for (; row + 2 <= attributes.rows; row += 2) SumRows<2>(row, of, state);
  if (row < attributes.rows) SumRows<1>(row, of, state);
}

/// Writes means, by `sum(sums, point)` of the `count` sums of a pixel. Turns these into rows.
template <class Groups, int count, class Sum>
HWY_INLINE void StoreMeans(const RasterBlockOfView& block, const Plane& transmittance, Plane* sums,
                           swiftgs::Plane<float> to, const Sum& sum) {
  if (!to.data) return;
  for (int k = 0; k < count; ++k) Groups::ToRows(sums[k]);
  for (std::size_t row = 0; row < std::size_t(block.rows); ++row)
    for (std::size_t column = 0; column < std::size_t(block.columns); ++column) {
      const std::size_t x = std::size_t(block.x0) + column, y = std::size_t(block.y0) + row;
      float of_pixel[count];
      for (int k = 0; k < count; ++k) of_pixel[k] = sums[k][row][column];
      const float alpha = 1 - std::abs(transmittance[row][column]);
      to.row(y)[x] = alpha > 0 ? sum(of_pixel, point_of(block.view, x, y)) / alpha : 0.0f;
    }
}

/// Writes normals. Turns the sums of their three channels into rows.
template <class Groups>
HWY_INLINE void StoreNormals(const RasterBlockOfView& block, Plane* sums, swiftgs::Plane<float> to) {
  const F32 d;
  for (int c = 0; c < 3; ++c) Groups::ToRows(sums[c]);
  for (std::size_t row = 0; row < std::size_t(block.rows); ++row) {
    alignas(64) float normals[3 * raster_block_side];
    for (std::size_t first = 0; first < raster_block_side; first += lanes) {
      const auto channel = [&](int c) HWY_ATTR { return hn::Load(d, sums[c][row] + first); };
      hn::StoreInterleaved3(channel(0), channel(1), channel(2), d, normals + 3 * first);
    }
    StreamWords(to.row(std::size_t(block.y0) + row) + 3 * block.x0, normals,
                3 * sizeof(float) * std::size_t(block.columns));
  }
}

/// Writes `count` channels of features, from the `channel`-th on. Their sums are those from the i-th on.
template <class Groups>
HWY_INLINE void StoreFeatures(const RasterBlockOfView& block, const Plane* sums, unsigned i, unsigned count,
                              int channel) {
  const F32 d;
  constexpr unsigned of_row = AttributeRow::channels;
  // The sums of a row are laid beside each other.
  alignas(64) float rows[AttributesView::most_rows][raster_block_side * raster_block_side][of_row];
  for (unsigned r = i / of_row; r * of_row < i + count; ++r)
    for (std::size_t group = 0; group < raster_block_side; ++group)
      for (std::size_t first = 0; first < raster_block_side; first += lanes) {
        const auto sum = [&](unsigned c)
                             HWY_ATTR { return hn::Load(d, sums[r * of_row + c][group] + first); };
        hn::StoreInterleaved4(sum(0), sum(1), sum(2), sum(3), d, rows[r][group * raster_block_side + first]);
      }
  const hn::CappedTag<float, of_row> d4;
  const FrameView& frame = block.view.frame;
  const std::size_t channels = std::size_t(frame.feature_channels);
  const auto address = reinterpret_cast<std::uintptr_t>(frame.features.data + channel);
  const bool by_rows = (i | count | unsigned(channels)) % of_row == 0 &&
                       (address | std::uintptr_t(frame.features.pitch)) % sizeof(AttributeRow) == 0;
  for (std::size_t row = 0; row < std::size_t(block.rows); ++row) {
    float* to = frame.features.row(std::size_t(block.y0) + row) + channels * std::size_t(block.x0) + channel;
    for (std::size_t column = 0; column < std::size_t(block.columns); ++column, to += channels) {
      const std::size_t pixel = Groups::Index(row, column);
      if (by_rows)
        for (unsigned k = 0; k < count; k += of_row)
          hn::Stream(hn::Load(d4, rows[(i + k) / of_row][pixel]), d4, to + k);
      else
        for (unsigned k = 0; k < count; ++k) to[k] = rows[(i + k) / of_row][pixel][(i + k) % of_row];
    }
  }
}

/// As `store_attributes`, a plane of all pixels at a time. `transmittance` lies in rows; leaves `state`
/// unspecified.
template <class Groups>
HWY_INLINE void StoreSums(const RasterJob& job, const RasterBlockOfView& block, const Plane& transmittance,
                          AttributeState& state) {
  using Of = Attribute::Of;
  const FrameView& frame = block.view.frame;
  const unsigned end = job.attributes.rows * AttributeRow::channels;
  for (unsigned i = 0, count = 0; i < end; i += count) {
    const Attribute of = attribute(block.view, block.view.frame, job.attributes.first + int(i));
    Plane* const sums = state.sums + i;
    switch (of.of) {
      case Of::ray_depth:
        StoreMeans<Groups, RayDepth::terms>(block, transmittance, sums, frame.depth,
                                            [](const float* sum, vec2 at) {
                                              return RayDepth{sum[0], sum[1], sum[2]}.at(at);
                                            });
        count = RayDepth::terms;
        break;
      case Of::squared_ray_depth:
        StoreMeans<Groups, RayDepth::squares>(block, transmittance, sums, frame.squared_depth,
                                              sum_of_squares);
        count = RayDepth::squares;
        break;
      case Of::squared_depth:
        StoreMeans<Groups, 1>(block, transmittance, sums, frame.squared_depth,
                              [](const float* sum, vec2) { return *sum; });
        count = 1;
        break;
      case Of::normal:
        StoreNormals<Groups>(block, sums, frame.normal);
        count = 3;
        break;
      case Of::feature:
        count = std::min(end - i, unsigned(frame.feature_channels - of.channel));
        StoreFeatures<Groups>(block, state.sums, i, count, of.channel);
        break;
      case Of::nothing:
        return;
    }
  }
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
