// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_RASTER_BLOCK_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_RASTER_BLOCK_INL
#undef SWIFTGS_CPU_RASTER_BLOCK_INL
#else
#define SWIFTGS_CPU_RASTER_BLOCK_INL
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include <hwy/highway.h>

#include <swiftgs/frame.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/functor/blend.hpp>

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Pixels of a raster block are dealt out to groups of 16: a register with AVX-512, two with AVX2, four with
/// SSE4 or NEON. A splat is evaluated on all pixels of a group at a time.
using F32 = hn::CappedTag<float, raster_block_side>;
using Vec = hn::Vec<F32>;
using Mask = hn::Mask<F32>;
constexpr std::size_t lanes = hn::MaxLanes(F32());
constexpr std::size_t parts = raster_block_side / lanes;

/// One quantity of a raster block's pixels, an array a group; or an array a row, before `FromRows` and after
/// `ToRows`.
template <class T>
using PlaneOf = T[raster_block_side][raster_block_side];
using Plane = PlaneOf<float>;

/// Running state of a raster block's pixels. A pixel that has stopped has the negative of its transmittance.
struct alignas(64) RasterBlockState {
  Plane transmittance, red, green, blue, depth, occluder;
};

/// A group is a row.
struct Rows {
  /// Registers of a group: where they are in the raster block.
  struct Part {
    std::size_t row, column;
    Part(std::size_t group, std::size_t part) : row(group), column(part * lanes) {}
  };
  template <class T>
  static HWY_INLINE void FromRows(PlaneOf<T>&) {}
  template <class T>
  static HWY_INLINE void ToRows(PlaneOf<T>&) {}
  /// Index of a pixel in a plane.
  static std::size_t Index(std::size_t row, std::size_t column) { return row * raster_block_side + column; }
};

/// A group is 4x4 pixels, which splats fill better than a row. Pixels go down the columns, so terms of rows,
/// which repeat every four pixels, load without a shuffle. Terms of columns are stored once a pixel of four
/// rows.
struct Blocks {
  static constexpr std::size_t side = 4;

  class Part {
   public:
    HWY_INLINE Part(std::size_t group, std::size_t part)
        : row_(group / side * side), pixel_(group % side * raster_block_side + part * lanes) {}
    /// Of terms of the pixels of four blocks side by side, or of the raster block's rows, that of each pixel.
    HWY_INLINE Vec OfPixels(const float* HWY_RESTRICT terms) const { return hn::Load(d, terms + pixel_); }
    HWY_INLINE Vec OfRows(const float* HWY_RESTRICT terms) const { return hn::LoadDup128(d, terms + row_); }

   private:
    static constexpr F32 d{};
    std::size_t row_, pixel_;  ///< the first of each
  };

  // Blocks lie column by column, so four blocks side by side are their four rows, interleaved.
  template <class T>
  static HWY_INLINE void FromRows(PlaneOf<T>& plane) {
    const hn::Rebind<T, F32> d;
    for (std::size_t i = 0; i < raster_block_side; i += side) {
      hn::Vec<decltype(d)> rows[parts][side];
      for (std::size_t part = 0; part < parts; ++part)
        for (std::size_t row = 0; row < side; ++row)
          rows[part][row] = hn::Load(d, plane[i + row] + part * lanes);
      for (std::size_t part = 0; part < parts; ++part) {
        const auto& [v0, v1, v2, v3] = rows[part];
        hn::StoreInterleaved4(v0, v1, v2, v3, d, plane[i] + part * side * lanes);
      }
    }
  }
  template <class T>
  static HWY_INLINE void ToRows(PlaneOf<T>& plane) {
    const hn::Rebind<T, F32> d;
    for (std::size_t i = 0; i < raster_block_side; i += side) {
      hn::Vec<decltype(d)> rows[parts][side];
      for (std::size_t part = 0; part < parts; ++part) {
        auto& [v0, v1, v2, v3] = rows[part];
        hn::LoadInterleaved4(d, plane[i] + part * side * lanes, v0, v1, v2, v3);
      }
      for (std::size_t part = 0; part < parts; ++part)
        for (std::size_t row = 0; row < side; ++row)
          hn::Store(rows[part][row], d, plane[i + row] + part * lanes);
    }
  }
  static std::size_t Index(std::size_t row, std::size_t column) {
    return row / side * side * raster_block_side + column * side + row % side;
  }
};

/// What is done beside blending colours.
enum class Blending {
  colours,
  depths,
  occluded,     ///< and depths: ends at an occluder
  row,          ///< a row of attributes
  weighed,      ///< keeps weights, for picks and attributes
  all_weighed,  ///< and depths, and ends at an occluder
  all_counted,  ///< and fills `RasterCounts`
};
constexpr bool SumsDepth(Blending b) {
  return b != Blending::colours && b != Blending::row && b != Blending::weighed;
}
constexpr bool IsOccluded(Blending b) { return b == Blending::occluded || b >= Blending::all_weighed; }
constexpr bool KeepsWeights(Blending b) { return b >= Blending::weighed; }

HWY_INLINE Blending BlendingOf(const RasterJob& job, const View& view) {
  if (job.counts) return Blending::all_counted;
  const bool occluded = view.frame.occluder.data, depths = job.sums_depth(view);
  if (job.picks(view) || job.attributes.rows != 0) {
    if (occluded || depths) return Blending::all_weighed;
    return job.picks(view) || job.attributes.rows != 1 ? Blending::weighed : Blending::row;
  }
  return occluded ? Blending::occluded : depths ? Blending::depths : Blending::colours;
}

HWY_INLINE void Fill(Plane& plane, float value) {
  const F32 d;
  for (auto& group : plane)
    for (std::size_t first = 0; first < raster_block_side; first += lanes)
      hn::Store(hn::Set(d, value), d, group + first);
}

/// Depths at which the frame's occluder hides splats.
template <class Groups>
HWY_INLINE void LoadOccluder(const RasterBlockOfView& block, Plane& occluder) {
  Fill(occluder, std::numeric_limits<float>::infinity());
  for (std::size_t row = 0; row < std::size_t(block.rows); ++row)
    for (std::size_t column = 0; column < std::size_t(block.columns); ++column)
      occluder[row][column] =
          block.view.frame.occluder_at(std::size_t(block.x0) + column, std::size_t(block.y0) + row);
  Groups::FromRows(occluder);
}

/// Transparent black, with the pixels beyond the image's borders already stopped.
template <class Groups>
HWY_INLINE void Clear(const RasterBlockOfView& block, Blending blending, RasterBlockState& state) {
  const F32 d;
  for (Plane* plane : {&state.red, &state.green, &state.blue}) Fill(*plane, 0);
  if (SumsDepth(blending)) Fill(state.depth, 0);
  for (std::size_t row = 0; row < raster_block_side; ++row)
    for (std::size_t column = 0; column < raster_block_side; column += lanes) {
      const int columns = int(row) < block.rows ? block.columns : 0;
      const Mask inside = hn::Lt(hn::Iota(d, float(column)), hn::Set(d, float(columns)));
      hn::Store(hn::IfThenElse(inside, hn::Set(d, 1.0f), hn::Set(d, -1.0f)), d,
                state.transmittance[row] + column);
    }
  if (block.columns < raster_block_side || block.rows < raster_block_side)
    Groups::FromRows(state.transmittance);
  if (!IsOccluded(blending)) return;
  if (block.view.frame.occluder.data && !hides_along_ray(block.view))
    LoadOccluder<Groups>(block, state.occluder);
  else
    Fill(state.occluder, std::numeric_limits<float>::infinity());
}

/// Bits of the arrays of `transmittance` that still have a live pixel.
HWY_INLINE std::uint32_t Live(const Plane& transmittance) {
  const F32 d;
  std::uint32_t live = 0;
  for (std::size_t group = 0; group < raster_block_side; ++group)
    for (std::size_t part = 0; part < parts; ++part)
      if (!hn::AllTrue(d, hn::Lt(hn::Load(d, transmittance[group] + part * lanes), hn::Zero(d))))
        live |= 1u << group;
  return live;
}

/// As `Live`, of the rows.
template <class Groups>
HWY_INLINE std::uint32_t LiveRows(const Plane& transmittance) {
  alignas(64) Plane rows;
  std::memcpy(rows, transmittance, sizeof rows);
  Groups::ToRows(rows);
  return Live(rows);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
