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
#include <type_traits>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <swiftgs/raster/raster.hpp>

#include "exp2-inl.hpp"
#include "square-inl.hpp"
#include "store-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Splats that are prepared together: their terms stay in the first-level cache while rows walk over them.
constexpr std::size_t batch_size = 64;

/// Exponents below are raised to it: far less than any alpha that shows, and far from results that are
/// denormal, on which processors are slow.
constexpr float least_exponent = -64.0f;

/// What every form needs of the splats of a batch.
struct alignas(64) Batch {
  std::uint32_t row_masks[batch_size];                   ///< bit r: the splat touches row r
  float colours[batch_size][4];                          ///< RGB, depth
  std::uint32_t lists[square_side][batch_size + lanes];  ///< for each row the splats that touch it
  std::size_t list_sizes[square_side];
};

/// A splat's factor applied to the offsets of a square's columns and rows from its mean. Rows are refused by
/// these, and the Cholesky form is made of them.
struct alignas(64) CholeskyTerms {
  float p[square_side], q[square_side], c[square_side];  ///< l0 dx, l1 dy, log2(opacity) - (l2 dy)^2
};

/// Bits of the rows that `shape` touches, as `row_touched` decides them, all rows at once.
HWY_INLINE std::uint32_t PrepareRows(const SplatShape& shape, vec2 first_centre, float log2_alpha_min,
                                     CholeskyTerms& HWY_RESTRICT terms) {
  const F32 d;
  const Vec l0 = hn::Set(d, shape.l0), l1 = hn::Set(d, shape.l1), l2 = hn::Set(d, shape.l2);
  const Vec log2_opacity = hn::Set(d, shape.reach + log2_alpha_min);
  const float first_dx = first_centre.x - shape.mean.x, first_dy = first_centre.y - shape.mean.y;
  for (std::size_t i = 0; i < square_side; i += lanes)
    hn::Store(hn::Mul(l0, hn::Add(hn::Set(d, first_dx), hn::Iota(d, float(i)))), d, terms.p + i);
  const Vec first_p = hn::Set(d, terms.p[0]), last_p = hn::Set(d, terms.p[square_side - 1]);
  std::uint64_t rows = 0;
  for (std::size_t i = 0; i < square_side; i += lanes) {
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
  const hn::CappedTag<std::uint32_t, square_side> d;
  for (std::size_t row = 0; row < square_side; ++row) batch.list_sizes[row] = 0;
  for (std::size_t first = 0; first < splats; first += lanes) {
    const auto masks = hn::Load(d, batch.row_masks + first);
    const auto index = hn::Iota(d, std::uint32_t(first));
    for (std::size_t row = 0; row < square_side; ++row) {
      const auto touched = hn::TestBit(masks, hn::Set(d, 1u << row));
      batch.list_sizes[row] += hn::CompressStore(index, touched, d, batch.lists[row] + batch.list_sizes[row]);
    }
  }
}

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

/// Blends the listed splats into one part of a row. The state stays in registers, so a splat costs its
/// arithmetic and the loads of its terms.
template <class Form, bool kDepth, bool kCount, bool kOccluder>
HWY_INLINE void BlendRow(const Form& HWY_RESTRICT form, const Batch& HWY_RESTRICT batch,
                         const BlendRules& rules, SquareState& HWY_RESTRICT state, std::size_t row,
                         std::size_t part, SquareCounts& counts) {
  const F32 d;
  const std::size_t column = part * lanes;
  Vec transmittance = hn::Load(d, state.transmittance[row] + column);
  const Mask ended = hn::Lt(transmittance, hn::Zero(d));
  if (hn::AllTrue(d, ended)) return;
  // What transmittance were if pixels did not end. It only falls, so it alone says whether a pixel has ended, and
  // splats wait for nothing but its multiply-add. Not a number where the pixel ended before.
  Vec through = hn::IfThenElse(ended, hn::NaN(d), transmittance);
  Vec red = hn::Load(d, state.red[row] + column);
  Vec green = hn::Load(d, state.green[row] + column);
  Vec blue = hn::Load(d, state.blue[row] + column);
  Vec depth = kDepth ? hn::Load(d, state.depth[row] + column) : hn::Zero(d);
  const Vec occluder = kOccluder ? hn::Load(d, state.occluder[row] + column) : hn::Zero(d);
  const Vec stop_below = hn::Set(d, rules.stop_below), alpha_max = hn::Set(d, rules.alpha_max);

  const std::uint32_t* HWY_RESTRICT list = batch.lists[row];
  for (std::size_t i = 0, n = batch.list_sizes[row]; i < n; ++i) {
    const std::size_t k = list[i];
    Mask kept;
    Vec alpha;
    form.Alpha(k, row, column, kept, alpha);
    alpha = hn::IfThenElseZero(kept, hn::Min(alpha, alpha_max));
    const Vec before = through;
    through = Dimmed(before, alpha);

    // A pixel ends without this splat if the splat would bring it below the limit, or if the caller's surface
    // hides the splat. A mask, not a branch: most pixels take it once, and no processor predicts when.
    const float* HWY_RESTRICT colour = batch.colours[k];
    if constexpr (kOccluder)
      through = hn::IfThenElse(hn::And(kept, hn::Ge(hn::Set(d, colour[3]), occluder)), hn::NaN(d), through);
    const Mask goes_on = hn::Ge(through, stop_below);
    const Vec weight = hn::IfThenElseZero(goes_on, hn::Mul(alpha, before));
    if constexpr (kCount) {
      counts.pixels_stopped += hn::CountTrue(d, hn::AndNot(goes_on, hn::Ge(before, stop_below)));
      counts.contributing_pairs += hn::CountTrue(d, hn::And(goes_on, kept));
    }
    transmittance = hn::IfThenElse(goes_on, through, transmittance);
    red = hn::MulAdd(weight, hn::Set(d, colour[0]), red);
    green = hn::MulAdd(weight, hn::Set(d, colour[1]), green);
    blue = hn::MulAdd(weight, hn::Set(d, colour[2]), blue);
    if constexpr (kDepth) depth = hn::MulAdd(weight, hn::Set(d, colour[3]), depth);
  }

  const Vec sign = hn::IfThenZeroElse(hn::Ge(through, stop_below), hn::SignBit(d));
  hn::Store(hn::Or(transmittance, sign), d, state.transmittance[row] + column);
  hn::Store(red, d, state.red[row] + column);
  hn::Store(green, d, state.green[row] + column);
  hn::Store(blue, d, state.blue[row] + column);
  if constexpr (kDepth) hn::Store(depth, d, state.depth[row] + column);
}

/// Renders squares [begin, end): the list of each is walked in batches, and each batch row by row.
template <class Form, bool kDepth, bool kCount, bool kOccluder>
void RenderSquares(const RasterJob& job, const Squares& squares, std::size_t begin, std::size_t end) {
  SquareState state;
  Batch batch;
  const bool some_hidden = job.colours.some_hidden();

  for (std::size_t square = begin; square < end; ++square) {
    const PlacedSquare place(job.views, squares, square);
    SquareCounts counts;
    if (job.counts) job.counts[square] = counts;
    if (place.empty()) continue;
    const View& view = place.view;
    Form form(view.rules);
    const float log2_alpha_min = std::log2(view.rules.alpha_min);
    Clear<kDepth, kOccluder>(view.frame, place, state);
    const TileRange range = place.list(job);
    const std::uint32_t* ids = job.lists.ids.data;
    std::uint32_t live_rows = range.begin < range.end ? LiveRows(place, state) : 0;
    for (std::size_t at = range.begin; at < range.end && live_rows != 0; at += batch_size) {
      // Prepare the splats of the batch: their terms, and the rows that each touches.
      const std::size_t splats = std::min<std::size_t>(batch_size, range.end - at);
      for (std::size_t k = 0; k < splats; ++k) {
        const std::size_t ahead = at + k + 12;
        if (ahead < range.end) {
          hwy::Prefetch(&job.splats.shapes[ids[ahead]]);
          hwy::Prefetch(&job.colours.each[ids[ahead]]);
        }
        const std::uint32_t id = ids[at + k];
        std::memcpy(batch.colours[k], &job.colours.each[id], sizeof batch.colours[k]);
        batch.row_masks[k] =
            form.Prepare(k, job.splats.shapes[id], place.first_centre, log2_alpha_min) & live_rows;
        if (some_hidden && is_hidden(job.colours.each[id])) batch.row_masks[k] = 0;
      }
      for (std::size_t k = splats; k % lanes != 0; ++k) batch.row_masks[k] = 0;
      ListRows(batch, splats);
      for (int row = 0; row < place.rows; ++row)
        if (batch.list_sizes[row] != 0) {
          if constexpr (kCount) counts.rows_visited += batch.list_sizes[row];
          for (std::size_t part = 0; part < parts; ++part)
            BlendRow<Form, kDepth, kCount, kOccluder>(form, batch, view.rules, state, std::size_t(row), part,
                                                      counts);
        }
      live_rows = LiveRows(place, state);
      counts.instances_visited += splats;
    }
    StoreSquare(view, place, state);
    counts.longest_item = counts.instances_visited;
    if (job.counts) job.counts[square] = counts;
  }
}

/// Renders with what `job` asks for. Frames that ask for colour, or for depth too, are not slowed by what
/// others ask for; of the rest there is one kind with counts and one without, since each kind takes long to
/// compile.
template <class Form>
void RenderSquaresOf(const RasterJob& job, const Squares& squares, std::size_t begin, std::size_t end) {
  const auto some_view = [&](const auto& wants) {
    return std::any_of(job.views.begin(), job.views.end(), wants);
  };
  if (job.counts)
    RenderSquares<Form, true, true, true>(job, squares, begin, end);
  else if (some_view([](const View& view) { return view.frame.occluder.data != nullptr; }))
    RenderSquares<Form, true, false, true>(job, squares, begin, end);
  else if (some_view([](const View& view) { return view.frame.depth.data != nullptr; }))
    RenderSquares<Form, true, false, false>(job, squares, begin, end);
  else
    RenderSquares<Form, false, false, false>(job, squares, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
