// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All rasterizers, and frames of splats that no projection made.

#include <cmath>
#include <cstddef>
#include <vector>

#include "policies/backends.hpp"
#include "policies/tile_lists.hpp"

namespace swiftgs::test {

/// Calls `f` with one object of each rasterizer.
template <class F>
void for_each_raster(const F& f) {
  for_each_type(AllRasters(), f);
}

/// Whether `Raster` keeps its terms in half precision, which costs accuracy.
template <class Raster>
inline const bool stores_half = Raster::name.find("half") != std::string_view::npos;

struct DrawSettings {
  BlendRules rules = BlendRules::from(Conventions::gsplat());
  vec3 background{0};
  Outputs outputs{true, true};
};

/// A frame with what rasterizing it took.
struct Drawing {
  Frame frame;
  RasterCounts counts;

  float alpha(int x, int y) const {
    return frame.alpha[std::size_t(y) * std::size_t(frame.width) + std::size_t(x)];
  }
  float depth(int x, int y) const {
    return frame.depth[std::size_t(y) * std::size_t(frame.width) + std::size_t(x)];
  }
  float colour(int x, int y, int channel) const {
    return frame
        .colour[3 * (std::size_t(y) * std::size_t(frame.width) + std::size_t(x)) + std::size_t(channel)];
  }
};

/// Faint splats all over an image: no pixel stops, and every raster block takes long.
inline SplatSet faint_splats(std::size_t count, int width, int height) {
  Random random(count);
  SplatSet splats;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = random.in(0, width), y = random.in(0, height);
    splats.add(make_splat(x, y, 20, 10, random.in(0, 3), 0.006), float(1 + i));
  }
  return splats;
}

/// A view that draws into `frame`.
inline View view_into(const FrameView& frame, const DrawSettings& settings = {},
                      int tile_side = default_tile_side) {
  return {.rules = settings.rules,
          .background = settings.background,
          .grid = TileGrid::covering(frame.width, frame.height, tile_side),
          .frame = frame};
}

/// Draws `splats` with lists that every sort builds alike, of tiles of so many pixels a side.
template <class Raster, class B>
Drawing draw(B& backend, const SplatSet& splats, int width, int height, const DrawSettings& settings = {},
             int tile_side = default_tile_side) {
  const SortInput job = splats.job(width, height, tile_side);
  const TileLists<B> lists = build_lists<StandardSort, OpacityBox>(backend, job);
  Drawing drawing;
  const View view = view_into(prepare(drawing.frame, width, height, settings.outputs), settings, tile_side);
  std::vector<RasterCounts> counts(RasterBlocks(tiles_of_frame(view)).size());
  rasterize(backend, Raster{},
            RasterJob{splats.view(), splats.colours_view(), lists.view(), {&view, 1}, counts.data()});
  for (const RasterCounts& tile : counts) drawing.counts += tile;
  return drawing;
}

}  // namespace swiftgs::test
