// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which splats go to which rank.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/functor/bounds_stages.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/mpi/staging.hpp>
#include <swiftgs/mpi/strips.hpp>

namespace swiftgs {

/// Rows of the tile atlas in which a splat has tiles. Every splat of a tile list must reach the rank that
/// draws the tile, so the answer comes from the footprint that one process would emit intersections from.
template <BoundsPolicy Bounds>
SWIFTGS_HD TileRun atlas_rows(const Bounds& bounds, const SplatShape& shape, const Footprint& footprint,
                              const TileGrid& grid) {
  if (footprint.count == 0) return {};
  if (footprint.mask != 0) {
#if defined(__CUDA_ARCH__)
    const int highest = 63 - __clzll(static_cast<long long>(footprint.mask));
#else
    const int highest = 63 - std::countl_zero(footprint.mask);
#endif
    const int first = int(footprint.first / grid.stride);
    return {first, first + highest / Footprint::side + 1};
  }
  // Without a mask the bounds are evaluated again, and may round otherwise than when tiles were counted: a
  // row more on each side.
  const TileRun rows = bounds.tiles(shape, grid).rect.rows;
  const int top = int(grid.first / grid.stride) - grid.rows.begin;
  const int first = rows.begin > grid.rows.begin ? rows.begin - 1 : grid.rows.begin;
  const int last = rows.end < grid.rows.end ? rows.end + 1 : grid.rows.end;
  return {first + top, last + top};
}

/// Where the splats for all ranks are written, one after the other.
struct ShareArrays {
  SplatShape* shapes;
  float* depths;
  std::uint32_t* gaussians;
  std::uint16_t* of_view;  ///< null if there is one view

  template <class B>
  static ShareArrays of(Splats<B>& splats) {
    return {splats.shapes.data(), splats.depths.data(), splats.gaussians.data(),
            splats.of_view.size() != 0 ? splats.of_view.data() : nullptr};
  }
  SWIFTGS_HD void write(std::size_t at, const SplatsView& from, std::size_t i) const {
    shapes[at] = from.shapes[i], depths[at] = from.depths[i], gaussians[at] = from.gaussians[i];
    if (of_view) of_view[at] = std::uint16_t(from.view(i));
  }
};

/// Splats that one iteration of a loop looks at, in their order.
inline constexpr std::size_t shared_at_once = 256;

/// The splats of a rank, in parts, and the ranks that they go to.
template <class Bounds>
struct SplatsToShare {
  SplatsView splats;
  Span<const Footprint> footprints;
  const View* views;
  Bounds bounds;
  const std::uint32_t* cuts;  ///< @shape{ranks + 1}
  std::uint32_t ranks;

  /// f(rank, i) for the splats of one part, in their order.
  template <class F>
  SWIFTGS_HD void for_each(std::size_t part, const F& f) const {
    const std::size_t begin = part * shared_at_once, left = splats.size() - begin;
    const std::size_t end = begin + (left < shared_at_once ? left : shared_at_once);
    for (std::size_t i = begin; i < end; ++i) {
      const TileRun rows = atlas_rows(bounds, splats.shapes[i], footprints[i], views[splats.view(i)].grid);
      if (rows.size() == 0) continue;
      for (std::uint32_t r = rank_of(std::uint32_t(rows.begin));
           r < ranks && cuts[r] < std::uint32_t(rows.end); ++r)
        f(r, i);
    }
  }

 private:
  /// The rank that draws a row: ranks without rows come last.
  SWIFTGS_HD std::uint32_t rank_of(std::uint32_t row) const {
    std::uint32_t low = 0;
    for (std::uint32_t high = ranks; high - low > 1;) {
      const std::uint32_t middle = (low + high) / 2;
      (cuts[middle] <= row ? low : high) = middle;
    }
    return low;
  }
};

/// Counts for each rank the splats of one part that go to it.
template <class Bounds>
struct SWIFTGS_API CountShares {
  SplatsToShare<Bounds> from;
  std::size_t parts;
  std::uint32_t* counts;  ///< @shape{ranks, parts}

  SWIFTGS_HD void operator()(std::size_t part) const {
    for (std::uint32_t r = 0; r < from.ranks; ++r) counts[r * parts + part] = 0;
    from.for_each(part, [&](std::uint32_t r, std::size_t) { ++counts[r * parts + part]; });
  }
};

/// Writes them, from where the sums of the counts say, which it moves on.
template <class Bounds>
struct SWIFTGS_API WriteShares {
  SplatsToShare<Bounds> from;
  std::size_t parts;
  std::uint32_t* positions;  ///< @shape{ranks, parts}
  ShareArrays to;

  SWIFTGS_HD void operator()(std::size_t part) const {
    from.for_each(part, [&](std::uint32_t r, std::size_t i) {
      to.write(positions[r * parts + part]++, from.splats, i);
    });
  }
};

/// Copies every `step`-th word.
struct SWIFTGS_API PickWords {
  const std::uint32_t* from;
  std::size_t step;
  std::uint32_t* to;
  SWIFTGS_HD void operator()(std::size_t i) const { to[i] = from[i * step]; }
};

/// Throws `CapacityError` if there are more splats than an index can tell apart.
inline void require_indices(const char* what, std::uint64_t count) {
  constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
  if (count > most) throw CapacityError(what, count, most);
}

/// The splats of a rank in the order in which it sends them: by the rank that they go to, then by their
/// Gaussians. A splat in the strips of several ranks is there several times.
template <class B>
struct Shares {
  Splats<B> splats;
  std::vector<std::uint64_t> begins;  ///< first splat for each rank, and the end @shape{ranks + 1}
  FrameReport found;                  ///< of the splats that were shared out
  typename B::template Buffer<std::uint32_t> cuts, positions, picked;

  std::uint64_t count_for(int rank) const {
    return begins[std::size_t(rank) + 1] - begins[std::size_t(rank)];
  }
  /// The next frame asks for no more memory than it needs.
  void forget_capacity() {}
  static auto buffers(auto& self) { return std::tie(self.splats, self.cuts, self.positions, self.picked); }
};

/// Finds the tiles of `splats`, which were projected by `plan`, and shares the splats out among the ranks of
/// `cuts`. `await_shares` tells how many there are. Backends overload both.
template <BackendPolicy B, BoundsPolicy Bounds>
void share_out(B& b, const FramePlan& plan, const Bounds& bounds, const StripCuts& cuts, Splats<B>& splats,
               Footprints<B>& footprints, Shares<B>& shares) {
  const std::size_t ranks = cuts.size() - 1;
  bin(b, plan, bounds, splats, footprints);
  shares.found = await_report(b, splats, footprints, plan.limits);
  shares.begins.assign(ranks + 1, 0), shares.splats.set_count(0);
  const std::size_t count = std::size_t(shares.found.visible);
  if (shares.found.overflowed != 0 || count == 0) return;
  shares.cuts.reset(cuts.size());
  copy_from_host(b, cuts.data(), shares.cuts.data(), cuts.size() * sizeof(std::uint32_t));
  const std::size_t parts = (count + shared_at_once - 1) / shared_at_once;
  shares.positions.reset(ranks * parts), shares.picked.reset(ranks);
  std::uint32_t* const positions = shares.positions.data();
  const SplatsToShare<Bounds> from{splats.view(), footprints.view().each, plan.views.reachable(),
                                   bounds,        shares.cuts.data(),     std::uint32_t(ranks)};
  b.for_each(parts, CountShares<Bounds>{from, parts, positions});
  const std::uint64_t all = b.exclusive_scan(Span{positions, ranks * parts});
  require_indices("splats for all strips", all);
  b.for_each(ranks, PickWords{positions, parts, shares.picked.data()});
  std::vector<std::uint32_t> picked(ranks);
  b.download(Span<const std::uint32_t>{shares.picked.data(), ranks}, picked.data());
  shares.begins.assign(picked.begin(), picked.end());
  shares.begins.push_back(all);
  shares.splats.reset(std::size_t(all), plan.views.size());
  shares.splats.set_count(std::size_t(all));
  b.for_each(parts, WriteShares<Bounds>{from, parts, positions, ShareArrays::of(shares.splats)});
}

/// The report of the splats that `share_out` was given. If it overflowed, nothing was shared out: project and
/// share out again.
template <BackendPolicy B>
FrameReport await_shares(B&, const Shares<B>& shares) {
  return shares.found;
}

}  // namespace swiftgs
