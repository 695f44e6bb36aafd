// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Instances of splats from their footprints, for bounds that `find_footprints` knows.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include <swiftgs/cpu.hpp>

#include "footprints.hpp"
#include "parts.hpp"

namespace swiftgs {

/// Walks the instances of splats in a given order, by their footprints.
template <class Bounds>
class Instances {
 public:
  Instances(Cpu& cpu, const SortJob<Bounds>& job, const Bounds& bounds, const std::uint32_t* order,
            InstanceScratch<Cpu>& scratch)
      : job_(job), bounds_(bounds), order_(order) {
    check_footprints(job);
    if (job.grid.rows > most_rows)
      throw std::invalid_argument("sort: the grid has " + std::to_string(job.grid.rows) +
                                  " rows of tiles, expected at most " + std::to_string(most_rows));
    constexpr std::size_t grain = 1024;
    const std::size_t splats = job.splats.size();
    scratch.footprints.reset(splats);
    Footprint* footprints = scratch.footprints.data();
    footprints_ = footprints;
    cpu.for_parts(splats, grain, [&](std::size_t begin, std::size_t end) {
      find_footprints(bounds, job.splats.shapes.data + begin, end - begin, job.grid, footprints + begin);
      for (std::size_t id = begin; id < end; ++id)
        if (footprints[id].count == to_be_counted) footprints[id].count = count_large(id);
    });
  }

  std::uint64_t count(Part part) const {
    std::uint64_t sum = 0;
    for (std::size_t i = part.begin; i < part.end; ++i) sum += footprints_[id_at(i)].count;
    return sum;
  }

  /// f(tile, id) for each instance of the splats in `part`, in order: for each splat as often as it was
  /// counted, and never twice for one tile.
  template <class F>
  void visit(Part part, const F& f) const {
    const std::uint32_t columns = std::uint32_t(job_.grid.columns);
    for (std::size_t i = part.begin; i < part.end; ++i) {
      if (order_ && i + prefetch_distance < part.end)
        __builtin_prefetch(&footprints_[order_[i + prefetch_distance]]);
      const std::uint32_t id = id_at(i);
      const Footprint& footprint = footprints_[id];
      if (footprint.mask == 0) {
        if (footprint.count != 0) visit_large(id, footprint.count, f);
        continue;
      }
      const std::uint32_t first = std::uint32_t(footprint.row) * columns + footprint.column;
      for (std::uint64_t mask = footprint.mask; mask != 0; mask &= mask - 1) {
        const std::uint32_t bit = std::uint32_t(std::countr_zero(mask));
        f(first + (bit >> 3) * columns + (bit & 7), id);
      }
    }
  }

 private:
  /// How far ahead of its use a footprint is asked for.
  static constexpr std::size_t prefetch_distance = 16;

  /// Rows of tiles of a splat that has no mask, and its run in each. Not cleared: most are not used.
  static constexpr int most_rows = max_image_side / tile_side;
  struct Rows {
    int begin = 0, end = 0;
    int run_begins[most_rows], run_ends[most_rows];

    TileRun run(int row) const {
      return row >= begin && row < end ? TileRun{run_begins[row], run_ends[row]} : TileRun{};
    }
  };

  std::uint32_t id_at(std::size_t i) const { return order_ ? order_[i] : std::uint32_t(i); }

  /// One piece of machine code for counting and for visiting, so that both round alike.
  [[gnu::noinline]] void find_rows(std::size_t id, Rows& rows) const {
    const SplatShape& shape = job_.splats.shapes[id];
    const TileRect rect = bounds_.rect(shape, job_.grid);
    rows.begin = rect.rows.begin, rows.end = rect.rows.end;
    for (int row = rows.begin; row < rows.end; ++row) {
      const TileRun run = bounds_.row(shape, rect, row);
      rows.run_begins[row] = run.begin, rows.run_ends[row] = run.end;
    }
  }
  std::uint32_t count_large(std::size_t id) const {
    Rows rows;
    find_rows(id, rows);
    std::uint32_t count = 0;
    for (int row = rows.begin; row < rows.end; ++row) count += std::uint32_t(rows.run(row).size());
    return count;
  }

  /// Should the bounds find more tiles than were counted, the last are left out; should they find fewer,
  /// other tiles of the grid take their place, where rasterizers find that the splat shows nothing.
  template <class F>
  void visit_large(std::uint32_t id, std::uint32_t left, const F& f) const {
    Rows rows;
    find_rows(id, rows);
    const auto visit_run = [&](int row, int begin, int end) {
      const std::uint32_t first = std::uint32_t(row) * std::uint32_t(job_.grid.columns);
      for (int column = begin; column < end && left > 0; ++column, --left)
        f(first + std::uint32_t(column), id);
    };
    for (int row = rows.begin; row < rows.end; ++row) {
      const TileRun run = rows.run(row);
      visit_run(row, run.begin, run.end);
    }
    for (int row = 0; left > 0 && row < job_.grid.rows; ++row) {
      const TileRun run = rows.run(row);
      if (run.size() == 0) {
        visit_run(row, 0, job_.grid.columns);
      } else {
        visit_run(row, 0, run.begin);
        visit_run(row, run.end, job_.grid.columns);
      }
    }
  }

  const SortJob<Bounds>& job_;
  const Bounds& bounds_;
  const std::uint32_t* order_;
  const Footprint* footprints_;
};

/// Numbers of instances before each part, and of all.
struct PartOffsets {
  std::array<std::uint64_t, max_parts> before;
  std::uint64_t total = 0;
};

/// Throws `CapacityError` before memory for the instances is taken.
template <class Bounds>
PartOffsets part_offsets(const Cpu& cpu, const Instances<Bounds>& instances, std::size_t splats,
                         std::size_t parts) {
  PartOffsets offsets;
  for_each_part(cpu, splats, parts,
                [&](std::size_t part, Part range) { offsets.before[part] = instances.count(range); });
  for (std::size_t part = 0; part < parts; ++part)
    offsets.total += std::exchange(offsets.before[part], offsets.total);
  check_instances(offsets.total);
  return offsets;
}

/// `emit_instances` of bounds that `find_footprints` knows.
template <class Bounds>
std::size_t emit_footprints(Cpu& cpu, const SortJob<Bounds>& job, const Bounds& bounds,
                            const std::uint32_t* order, InstanceScratch<Cpu>& scratch,
                            Pairs<Cpu, std::uint64_t>& out) {
  const Instances<Bounds> instances(cpu, job, bounds, order, scratch);
  const std::size_t splats = job.splats.size(), parts = part_count(cpu, splats, 4096);
  const PartOffsets offsets = part_offsets(cpu, instances, splats, parts);
  out.reset(std::size_t(offsets.total));
  for_each_part(cpu, splats, parts, [&](std::size_t part, Part range) {
    std::uint64_t* keys = out.keys.data() + offsets.before[part];
    std::uint32_t* ids = out.values.data() + offsets.before[part];
    instances.visit(range, [&](std::uint32_t tile, std::uint32_t id) {
      *keys++ = std::uint64_t(tile) << depth_key_bits | depth_key(job.splats.colours[id].depth);
      *ids++ = id;
    });
  });
  return std::size_t(offsets.total);
}

/// `group_by_tile` of bounds that `find_footprints` knows.
template <class Bounds>
void group_footprints(Cpu& cpu, const SortJob<Bounds>& job, const Bounds& bounds, const std::uint32_t* order,
                      GroupScratch<Cpu>& scratch, TileLists<Cpu>& lists) {
  const Instances<Bounds> instances(cpu, job, bounds, order, scratch.emission);
  const std::size_t splats = job.splats.size(), tiles = job.grid.size();
  // A table of positions a part must not outgrow the splats that it is for.
  const std::size_t parts = std::min(part_count(cpu, splats, 4096), 1 + 16 * splats / tiles);
  lists.instances = std::size_t(part_offsets(cpu, instances, splats, parts).total);
  lists.tiles = tiles;
  lists.ids.reset(lists.instances), lists.ranges.reset(tiles);

  // Count the instances of each tile in each part, turn the counts into first positions, and write every id
  // to its own.
  scratch.positions.reset(parts * tiles);
  const auto positions_of = [&](std::size_t part) { return scratch.positions.data() + part * tiles; };
  for_each_part(cpu, splats, parts, [&](std::size_t part, Part range) {
    std::uint32_t* counts = positions_of(part);
    std::fill_n(counts, tiles, 0u);
    instances.visit(range, [&](std::uint32_t tile, std::uint32_t) { ++counts[tile]; });
  });
  std::uint32_t sum = 0;
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    const std::uint32_t begin = sum;
    for (std::size_t part = 0; part < parts; ++part) sum += std::exchange(positions_of(part)[tile], sum);
    lists.ranges.data()[tile] = sum > begin ? TileRange{begin, sum} : TileRange{};
  }
  for_each_part(cpu, splats, parts, [&](std::size_t part, Part range) {
    std::uint32_t* positions = positions_of(part);
    std::uint32_t* ids = lists.ids.data();
    instances.visit(range, [&](std::uint32_t tile, std::uint32_t id) { ids[positions[tile]++] = id; });
  });
}

}  // namespace swiftgs
