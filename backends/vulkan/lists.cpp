// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>

#include <swiftgs/vulkan/stages.hpp>

#include "commands.hpp"
#include "seen.hpp"

namespace swiftgs::vulkan {

void emit(Vulkan& b, const SortJob& job, BoundsKind bounds, const std::uint32_t* order,
          std::uint32_t* offsets, void* keys, std::uint32_t key_words, std::uint32_t* ids) {
  const SplatsView& splats = job.splats;
  const Count n = splats.count();
  if (n.most == 0) return;
  Commands commands(b);
  commands.reserve_scan(n.most);
  const Footprint* const footprints = job.footprints.each.data;
  const TileGrid* const grids = grids_of(commands, job.footprints.views);
  const std::size_t found = job.footprints.intersections.most;
  const Access number = reads(n.exact, n.exact ? 4 : 0);
  commands.run(Kernel::tile_counts, {}, Push(footprints, order, offsets, n), Commands::Shape::of(n.most),
               {reads(footprints, n.most * sizeof(Footprint)), reads(order, order ? 4 * n.most : 0), number,
                writes(offsets, 4 * n.most)});
  commands.scan(offsets, n);
  commands.run(
      Kernel::emit, {bounds.number, key_words},
      Push(splats.shapes.data, splats.depths.data, splats.of_view, order, grids, footprints, offsets, keys,
           ids, n),
      Commands::Shape::of(n.most),
      {reads(offsets, 4 * n.most), number, writes(keys, 4 * key_words * found), writes(ids, 4 * found)});
  commands.submit();
}

void find_ranges(Vulkan& b, const FootprintsView& footprints, Count count, const void* keys,
                 std::uint32_t key_words, TileRange* ranges) {
  const std::size_t tiles = footprints.views.tiles.size(), bytes = tiles * sizeof(TileRange);
  Commands commands(b);
  commands.run(Kernel::ranges_clear, {}, Push(ranges, footprints.overflowed, std::uint32_t(tiles)),
               Commands::Shape::of(tiles), {writes(ranges, bytes)});
  commands.run(Kernel::ranges, {key_words}, Push(keys, ranges, count, std::uint32_t(tiles)),
               Commands::Shape::of(count.most), {writes(ranges, bytes)});
  commands.submit();
}

}  // namespace swiftgs::vulkan
