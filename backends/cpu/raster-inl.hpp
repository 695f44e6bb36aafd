// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_RASTER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_RASTER_INL
#undef SWIFTGS_CPU_RASTER_INL
#else
#define SWIFTGS_CPU_RASTER_INL
#endif

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <swiftgs/raster/raster.hpp>

#include "exp2-inl.hpp"
#include "raster_block-inl.hpp"
#include "store-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Splats that are prepared together: their terms stay in the first-level cache while groups traverse them.
/// With 96 or 128, rasterizing takes 0.98 and 0.99 of the time in fox, and 1.04 and 1.06 in herz and garden.
constexpr std::size_t batch_size = 64;

/// Splats whose alphas are evaluated together: as many as there are registers for.
/// With AVX-512, two take as long as four, within the noise.
constexpr std::size_t at_once = lanes == 16 ? 4 : 2;

/// Exponents below are raised to it. -64 is less than any alpha that shows, whatever the opacity up to 2^24,
/// and far from denormal results, on which processors are slow. Conventions that show such alphas need more.
inline float LeastExponent(const BlendRules& rules) { return rules.log2_alpha_min < -40 ? -126.0f : -64.0f; }

/// A bit for each group and for each row of a raster block that a splat touches.
struct Touched {
  std::uint32_t groups, rows;
};

/// What every exponent representation needs of a batch.
struct alignas(64) Batch {
  std::uint32_t group_masks[batch_size];                       ///< bit g: the splat touches group g
  float colours[batch_size][4];                                ///< RGB, depth
  std::uint32_t lists[raster_block_side][batch_size + lanes];  ///< for each group the splats that touch it
  std::size_t list_sizes[raster_block_side];
};

/// A splat's factor applied to the pixels of a raster block: l0 dx + l1 dy is p[column] + q[row], measured
/// from the block's first pixel, so that what cancels there is rounded once. These terms refuse rows, and
/// make the Cholesky exponent.
struct alignas(64) CholeskyTerms {
  float p[raster_block_side], q[raster_block_side], c[raster_block_side];  ///< c = log2(opacity) - (l2 dy)^2
};

HWY_INLINE std::uint32_t BitsOf(Mask mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(F32(), mask, bytes);
  std::uint16_t bits;  // every processor that has these kernels has the low byte first
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}

/// Fills `terms`, and calls visit(i, touched) for each register of rows: its first row, and the mask of those
/// that `shape` touches, as `row_touched` decides them.
template <class Visit>
HWY_INLINE void VisitRows(const SplatShape& shape, vec2 first_centre, float log2_alpha_min,
                          CholeskyTerms& HWY_RESTRICT terms, const Visit& visit) {
  const F32 d;
  const Vec l0 = hn::Set(d, shape.l0), l1 = hn::Set(d, shape.l1), l2 = hn::Set(d, shape.l2);
  const Vec log2_opacity = hn::Set(d, swiftgs::log2_opacity(shape, log2_alpha_min, 1));
  const Vec first_dx = hn::Set(d, first_centre.x - shape.mean.x);
  const Vec first_dy = hn::Set(d, first_centre.y - shape.mean.y);
  const Vec first_u = hn::MulAdd(l0, first_dx, hn::Mul(l1, first_dy)), first_v = hn::Mul(l2, first_dy);
  for (std::size_t i = 0; i < raster_block_side; i += lanes)
    hn::Store(hn::Mul(l0, hn::Iota(d, float(i))), d, terms.p + i);
  const Vec last_p = hn::Set(d, terms.p[raster_block_side - 1]);
  for (std::size_t i = 0; i < raster_block_side; i += lanes) {
    const Vec row = hn::Iota(d, float(i));
    const Vec q = hn::MulAdd(l1, row, first_u), v = hn::MulAdd(l2, row, first_v);
    hn::Store(q, d, terms.q + i);
    hn::Store(hn::NegMulAdd(v, v, log2_opacity), d, terms.c + i);
    const Vec nearest = hn::Max(hn::Max(q, hn::Neg(hn::Add(last_p, q))), hn::Zero(d));
    // Against the cutoff, not against c: the rounding of a sum with log2(alpha_min) is far larger than the
    // cutoff of a faint splat, and would accept rows in tiles that conservative bounds do not list.
    visit(i, hn::Le(hn::MulAdd(nearest, nearest, hn::Mul(v, v)), hn::Set(d, shape.cutoff)));
  }
}

/// For representations whose groups are rows.
HWY_INLINE Touched PrepareRows(const SplatShape& shape, vec2 first_centre, float log2_alpha_min) {
  CholeskyTerms terms;
  std::uint32_t rows = 0;
  VisitRows(shape, first_centre, log2_alpha_min, terms,
            [&](std::size_t i, Mask touched) HWY_ATTR { rows |= BitsOf(touched) << i; });
  return {rows, rows};
}

/// The most of each four rows, in the lanes of all four.
HWY_INLINE Vec MostOfFour(Vec v) {
  v = hn::Max(v, hn::Shuffle2301(v));
  return hn::Max(v, hn::Shuffle1032(v));
}

/// Fills `terms`; c is minus infinity in rows that are not touched, since a 4x4 block may hold both kinds.
/// Each row has a conservative interval of columns, `half` wide on both sides of the splat's axis. A block is
/// touched if its columns overlap the union of its four rows' intervals.
///
/// A refused block keeps no pixel: a kept pixel has |p + q| below the `half` of its row, which is wider by
/// far more than any rounding; and p <= half - q survives rounding, because p is a float and rounding is
/// monotone.
HWY_INLINE Touched PrepareBlocks(const SplatShape& shape, vec2 first_centre, float log2_alpha_min,
                                 CholeskyTerms& HWY_RESTRICT terms) {
  static_assert(raster_block_side == 16 && Blocks::side == 4);
  const F32 d;
  const hn::RebindToSigned<F32> di;
  Touched all = {0, 0};
  // A lane of each four rows stands for a block: p in its first column, and in its last.
  const Vec column = hn::ConvertTo(d, hn::ShiftLeft<2>(hn::And(hn::Iota(di, 0), hn::Set(di, 3))));
  const Vec l0 = hn::Set(d, shape.l0);
  const Vec first = hn::Mul(l0, column), last = hn::Mul(l0, hn::Add(column, hn::Set(d, 3.0f)));
  VisitRows(shape, first_centre, log2_alpha_min, terms, [&](std::size_t i, Mask touched) HWY_ATTR {
    const Vec q = hn::Load(d, terms.q + i), none = hn::Neg(hn::Inf(d));
    const Vec c = hn::IfThenElse(touched, hn::Load(d, terms.c + i), none);
    hn::Store(c, d, terms.c + i);
    const Vec half = hn::Sqrt(hn::Sub(c, hn::Set(d, log2_alpha_min - 1e-3f)));
    const Vec most = MostOfFour(hn::IfThenElse(touched, hn::Sub(half, q), none));
    const Vec least = hn::Neg(MostOfFour(hn::IfThenElse(touched, hn::Add(half, q), none)));
    all.groups |= BitsOf(hn::And(hn::Le(first, most), hn::Ge(last, least))) << i;
    all.rows |= BitsOf(touched) << i;
  });
  return all;
}

/// Turns one mask of groups a splat into one list of splats a group.
HWY_INLINE void ListGroups(Batch& HWY_RESTRICT batch, std::size_t splats) {
  const hn::CappedTag<std::uint32_t, raster_block_side> d;
  for (std::size_t group = 0; group < raster_block_side; ++group) batch.list_sizes[group] = 0;
  for (std::size_t first = 0; first < splats; first += lanes) {
    const auto masks = hn::Load(d, batch.group_masks + first);
    const auto index = hn::Iota(d, std::uint32_t(first));
    for (std::size_t group = 0; group < raster_block_side; ++group) {
      const auto touched = hn::TestBit(masks, hn::Set(d, 1u << group));
      batch.list_sizes[group] +=
          hn::CompressStore(index, touched, d, batch.lists[group] + batch.list_sizes[group]);
    }
  }
  // Alphas are evaluated beyond the end, of whatever splat.
  for (std::size_t group = 0; group < raster_block_side; ++group)
    for (std::size_t i = 0; i + 1 < at_once; ++i) batch.lists[group][batch.list_sizes[group] + i] = 0;
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

/// What a pixel blends of an alpha that is evaluated: 0 if it skips the splat.
HWY_INLINE Vec CutAlpha(const BlendRules& rules, Vec alpha) {
  const F32 d;
  return hn::IfThenElseZero(hn::Ge(alpha, hn::Set(d, rules.alpha_min)),
                            hn::Min(alpha, hn::Set(d, rules.alpha_max)));
}

/// Blends the listed splats into one part of a group. The state stays in registers, so a splat costs its
/// arithmetic and the loads of its terms.
template <class Exponent, bool kDepth, bool kCount, bool kOccluder>
HWY_INLINE void BlendGroup(const Exponent& HWY_RESTRICT exponent, const Batch& HWY_RESTRICT batch,
                           const BlendRules& rules, RasterBlockState& HWY_RESTRICT state, std::size_t group,
                           std::size_t part, RasterCounts& counts) {
  const F32 d;
  const std::size_t first = part * lanes;
  const typename Exponent::Groups::Part place(group, part);
  Vec transmittance = hn::Load(d, state.transmittance[group] + first);
  const Mask ended = hn::Lt(transmittance, hn::Zero(d));
  if (hn::AllTrue(d, ended)) return;
  // Transmittance as if pixels did not stop. It only falls, so it alone tells whether a pixel stopped, and
  // each splat waits only for its multiply-add. NaN if the pixel stopped before.
  Vec through = hn::IfThenElse(ended, hn::NaN(d), transmittance);
  Vec red = hn::Load(d, state.red[group] + first);
  Vec green = hn::Load(d, state.green[group] + first);
  Vec blue = hn::Load(d, state.blue[group] + first);
  Vec depth = kDepth ? hn::Load(d, state.depth[group] + first) : hn::Zero(d);
  const Vec occluder = kOccluder ? hn::Load(d, state.occluder[group] + first) : hn::Zero(d);
  const Vec stop_below = hn::Set(d, rules.stop_below);

  const std::uint32_t* HWY_RESTRICT list = batch.lists[group];
  const std::size_t n = batch.list_sizes[group];
  alignas(64) float alphas[batch_size + at_once][lanes];  // 0 where a pixel skips the splat
  for (std::size_t i = 0; i < n; i += at_once) {
    Vec alpha[at_once];
    exponent.Alphas(list + i, place, alpha);
    for (std::size_t j = 0; j < at_once; ++j) hn::Store(alpha[j], d, alphas[i + j]);
  }

  for (std::size_t i = 0; i < n; ++i) {
    const float* HWY_RESTRICT colour = batch.colours[list[i]];
    const Vec alpha = hn::Load(d, alphas[i]), before = through;
    through = Dimmed(before, alpha);

    // A pixel ends without this splat if the splat would bring it below the limit, or if the caller's surface
    // hides the splat. A mask, not a branch: most pixels take it once, and no processor predicts when.
    const Mask kept = hn::Gt(alpha, hn::Zero(d));
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
  hn::Store(hn::Or(transmittance, sign), d, state.transmittance[group] + first);
  hn::Store(red, d, state.red[group] + first);
  hn::Store(green, d, state.green[group] + first);
  hn::Store(blue, d, state.blue[group] + first);
  if constexpr (kDepth) hn::Store(depth, d, state.depth[group] + first);
}

/// Asks for the splats of places [from, to) of the lists, up to `end`. Always inlined: gcc takes out calls of
/// functions that do nothing else.
HWY_INLINE void PrefetchSplats(const RasterJob& job, std::size_t from, std::size_t to, std::size_t end) {
  for (to = std::min(to, end); from < to; ++from) {
    hwy::Prefetch(&job.splats.shapes[job.lists.ids[from]]);
    hwy::Prefetch(&job.colours.each[job.lists.ids[from]]);
  }
}

/// Renders raster blocks [begin, end): traverses each list in batches, and each batch group by group.
template <class Exponent, bool kDepth, bool kCount, bool kOccluder>
void RenderRasterBlocks(const RasterJob& job, const RasterBlocks& blocks, std::size_t begin,
                        std::size_t end) {
  RasterBlockState state;
  Batch batch;
  const bool some_hidden = job.colours.some_hidden();

  for (std::size_t block = begin; block < end; ++block) {
    const PlacedRasterBlock place(job.views, blocks, block);
    RasterCounts counts;
    if (job.counts) job.counts[block] = counts;
    if (place.empty()) continue;
    const View& view = place.view;
    Exponent exponent(view.rules);
    Clear<typename Exponent::Groups, kDepth, kOccluder>(view.frame, place, state);
    const TileRange range = place.list(job);
    const std::uint32_t* ids = job.lists.ids.data;
    std::uint32_t live = range.begin < range.end ? Live(state.transmittance) : 0;
    PrefetchSplats(job, range.begin, range.begin + batch_size, range.end);
    PrefetchPixels(view.frame, place);
    for (std::size_t at = range.begin; at < range.end && live != 0; at += batch_size) {
      const std::uint32_t live_rows = kCount ? LiveRows<typename Exponent::Groups>(state.transmittance) : 0;
      // Prepare the splats of the batch: their terms, and the groups that each touches.
      const std::size_t splats = std::min<std::size_t>(batch_size, range.end - at);
      for (std::size_t k = 0; k < splats; ++k) {
        const std::uint32_t id = ids[at + k];
        std::memcpy(batch.colours[k], &job.colours.each[id], sizeof batch.colours[k]);
        Touched touched =
            exponent.Prepare(k, job.splats.shapes[id], place.first_centre, view.rules.log2_alpha_min);
        if (some_hidden && is_hidden(job.colours.each[id])) touched = {0, 0};
        batch.group_masks[k] = touched.groups & live;
        if constexpr (kCount) counts.rows_visited += std::uint64_t(std::popcount(touched.rows & live_rows));
      }
      for (std::size_t k = splats; k % lanes != 0; ++k) batch.group_masks[k] = 0;
      ListGroups(batch, splats);
      for (std::size_t group = 0; group < raster_block_side; ++group) {
        // The next batch's splats come from memory while this one's are blended.
        constexpr std::size_t share = batch_size / raster_block_side;
        const std::size_t next = at + batch_size + group * share;
        PrefetchSplats(job, next, next + share, range.end);
        if (batch.list_sizes[group] != 0)
          for (std::size_t part = 0; part < parts; ++part)
            BlendGroup<Exponent, kDepth, kCount, kOccluder>(exponent, batch, view.rules, state, group, part,
                                                            counts);
      }
      live = Live(state.transmittance);
      counts.intersections_visited += splats;
    }
    StoreRasterBlock<typename Exponent::Groups>(view, place, state);
    counts.longest_item = counts.intersections_visited;
    if (job.counts) job.counts[block] = counts;
  }
}

/// Renders what `job` asks for. Frames of colour, and of colour and depth, have loops of their own. All
/// others share two, with counts and without, since each takes long to compile.
template <class Exponent>
void RenderRasterBlocksOf(const RasterJob& job, const RasterBlocks& blocks, std::size_t begin,
                          std::size_t end) {
  const auto some_view = [&](const auto& wants) {
    return std::any_of(job.views.begin(), job.views.end(), wants);
  };
  if (job.counts)
    RenderRasterBlocks<Exponent, true, true, true>(job, blocks, begin, end);
  else if (some_view([](const View& view) { return view.frame.occluder.data != nullptr; }))
    RenderRasterBlocks<Exponent, true, false, true>(job, blocks, begin, end);
  else if (some_view([](const View& view) { return view.frame.depth.data != nullptr; }))
    RenderRasterBlocks<Exponent, true, false, false>(job, blocks, begin, end);
  else
    RenderRasterBlocks<Exponent, false, false, false>(job, blocks, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
