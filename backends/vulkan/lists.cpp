// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <swiftgs/vulkan/stages.hpp>

#include "commands.hpp"
#include "seen.hpp"

namespace swiftgs::vulkan {

void emit(Vulkan& b, const SortJob& job, BoundsKind bounds, const std::uint32_t* order, std::uint32_t* sums,
          Keys keys, std::uint32_t* ids) {
  const SplatsView& splats = job.splats;
  const Count count = splats.count();
  const std::size_t n = count.most, found = job.footprints.intersections.most;
  if (n == 0) return;
  Commands commands(b);
  const std::size_t groups = (n + usual_threads - 1) / usual_threads, most_sums = (groups + 3) / 4 * 4;
  std::uint32_t* const sums_of_runs = sums + most_sums;
  const std::size_t runs = groups / run_size + 1;
  const Access footprints = reads(job.footprints.each.data, n);
  commands.fill(sums_of_runs, runs, 0);
  commands.run(Kernel::tile_sums, {},
               Push(footprints, reads(order, n), writes(sums, most_sums), shares(sums_of_runs, runs), count),
               commands.over(count, Groups::fours));
  commands.run({Kernel::emit, bounds, &BoundsShaders::emit}, {bounds.number, keys.each},
               Push(reads(splats.shapes.data, n), reads(splats.depths.data, n), reads(splats.of_view, n),
                    reads(order, n), address(grids_of(commands, job.footprints.views)), footprints,
                    reads(sums, most_sums), reads(sums_of_runs, runs), writes(keys.words, keys.each * found),
                    writes(ids, found), count),
               commands.over(count));
  commands.finish();
}

void find_ranges(Vulkan& b, const FootprintsView& footprints, Count count, Keys keys, TileRange* ranges) {
  const std::size_t tiles = footprints.views.tiles.size();
  Commands commands(b);
  Vulkan::State& state = b.state();
  const Access launch =
      writes(state.groups.device + Vulkan::State::long_launch, sizeof(VkDispatchIndirectCommand));
  const std::size_t most_long = 1 + count.most / long_list;
  state.long_tiles.reset(most_long), state.long_of = ranges;
  const Access long_tiles = writes(state.long_tiles.data(), most_long);
  commands.run(Kernel::ranges_clear, {},
               Push(writes(ranges, tiles), reads(footprints.overflowed, 1), launch, long_tiles, count,
                    std::uint32_t(tiles), long_list, long_part),
               Commands::Shape::of(std::max<std::size_t>(tiles, 3)));
  const auto blocks = std::uint32_t(footprints.views.tiles.side / raster_side);
  commands.run(Kernel::ranges, {keys.each},
               Push(reads(keys.words, keys.each * count.most), writes(ranges, tiles), launch, long_tiles,
                    count, std::uint32_t(tiles), blocks * blocks),
               commands.over(count, Groups::fours));
  commands.finish();
}

}  // namespace swiftgs::vulkan
