// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <swiftgs/cpu.hpp>

#include "footprints.hpp"
#include "parts.hpp"

namespace swiftgs {
namespace {

/// How far ahead of its use a footprint is asked for.
constexpr std::size_t prefetch_distance = 16;

/// Walks the instances of splats in a given order, by their footprints.
template <class Bounds>
class Instances {
 public:
  Instances(Cpu& cpu, const SortJob<Bounds>& job, const Bounds& bounds, const std::uint32_t* order,
            InstanceScratch<Cpu>& scratch)
      : job_(job), bounds_(bounds), order_(order) {
    check_footprints(job);
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

  /// f(tile, id) for each instance of the splats in `part`, in order.
  template <class F>
  void visit(Part part, const F& f) const {
    const std::uint32_t columns = std::uint32_t(job_.grid.columns);
    for (std::size_t i = part.begin; i < part.end; ++i) {
      if (order_ && i + prefetch_distance < part.end)
        __builtin_prefetch(&footprints_[order_[i + prefetch_distance]]);
      const std::uint32_t id = id_at(i);
      const Footprint& footprint = footprints_[id];
      if (footprint.mask == 0) {
        if (footprint.count != 0) visit_large(id, f);
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
  std::uint32_t id_at(std::size_t i) const { return order_ ? order_[i] : std::uint32_t(i); }

  /// f(row, run) for each row of tiles of a splat that has no mask. Counting and visiting go through here, so
  /// that they cannot disagree.
  template <class F>
  void for_runs(std::size_t id, const F& f) const {
    const SplatShape& shape = job_.splats.shapes[id];
    const TileRect rect = bounds_.rect(shape, job_.grid);
    for (int row = rect.rows.begin; row < rect.rows.end; ++row) f(row, bounds_.row(shape, rect, row));
  }
  std::uint32_t count_large(std::size_t id) const {
    std::uint32_t count = 0;
    for_runs(id, [&](int, TileRun run) { count += std::uint32_t(run.size()); });
    return count;
  }
  template <class F>
  void visit_large(std::uint32_t id, const F& f) const {
    for_runs(id, [&](int row, TileRun run) {
      const std::uint32_t first = std::uint32_t(row) * std::uint32_t(job_.grid.columns);
      for (int column = run.begin; column < run.end; ++column) f(first + std::uint32_t(column), id);
    });
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

}  // namespace

template <VectorBounds Bounds>
std::size_t emit_instances(Cpu& cpu, const SortJob<Bounds>& job, const Bounds& bounds,
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

template <VectorBounds Bounds>
void group_by_tile(Cpu& cpu, const SortJob<Bounds>& job, const Bounds& bounds, const std::uint32_t* order,
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

template std::size_t emit_instances(Cpu&, const SortJob<ThreeSigmaSquare>&, const ThreeSigmaSquare&,
                                    const std::uint32_t*, InstanceScratch<Cpu>&, Pairs<Cpu, std::uint64_t>&);
template void group_by_tile(Cpu&, const SortJob<ThreeSigmaSquare>&, const ThreeSigmaSquare&,
                            const std::uint32_t*, GroupScratch<Cpu>&, TileLists<Cpu>&);
template std::size_t emit_instances(Cpu&, const SortJob<OpacityBox>&, const OpacityBox&, const std::uint32_t*,
                                    InstanceScratch<Cpu>&, Pairs<Cpu, std::uint64_t>&);
template void group_by_tile(Cpu&, const SortJob<OpacityBox>&, const OpacityBox&, const std::uint32_t*,
                            GroupScratch<Cpu>&, TileLists<Cpu>&);
template std::size_t emit_instances(Cpu&, const SortJob<Ellipse>&, const Ellipse&, const std::uint32_t*,
                                    InstanceScratch<Cpu>&, Pairs<Cpu, std::uint64_t>&);
template void group_by_tile(Cpu&, const SortJob<Ellipse>&, const Ellipse&, const std::uint32_t*,
                            GroupScratch<Cpu>&, TileLists<Cpu>&);

}  // namespace swiftgs
