// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How many tile intersections the occluders of a frame hide.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>

#include <swiftgs/backend.hpp>
#include <swiftgs/raster/raster.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

/// A tile in its view's frame.
struct PlacedTile {
  const View& view;
  int x0, y0;         ///< its first pixel
  int columns, rows;  ///< of pixels within the frame; 0 or less where the tile lies outside of it

  SWIFTGS_HD PlacedTile(const View& of, std::uint32_t tile)
      : view(of),
        x0(int((tile - of.grid.first) % of.grid.stride) * of.grid.side),
        y0(int((tile - of.grid.first) / of.grid.stride) * of.grid.side),
        columns(of.frame.width - x0 < of.grid.side ? of.frame.width - x0 : of.grid.side),
        rows(of.frame.height - y0 < of.grid.side ? of.frame.height - y0 : of.grid.side) {}

  /// Depth from which on the occluder hides splats at the i-th pixel, counted by rows; infinite for none.
  SWIFTGS_HD float hidden_from(int i) const {
    const float depth = view.frame.occluder_at(std::size_t(x0 + i % columns), std::size_t(y0 + i / columns));
    return depth >= -INFINITY ? depth : INFINITY;
  }
};

/// How many splats of a list, which runs front to back, lie at `depth` or behind.
SWIFTGS_HD inline std::uint32_t count_from(const RasterJob& job, const TileRange& list, float depth) {
  if (!list.drawn()) return 0;
  std::uint32_t first = list.begin;
  for (std::uint32_t end = list.end; first < end;) {
    const std::uint32_t middle = first + (end - first) / 2;
    if (job.splats.depths[job.lists.ids[middle]] >= depth)
      end = middle;
    else
      first = middle + 1;
  }
  return list.end - first;
}

/// Counts the hidden intersections of a tile, on a host.
struct CountHidden {
  const RasterJob& job;
  std::uint32_t* to;

  void operator()(std::size_t tile) const {
    const auto number = std::uint32_t(tile);
    const Views& views = job.views;
    const PlacedTile place(views[view_of_tile(views.each.data, std::uint32_t(views.size()), number)], number);
    to[tile] = 0;
    if (!place.view.frame.occluder.data || place.columns <= 0) return;
    float farthest = -INFINITY;
    for (int i = 0; i < place.columns * place.rows; ++i)
      if (const float depth = place.hidden_from(i); farthest < depth) farthest = depth;
    to[tile] = count_from(job, job.lists.ranges[tile], farthest);
  }
};

/// Sets each of `to` @shape{tiles} to the splats of the tile's list at or behind the occluder in all pixels
/// of the tile, on hosts. A device overloads this.
template <BackendPolicy B>
requires(bool(B::reaches_host_memory)) void count_hidden(B& b, const RasterJob& job, std::uint32_t* to) {
  b.for_each(job.views.tiles.size(), CountHidden{job, to});
}

/// Counts what the occluders of frames hide.
template <class B>
class HiddenStage {
 public:
  void count(B& b, const RasterJob& job) {
    bool occluded = false;
    for (const View& view : job.views) occluded = occluded || view.frame.occluder.data;
    tiles_.reset(occluded ? job.views.tiles.size() : 0);
    if (occluded) count_hidden(b, job, tiles_.data());
  }

  /// The intersections that the last counted frame hid. Waits.
  std::size_t total(const B& b) const {
    std::vector<std::uint32_t> tiles(tiles_.size());
    if (!tiles.empty()) b.download(tiles_.span(), tiles.data());
    std::size_t sum = 0;
    for (const std::uint32_t tile : tiles) sum += tile;
    return sum;
  }

  static auto buffers(auto& self) { return std::tie(self.tiles_); }

 private:
  typename B::template Buffer<std::uint32_t> tiles_;  ///< @shape{tiles} none without an occluder
};

}  // namespace swiftgs
