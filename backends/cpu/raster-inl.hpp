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
#include <type_traits>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <swiftgs/frame/raster.hpp>
#include <swiftgs/functor/blend.hpp>

#include "batch-inl.hpp"
#include "blend-inl.hpp"
#include "draw-inl.hpp"
#include "exp2-inl.hpp"
#include "raster_block-inl.hpp"
#include "shapes-inl.hpp"
#include "store-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// Exponents below are raised to it. -64 is less than any alpha that shows, whatever the opacity up to 2^24,
/// and far from denormal results, on which processors are slow. Conventions that show such alphas need more.
inline float LeastExponent(const BlendRules& rules) { return rules.log2_alpha_min < -40 ? -126.0f : -64.0f; }

/// A bit for each group and for each row of a raster block that a splat touches.
struct Touched {
  std::uint32_t groups, rows;
};

/// What `VisitRows` broadcasts of a batch's splats, one array per number: a broadcast from memory occupies no
/// arithmetic unit. Distances are from the mean to the raster block's first pixel centre.
struct alignas(64) RowFactors {
  float l0[batch_size], l1[batch_size], l2[batch_size], cutoff[batch_size], log2_opacity[batch_size];
  float u[batch_size], v[batch_size];  ///< l0 dx + l1 dy, l2 dy
  float minus_last_p[batch_size];      ///< -l0 times the last column: -p there

  /// Reads `shapes` up to the next multiple of `lanes`. Numbers from `count` on are never used.
  HWY_INLINE RowFactors(const SplatShape* HWY_RESTRICT shapes, std::size_t count, vec2 first_centre,
                        float log2_alpha_min) {
    const F32 d;
    const hn::RebindToUnsigned<F32> du;
    for (std::size_t k = 0; k < count; ++k)
      log2_opacity[k] = swiftgs::log2_opacity(shapes[k], log2_alpha_min, 1);
    for (std::size_t k = 0; k < count; k += lanes) {
      const ShapesOf<Vec> s = LoadShapes(d, shapes + k);
      // As `SplatShape::from_mean`.
      const auto low = hn::BitCast(du, s.low);
      const auto from = [&](float at, Vec mean, hn::Vec<decltype(du)> units) HWY_ATTR {
        const Vec lacks = hn::ConvertTo(d, hn::BitCast(hn::RebindToSigned<F32>(), units));
        return hn::NegMulAdd(hn::Set(d, SplatShape::low_unit), lacks, hn::Sub(hn::Set(d, at), mean));
      };
      const Vec dx = from(first_centre.x, s.mean_x, hn::And(low, hn::Set(du, 0xffffu)));
      const Vec dy = from(first_centre.y, s.mean_y, hn::ShiftRight<16>(low));
      hn::Store(s.l0, d, l0 + k), hn::Store(s.l1, d, l1 + k), hn::Store(s.l2, d, l2 + k);
      hn::Store(s.cutoff, d, cutoff + k);
      hn::Store(hn::MulAdd(s.l0, dx, hn::Mul(s.l1, dy)), d, u + k);
      hn::Store(hn::Mul(s.l2, dy), d, v + k);
      hn::Store(hn::Mul(s.l0, hn::Set(d, 1 - float(raster_block_side))), d, minus_last_p + k);
    }
  }
};

/// A splat's factor applied to the pixels of a raster block: l0 dx + l1 dy is p of the column + q of the row,
/// measured from the block's first pixel, so that what cancels there is rounded once. These terms refuse
/// rows, and make the Cholesky exponent.
struct alignas(64) CholeskyTerms {
  float p[Blocks::side * raster_block_side];         ///< once a pixel of four blocks side by side
  float q[raster_block_side], c[raster_block_side];  ///< c = log2(opacity) - (l2 dy)^2
};

HWY_INLINE std::uint32_t BitsOf(Mask mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(F32(), mask, bytes);
  std::uint16_t bits;  // every processor that has these kernels has the low byte first
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}

/// Fills `terms` of splat k, and calls visit(i, touched) for each register of rows: its first row, and the
/// mask of those that the splat touches, as `row_touched` decides them.
template <class Visit>
HWY_INLINE void VisitRows(const RowFactors& HWY_RESTRICT of, std::size_t k, CholeskyTerms& HWY_RESTRICT terms,
                          const Visit& visit) {
  const F32 d;
  const Vec l0 = hn::Set(d, of.l0[k]), l1 = hn::Set(d, of.l1[k]), l2 = hn::Set(d, of.l2[k]);
  const Vec first_u = hn::Set(d, of.u[k]), first_v = hn::Set(d, of.v[k]);
  for (std::size_t i = 0; i < Blocks::side * raster_block_side; i += lanes) {
    static_assert(Blocks::side == 1 << 2);
    const Vec column = hn::ConvertTo(d, hn::ShiftRight<2>(hn::Iota(hn::RebindToSigned<F32>(), int(i))));
    hn::Store(hn::Mul(l0, column), d, terms.p + i);
  }
  for (std::size_t i = 0; i < raster_block_side; i += lanes) {
    const Vec row = hn::Iota(d, float(i));
    const Vec q = hn::MulAdd(l1, row, first_u), v = hn::MulAdd(l2, row, first_v);
    hn::Store(q, d, terms.q + i);
    hn::Store(hn::NegMulAdd(v, v, hn::Set(d, of.log2_opacity[k])), d, terms.c + i);
    const Vec from_last = hn::Sub(hn::Set(d, of.minus_last_p[k]), q);
    const Vec nearest = hn::Max(hn::Max(q, from_last), hn::Zero(d));
    // Against the cutoff, not against c: the rounding of a sum with log2(alpha_min) is far larger than the
    // cutoff of a faint splat, and would accept rows in tiles that conservative bounds do not list.
    visit(i, hn::Le(hn::MulAdd(nearest, nearest, hn::Mul(v, v)), hn::Set(d, of.cutoff[k])));
  }
}

/// For representations whose groups are rows.
HWY_INLINE Touched PrepareRows(const RowFactors& of, std::size_t k) {
  CholeskyTerms terms;
  std::uint32_t rows = 0;
  VisitRows(of, k, terms, [&](std::size_t i, Mask touched) HWY_ATTR { rows |= BitsOf(touched) << i; });
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
HWY_INLINE Touched PrepareBlocks(const RowFactors& of, std::size_t k, float log2_alpha_min,
                                 CholeskyTerms& HWY_RESTRICT terms) {
  static_assert(raster_block_side == 16 && Blocks::side == 4);
  const F32 d;
  const hn::RebindToSigned<F32> di;
  Touched all = {0, 0};
  // A lane of each four rows stands for a block: p in its first column, and -p in its last.
  const Vec column = hn::ConvertTo(d, hn::ShiftLeft<2>(hn::And(hn::Iota(di, 0), hn::Set(di, 3))));
  const Vec l0 = hn::Set(d, of.l0[k]);
  const Vec first = hn::Mul(l0, column), minus_last = hn::Mul(l0, hn::Sub(hn::Set(d, -3.0f), column));
  VisitRows(of, k, terms, [&](std::size_t i, Mask touched) HWY_ATTR {
    const Vec q = hn::Load(d, terms.q + i), none = hn::Neg(hn::Inf(d));
    const Vec c = hn::IfThenElse(touched, hn::Load(d, terms.c + i), none);
    hn::Store(c, d, terms.c + i);
    const Vec half = hn::Sqrt(hn::Sub(c, hn::Set(d, log2_alpha_min - 1e-3f)));
    const Vec most = MostOfFour(hn::IfThenElse(touched, hn::Sub(half, q), none));
    const Vec minus_least = MostOfFour(hn::IfThenElse(touched, hn::Add(half, q), none));
    all.groups |= BitsOf(hn::And(hn::Le(first, most), hn::Le(minus_last, minus_least))) << i;
    all.rows |= BitsOf(touched) << i;
  });
  return all;
}

/// What a pixel blends of an alpha that is evaluated: 0 if it skips the splat.
HWY_INLINE Vec CutAlpha(const BlendRules& rules, Vec alpha) {
  const F32 d;
  return hn::IfThenElseZero(hn::Ge(alpha, hn::Set(d, rules.alpha_min)),
                            hn::Min(alpha, hn::Set(d, rules.alpha_max)));
}

/// Asks for the splats of positions [from, to) of the lists, up to `end`. Always inlined: gcc takes out calls
/// of functions that do nothing else.
HWY_INLINE void PrefetchSplats(const RasterJob& job, std::size_t from, std::size_t to, std::size_t end) {
  for (to = std::min(to, end); from < to; ++from) {
    hwy::Prefetch(&job.splats.shapes[job.lists.ids[from]]);
    hwy::Prefetch(&job.colours.each[job.lists.ids[from]]);
    if (job.attributes.rows != 0) hwy::Prefetch(&job.attributes.row(0, job.lists.ids[from]));
  }
}

/// Selects the splats that `batch` lists for `group`, and one part of its pixels. False if these have
/// stopped.
HWY_INLINE bool Select(const Batch& HWY_RESTRICT batch, const RasterBlockState& state, std::size_t group,
                       std::size_t part, Evaluated& HWY_RESTRICT out) {
  const F32 d;
  const Vec before = hn::Load(d, state.transmittance[group] + part * lanes);
  if (hn::AllTrue(d, hn::Lt(before, hn::Zero(d)))) return false;
  hn::Store(before, d, out.before);
  out.list = batch.lists[group], out.size = batch.list_sizes[group];
  out.group = group, out.first = part * lanes;
  return true;
}

/// Renders raster blocks [begin, end): traverses each list in batches, and each batch group by group.
/// `kColours`: all views are of `Blending::colours`.
template <class Exponent, bool kColours>
void RenderRasterBlocks(const RasterJob& job, const RasterBlocks& blocks, std::size_t begin,
                        std::size_t end) {
  using Groups = typename Exponent::Groups;
  RasterBlockState state;
  PickState picks;
  AttributeState sums;
  RayState rays;
  Batch batch;
  Evaluated evaluated;
  const bool some_colourless = job.colours.some_colourless(), counted = !kColours && job.counts;

  for (std::size_t block = begin; block < end; ++block) {
    const RasterBlockOfView here(job.views, blocks, block);
    RasterCounts counts;
    if (job.counts) job.counts[block] = counts;
    if (here.empty()) continue;
    const View& view = here.view;
    const BlendRules rules = view.rules;
    Exponent exponent(rules);
    const Blending blending = kColours ? Blending::colours : BlendingOf(job, view);
    [[maybe_unused]] const DrawFunction draw_group = DrawFunctionOf(blending);
    const PlaneStates planes{!kColours && job.picks(view) ? &picks : nullptr,
                             !kColours && job.attributes.rows != 0 ? &sums : nullptr,
                             !kColours && hides_along_ray(view) ? &rays : nullptr};
    Begin<Groups>(job, here, blending, state, planes);
    const TileRange range = here.list(job);
    std::uint32_t live = range.begin < range.end ? Live(state.transmittance) : 0;
    PrefetchSplats(job, range.begin, range.begin + batch_size, range.end);
    if (!job.only_attributes) PrefetchPixels(view.frame, here);
    for (std::size_t at = range.begin; at < range.end && live != 0; at += batch_size) {
      const std::uint32_t live_rows = counted ? LiveRows<Groups>(state.transmittance) : 0;
      // Prepare the splats of the batch: their terms, and the groups that each touches.
      const std::size_t splats = std::min<std::size_t>(batch_size, range.end - at);
      const std::uint32_t* HWY_RESTRICT ids = job.lists.ids.data + at;
      batch.splats = ids;
      for (std::size_t k = 0; k < splats; ++k) {
        const std::uint32_t id = ids[k];
        batch.shapes[k] = job.splats.shapes[id];
        std::memcpy(batch.colours[k], &job.colours.each[id], sizeof batch.colours[k]);
        if (planes.sums) LoadAttributes(job.attributes, id, k, sums);
      }
      const RowFactors factors(batch.shapes, splats, here.first_centre, rules.log2_alpha_min);
      for (std::size_t k = 0; k < splats; ++k) {
        Touched touched = exponent.Prepare(k, batch.shapes[k], here.first_centre, factors);
        if (some_colourless && is_colourless(job.colours.each[ids[k]])) touched = {0, 0};
        batch.group_masks[k] = touched.groups & live;
        if (counted) counts.rows_visited += std::uint64_t(std::popcount(touched.rows & live_rows));
      }
      for (std::size_t k = splats; k % lanes != 0; ++k) batch.group_masks[k] = 0;
      ListGroups(batch, splats);
      for (std::size_t group = 0; group < raster_block_side; ++group) {
        // The next batch's splats come from memory while this one's are blended.
        constexpr std::size_t share = batch_size / raster_block_side;
        const std::size_t next = at + batch_size + group * share;
        PrefetchSplats(job, next, next + share, range.end);
        if (batch.list_sizes[group] == 0) continue;
        for (std::size_t part = 0; part < parts; ++part) {
          if (!Select(batch, state, group, part, evaluated)) continue;
          const std::uint32_t* HWY_RESTRICT list = evaluated.list;
          const typename Groups::Part pixels(group, part);
          const auto evaluate = [&](std::size_t i, Vec(&alpha)[at_once])
                                    HWY_ATTR { exponent.Alphas(list + i, pixels, alpha); };
          if constexpr (kColours && lanes == 16 && std::is_same_v<Groups, Blocks>) {
            // So, rasterizing takes 0.97 of the time; with AVX2, and with the exponents of rows, 1.02
            // to 1.06.
            BlendGroup<Blending::colours>(batch, rules, evaluated, state, counts, evaluate);
          } else {
            for (std::size_t i = 0; i < evaluated.size; i += at_once) {
              Vec alpha[at_once];
              evaluate(i, alpha);
              for (std::size_t j = 0; j < at_once; ++j) hn::Store(alpha[j], F32(), evaluated.alphas[i + j]);
            }
            if constexpr (kColours)
              BlendGroup<Blending::colours>(batch, rules, evaluated, state, counts, evaluated);
            else
              draw_group(job, batch, rules, evaluated, state, planes, counts);
          }
        }
      }
      live = Live(state.transmittance);
      counts.intersections_visited += splats;
    }
    End<Groups>(job, here, state, planes);
    if (job.counts) job.counts[block] = counts;
  }
  hwy::FlushStream();
}

/// Renders what `job` asks for. Colours alone have a loop of their own, which takes 2 % less time. All else
/// shares one, since each takes long to compile.
template <class Exponent>
void RenderRasterBlocksOf(const RasterJob& job, const RasterBlocks& blocks, std::size_t begin,
                          std::size_t end) {
  const bool colours = std::all_of(job.views.begin(), job.views.end(), [&](const View& view) {
    return BlendingOf(job, view) == Blending::colours;
  });
  colours ? RenderRasterBlocks<Exponent, true>(job, blocks, begin, end)
          : RenderRasterBlocks<Exponent, false>(job, blocks, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
