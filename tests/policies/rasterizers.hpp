// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The seven rasterizers, and frames of splats that no projection made.

#include <cmath>
#include <cstddef>
#include <vector>

#include "policies/backends.hpp"
#include "policies/tile_lists.hpp"

namespace swiftgs::test {

/// Calls `f` with one object of each rasterizer.
template <class F>
void for_each_raster(const F& f) {
  f(PerPixel());
  f(AxisShared<HalfSplit>()), f(AxisShared<FloatSplit>()), f(AxisShared<FloatCholesky>());
  f(AxisSharedThreshold<HalfSplit>()), f(AxisSharedThreshold<FloatSplit>());
  f(AxisSharedThreshold<FloatCholesky>());
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
  TileCounts counts;

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

/// Draws `splats` with lists that every sort builds alike.
template <class Raster, class B>
Drawing draw(B& backend, const SplatSet& splats, int width, int height, const DrawSettings& settings = {}) {
  const SortInput job = splats.job(width, height);
  const TileLists<B> lists = build_lists<StandardSort, OpacityBox>(backend, job);
  std::vector<TileCounts> counts(job.grid.size());
  Drawing drawing;
  const FrameView view = prepare(drawing.frame, width, height, settings.outputs);
  rasterize(backend, Raster{},
            RasterJob{splats.view(), splats.colours_view(), lists.view(), job.grid, settings.rules,
                      settings.background, view, counts.data()});
  for (const TileCounts& tile : counts) drawing.counts += tile;
  return drawing;
}

}  // namespace swiftgs::test
