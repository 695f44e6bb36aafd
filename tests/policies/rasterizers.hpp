// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All rasterizers, and frames of splats that no projection made.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
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
  bool count = true;
};

/// Colour and alpha alone, for which backends may have other kernels.
inline DrawSettings lean(DrawSettings settings = {}) {
  settings.outputs.depth = settings.count = false;
  return settings;
}

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

/// The planes of a frame of floats in memory of a backend.
template <class B>
class PlanesOn {
 public:
  /// All values are `fill` at first.
  PlanesOn(const B& backend, int width, int height, const Outputs& outputs, float fill = 0) {
    prepare(frame_, width, height, outputs);
    for (std::vector<float>* plane : {&frame_.colour, &frame_.alpha, &frame_.depth})
      std::fill(plane->begin(), plane->end(), fill);
    colour_ = to_backend(backend, frame_.colour), alpha_ = to_backend(backend, frame_.alpha);
    depth_ = to_backend(backend, frame_.depth);
  }

  FrameView view() {
    const std::ptrdiff_t row = std::ptrdiff_t(sizeof(float)) * frame_.width;
    FrameView view{.width = frame_.width, .height = frame_.height};
    if (!frame_.colour.empty()) view.colour = {colour_.data(), 3 * row};
    if (!frame_.alpha.empty()) view.alpha = {alpha_.data(), row};
    if (!frame_.depth.empty()) view.depth = {depth_.data(), row};
    return view;
  }
  /// What was drawn, after all work of `backend`.
  Frame on_host(const B& backend) {
    frame_.colour = to_host(backend, std::as_const(colour_).span());
    frame_.alpha = to_host(backend, std::as_const(alpha_).span());
    frame_.depth = to_host(backend, std::as_const(depth_).span());
    return frame_;
  }

 private:
  Frame frame_;
  typename B::template Buffer<float> colour_, alpha_, depth_;
};

/// Draws `splats` with lists that every sort builds alike, of tiles of so many pixels a side.
template <class Raster, class Bounds = OpacityBox, class B>
Drawing draw(B& backend, const SplatSet& splats, int width, int height, const DrawSettings& settings = {},
             int tile_side = default_tile_side) {
  const SplatsOn<B> placed(backend, splats);
  const TileLists<B> lists = build_lists<StandardSort, Bounds>(backend, placed.job(width, height, tile_side));
  PlanesOn<B> planes(backend, width, height, settings.outputs);
  const View view = view_into(planes.view(), settings, tile_side);
  auto counts = to_backend(backend, std::vector<RasterCounts>(RasterBlocks(tiles_of_frame(view)).size()));
  rasterize(backend, Raster{},
            RasterJob{placed.view(),
                      placed.colours_view(),
                      lists.view(),
                      {&view, 1},
                      settings.count ? counts.data() : nullptr});
  Drawing drawing{planes.on_host(backend), {}};
  for (const RasterCounts& block : to_host(backend, std::as_const(counts).span())) drawing.counts += block;
  return drawing;
}

}  // namespace swiftgs::test
