// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <swiftgs/mpi/ranks.hpp>

namespace swiftgs {

/// Counters of one rank for one frame.
struct RankCounters {
  std::uint64_t gaussians = 0;      ///< of its part of the scene
  std::uint64_t visible = 0;        ///< splats that it projected
  std::uint64_t sent = 0;           ///< splats that it sent to other ranks, one to two ranks twice
  std::uint64_t drawn = 0;          ///< splats of its strip, its own and others'
  std::uint64_t intersections = 0;  ///< pairs of splat and tile in its strip
  std::uint64_t first_row = 0;      ///< of its strip, in rows of tiles of the tile atlas
  std::uint64_t rows = 0;           ///< of its strip
  Traffic traffic{};                ///< without the collection of images
  std::uint64_t project_ns = 0;     ///< until it knew what to send; alone, of projection @units{nanoseconds}
  std::uint64_t strip_ns = 0;       ///< binning, sorting and rasterizing its strip @units{nanoseconds}
  std::uint64_t frame_ns = 0;       ///< in all, without the collection @units{nanoseconds}
  std::uint64_t bytes = 0;          ///< memory of its stages, the scene excluded
  std::uint64_t failed = 0;         ///< not 0: it could not draw its strip
};

/// Counters of all ranks for one frame, in the order of ranks.
struct FrameCounters {
  std::vector<RankCounters> ranks;

  /// The longest time that a rank took for its strip, over the mean: 1 is best.
  double imbalance() const {
    std::uint64_t sum = 0, most = 0;
    for (const RankCounters& rank : ranks) sum += rank.strip_ns, most = std::max(most, rank.strip_ns);
    return sum == 0 ? 1 : double(most) * double(ranks.size()) / double(sum);
  }
  std::uint64_t sent_bytes() const {
    return sum([](const RankCounters& rank) { return rank.traffic.sent_bytes; });
  }
  std::uint64_t messages() const {
    return sum([](const RankCounters& rank) { return rank.traffic.messages; });
  }
  std::uint64_t visible() const {
    return sum([](const RankCounters& rank) { return rank.visible; });
  }
  std::uint64_t intersections() const {
    return sum([](const RankCounters& rank) { return rank.intersections; });
  }

 private:
  template <class F>
  std::uint64_t sum(const F& of) const {
    std::uint64_t total = 0;
    for (const RankCounters& rank : ranks) total += of(rank);
    return total;
  }
};

}  // namespace swiftgs
