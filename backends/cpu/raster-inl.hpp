// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_RASTER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_RASTER_INL
#undef SWIFTGS_CPU_RASTER_INL
#else
#define SWIFTGS_CPU_RASTER_INL
#endif

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <swiftgs/raster/raster.hpp>

#include "exp2-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A row of a tile is 16 lanes: one register with AVX-512, two with AVX2, four with SSE4 or NEON.
using F32 = hn::CappedTag<float, tile_side>;
using Vec = hn::Vec<F32>;
using Mask = hn::Mask<F32>;
constexpr std::size_t lanes = hn::MaxLanes(F32());
constexpr std::size_t parts = tile_side / lanes;

/// Splats that are prepared together: their terms stay in the first-level cache while rows walk over them.
constexpr std::size_t batch_size = 64;

/// Exponents below are raised to it: far less than any alpha that shows, and far from results that are
/// denormal, on which processors are slow.
constexpr float least_exponent = -64.0f;

/// What every form needs of the splats of a batch.
struct alignas(64) Batch {
  std::uint32_t row_masks[batch_size];                 ///< bit r: the splat touches row r
  float colours[batch_size][4];                        ///< RGB, depth
  std::uint32_t lists[tile_side][batch_size + lanes];  ///< for each row the splats that touch it
  std::size_t list_sizes[tile_side];
};

/// Running state of a tile's pixels, one array a quantity. A pixel that has stopped has the negative of its
/// transmittance: any splat would bring that below the limit, so it stays stopped without a mask of its own.
struct alignas(64) TileState {
  float transmittance[tile_side][tile_side];
  float red[tile_side][tile_side], green[tile_side][tile_side], blue[tile_side][tile_side];
  float depth[tile_side][tile_side];
};

/// Places of one tile in the image.
struct TileFrame {
  vec2 first_centre;
  int columns, rows;
};

/// A splat's factor applied to the offsets of a tile's columns and rows from its mean: what rows are refused
/// by, and what the Cholesky form is made of.
struct alignas(64) CholeskyTerms {
  float p[tile_side], q[tile_side], c[tile_side];  ///< l0 dx, l1 dy, log2(opacity) - (l2 dy)^2
};

/// Bits of the rows that `shape` touches, as `row_touched` decides them, all rows at once.
HWY_INLINE std::uint32_t PrepareRows(const SplatShape& shape, vec2 first_centre, float log2_alpha_min,
                                     CholeskyTerms& HWY_RESTRICT terms) {
  const F32 d;
  const Vec l0 = hn::Set(d, shape.l0), l1 = hn::Set(d, shape.l1), l2 = hn::Set(d, shape.l2);
  const Vec log2_opacity = hn::Set(d, shape.reach + log2_alpha_min);
  const float first_dx = first_centre.x - shape.mean.x, first_dy = first_centre.y - shape.mean.y;
  for (std::size_t i = 0; i < tile_side; i += lanes)
    hn::Store(hn::Mul(l0, hn::Add(hn::Set(d, first_dx), hn::Iota(d, float(i)))), d, terms.p + i);
  const Vec first_p = hn::Set(d, terms.p[0]), last_p = hn::Set(d, terms.p[tile_side - 1]);
  std::uint64_t rows = 0;
  for (std::size_t i = 0; i < tile_side; i += lanes) {
    const Vec dy = hn::Add(hn::Set(d, first_dy), hn::Iota(d, float(i)));
    const Vec q = hn::Mul(l1, dy), v = hn::Mul(l2, dy);
    const Vec c = hn::NegMulAdd(v, v, log2_opacity);
    hn::Store(q, d, terms.q + i);
    hn::Store(c, d, terms.c + i);
    const Vec nearest = hn::Max(hn::Max(hn::Add(first_p, q), hn::Neg(hn::Add(last_p, q))), hn::Zero(d));
    // Against the reach, not against c: the rounding of a sum with log2(alpha_min) is far larger than the
    // reach of a faint splat, and would accept rows in tiles that lossless bounds do not list.
    const Mask touched = hn::Le(hn::MulAdd(nearest, nearest, hn::Mul(v, v)), hn::Set(d, shape.reach));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, touched, bits);
    rows |= std::uint64_t(bits[0] | std::uint32_t(bits[1]) << 8) << i;
  }
  return std::uint32_t(rows);
}

/// Turns one mask of rows a splat into one list of splats a row.
HWY_INLINE void ListRows(Batch& HWY_RESTRICT batch, std::size_t splats) {
  const hn::CappedTag<std::uint32_t, tile_side> d;
  for (std::size_t row = 0; row < tile_side; ++row) batch.list_sizes[row] = 0;
  for (std::size_t first = 0; first < splats; first += lanes) {
    const auto masks = hn::Load(d, batch.row_masks + first);
    const auto index = hn::Iota(d, std::uint32_t(first));
    for (std::size_t row = 0; row < tile_side; ++row) {
      const auto touched = hn::TestBit(masks, hn::Set(d, 1u << row));
      batch.list_sizes[row] += hn::CompressStore(index, touched, d, batch.lists[row] + batch.list_sizes[row]);
    }
  }
}

/// Blends the listed splats into one part of a row. The state stays in registers, so a splat costs its
/// arithmetic and the loads of its terms.
template <class Form, bool kDepth, bool kCount>
HWY_INLINE void BlendRow(const Form& HWY_RESTRICT form, const Batch& HWY_RESTRICT batch,
                         const BlendRules& rules, TileState& HWY_RESTRICT state, std::size_t row,
                         std::size_t part, TileCounts& counts) {
  const F32 d;
  const std::size_t column = part * lanes;
  Vec transmittance = hn::Load(d, state.transmittance[row] + column);
  if (hn::AllTrue(d, hn::Lt(transmittance, hn::Zero(d)))) return;
  Vec red = hn::Load(d, state.red[row] + column);
  Vec green = hn::Load(d, state.green[row] + column);
  Vec blue = hn::Load(d, state.blue[row] + column);
  Vec depth = kDepth ? hn::Load(d, state.depth[row] + column) : hn::Zero(d);
  const Vec stop_below = hn::Set(d, rules.stop_below), alpha_max = hn::Set(d, rules.alpha_max);

  const std::uint32_t* HWY_RESTRICT list = batch.lists[row];
  for (std::size_t i = 0, n = batch.list_sizes[row]; i < n; ++i) {
    const std::size_t k = list[i];
    Mask kept;
    Vec alpha;
    form.Alpha(k, row, column, kept, alpha);
    alpha = hn::IfThenElseZero(kept, hn::Min(alpha, alpha_max));
    const Vec next = hn::NegMulAdd(alpha, transmittance, transmittance);

    // Pixels that this splat would bring below the limit end without it. Masks see to them, since a branch
    // would be taken once for most pixels and never where it was last time.
    const Mask stops = hn::Lt(next, stop_below);
    const Vec weight = hn::IfThenZeroElse(stops, hn::Mul(alpha, transmittance));
    if constexpr (kCount) {
      counts.pixels_stopped += hn::CountTrue(d, hn::And(stops, hn::Gt(transmittance, hn::Zero(d))));
      counts.contributing_pairs += hn::CountTrue(d, hn::AndNot(stops, kept));
    }
    transmittance = hn::IfThenElse(stops, hn::Or(transmittance, hn::SignBit(d)), next);
    const float* HWY_RESTRICT colour = batch.colours[k];
    red = hn::MulAdd(weight, hn::Set(d, colour[0]), red);
    green = hn::MulAdd(weight, hn::Set(d, colour[1]), green);
    blue = hn::MulAdd(weight, hn::Set(d, colour[2]), blue);
    if constexpr (kDepth) depth = hn::MulAdd(weight, hn::Set(d, colour[3]), depth);
  }

  hn::Store(transmittance, d, state.transmittance[row] + column);
  hn::Store(red, d, state.red[row] + column);
  hn::Store(green, d, state.green[row] + column);
  hn::Store(blue, d, state.blue[row] + column);
  if constexpr (kDepth) hn::Store(depth, d, state.depth[row] + column);
}

/// Transparent black, with the pixels beyond the image's right border already stopped.
template <bool kDepth>
HWY_INLINE void Clear(const TileFrame& tile, TileState& state) {
  const F32 d;
  for (std::size_t row = 0; row < tile_side; ++row)
    for (std::size_t part = 0; part < parts; ++part) {
      const std::size_t column = part * lanes;
      const Mask inside = hn::Lt(hn::Iota(d, float(column)), hn::Set(d, float(tile.columns)));
      hn::Store(hn::IfThenElse(inside, hn::Set(d, 1.0f), hn::Set(d, -1.0f)), d,
                state.transmittance[row] + column);
      hn::Store(hn::Zero(d), d, state.red[row] + column);
      hn::Store(hn::Zero(d), d, state.green[row] + column);
      hn::Store(hn::Zero(d), d, state.blue[row] + column);
      if constexpr (kDepth) hn::Store(hn::Zero(d), d, state.depth[row] + column);
    }
}

/// Bits of the rows that still have a live pixel.
HWY_INLINE std::uint32_t LiveRows(const TileFrame& tile, const TileState& state) {
  const F32 d;
  std::uint32_t rows = 0;
  for (int row = 0; row < tile.rows; ++row)
    for (std::size_t part = 0; part < parts; ++part)
      if (!hn::AllTrue(d, hn::Lt(hn::Load(d, state.transmittance[row] + part * lanes), hn::Zero(d))))
        rows |= 1u << row;
  return rows;
}

/// Writes the outputs that are asked for.
HWY_INLINE void StoreTile(const RasterJob& job, const TileFrame& tile, std::size_t x0, std::size_t y0,
                          TileState& state) {
  const F32 d;
  const FrameView& frame = job.frame;
  for (std::size_t row = 0; row < std::size_t(tile.rows); ++row) {
    alignas(64) float rgb[3 * tile_side];
    alignas(64) float alphas[tile_side], depths[tile_side];
    for (std::size_t column = 0; column < tile_side; column += lanes) {
      const Vec transmittance = hn::Abs(hn::Load(d, state.transmittance[row] + column));
      const auto over = [&](const float* colour, float background) HWY_ATTR {
        return hn::MulAdd(transmittance, hn::Set(d, background), hn::Load(d, colour + column));
      };
      hn::StoreInterleaved3(over(state.red[row], job.background.x), over(state.green[row], job.background.y),
                            over(state.blue[row], job.background.z), d, rgb + 3 * column);
      if (!frame.alpha && !frame.depth) continue;
      const Vec alpha = hn::Sub(hn::Set(d, 1.0f), transmittance);
      hn::Store(alpha, d, alphas + column);
      if (frame.depth) {
        const Vec mean = hn::Div(hn::Load(d, state.depth[row] + column), alpha);
        hn::Store(hn::IfThenElseZero(hn::Gt(alpha, hn::Zero(d)), mean), d, depths + column);
      }
    }
    const std::size_t columns = std::size_t(tile.columns), y = y0 + row;
    if (frame.colour)
      std::memcpy(frame.colour + y * frame.colour_pitch + 3 * x0, rgb, 3 * columns * sizeof(float));
    if (frame.alpha) std::memcpy(frame.alpha + y * frame.alpha_pitch + x0, alphas, columns * sizeof(float));
    if (frame.depth) std::memcpy(frame.depth + y * frame.depth_pitch + x0, depths, columns * sizeof(float));
  }
}

/// Renders tiles [begin, end): lists of each are walked in batches, and each batch row by row.
template <class Form, bool kDepth, bool kCount>
void RenderTiles(const RasterJob& job, std::size_t begin, std::size_t end) {
  TileState state;
  Batch batch;
  Form form(job.rules);
  const float log2_alpha_min = std::log2(job.rules.alpha_min);

  for (std::size_t tile = begin; tile < end; ++tile) {
    const std::size_t x0 = tile % std::size_t(job.grid.columns) * tile_side;
    const std::size_t y0 = tile / std::size_t(job.grid.columns) * tile_side;
    const TileFrame place{vec2(float(x0) + 0.5f, float(y0) + 0.5f),
                          std::min(tile_side, job.frame.width - int(x0)),
                          std::min(tile_side, job.frame.height - int(y0))};
    Clear<kDepth>(place, state);
    TileCounts counts;
    const TileRange range = job.lists.ranges[tile];
    const std::uint32_t* ids = job.lists.ids.data;
    std::uint32_t live_rows = range.begin < range.end ? LiveRows(place, state) : 0;
    for (std::size_t at = range.begin; at < range.end && live_rows != 0; at += batch_size) {
      // Prepare the splats of the batch: their terms, and the rows that each touches.
      const std::size_t splats = std::min<std::size_t>(batch_size, range.end - at);
      for (std::size_t k = 0; k < splats; ++k) {
        const std::size_t ahead = at + k + 12;
        if (ahead < range.end) {
          hwy::Prefetch(&job.splats.shapes[ids[ahead]]);
          hwy::Prefetch(&job.splats.colours[ids[ahead]]);
        }
        const std::uint32_t id = ids[at + k];
        std::memcpy(batch.colours[k], &job.splats.colours[id], sizeof batch.colours[k]);
        batch.row_masks[k] =
            form.Prepare(k, job.splats.shapes[id], place.first_centre, log2_alpha_min) & live_rows;
      }
      for (std::size_t k = splats; k % lanes != 0; ++k) batch.row_masks[k] = 0;
      ListRows(batch, splats);
      for (int row = 0; row < place.rows; ++row)
        if (batch.list_sizes[row] != 0) {
          if constexpr (kCount) counts.rows_visited += batch.list_sizes[row];
          for (std::size_t part = 0; part < parts; ++part)
            BlendRow<Form, kDepth, kCount>(form, batch, job.rules, state, std::size_t(row), part, counts);
        }
      live_rows = LiveRows(place, state);
      counts.instances_visited += splats;
    }
    StoreTile(job, place, x0, y0, state);
    if (job.counts) job.counts[tile] = counts;
  }
}

/// Renders with the outputs and counters that `job` asks for, and nothing else.
template <class Form>
void RenderTilesOf(const RasterJob& job, std::size_t begin, std::size_t end) {
  if (job.counts)
    job.frame.depth ? RenderTiles<Form, true, true>(job, begin, end)
                    : RenderTiles<Form, false, true>(job, begin, end);
  else
    job.frame.depth ? RenderTiles<Form, true, false>(job, begin, end)
                    : RenderTiles<Form, false, false>(job, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
