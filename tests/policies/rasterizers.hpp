// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All rasterizers, and frames of splats that no projection made.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <swiftgs/drivers/resident_frames.hpp>

#include "policies/all_planes.hpp"
#include "policies/backends.hpp"
#include "policies/planes.hpp"
#include "policies/tile_lists.hpp"

namespace swiftgs::test {

/// Calls `f` with one object of each rasterizer.
template <class F>
void for_each_raster(const F& f) {
  for_each_type(AllRasters(), f);
}

/// A rasterizer as renderers on backend `B` bind it, and as those on `Serial` do.
template <class B>
struct BoundRaster : RasterStage<B> {
  RasterStage<Serial> on_serial;

  template <class Raster>
  static BoundRaster of() {
    return {raster_stage<B, Raster>(), raster_stage<Serial, Raster>()};
  }
};

/// Rasterizers that differ on a backend. With shaders `PerPixel` is `AxisShared<FloatCholesky>`.
template <class B>
using RastersOf =
    std::conditional_t<has_shaders<B>, decltype(detail::with_axis_shared(TypeList<>(), AllExponents())),
                       AllRasters>;
/// Those for tests of what surrounds them. With shaders they are two constants: two that differ in both.
template <class B>
using SomeRastersOf =
    std::conditional_t<has_shaders<B>, TypeList<AxisShared<FloatSplit>, AxisSharedThreshold<FloatCholesky>>,
                       AllRasters>;

/// Those for tests that draw views of every kind, which have many shaders each.
template <class B>
using FewestRastersOf =
    std::conditional_t<has_shaders<B>, TypeList<AxisSharedThreshold<FloatCholesky>>, AllRasters>;

/// Calls f(raster) with the `BoundRaster` of each rasterizer, or of what `As` makes of it.
template <class B, template <class> class As = std::type_identity_t, class Rasters = RastersOf<B>, class F>
void with_each_raster(const F& f) {
  std::vector<BoundRaster<B>> rasters;
  for_each_type(Rasters(),
                [&]<class Raster>(Raster) { rasters.push_back(BoundRaster<B>::template of<As<Raster>>()); });
  for (const BoundRaster<B>& raster : rasters) {
    CAPTURE(raster.name);
    f(raster);
  }
}

/// A renderer with other policies than the usual ones.
template <class B, class Sort = EarlySort, class Bounds = Ellipse>
BoundRenderer<B> renderer_with(const RasterStage<B>& raster, B backend = test::make_backend<B>()) {
  return {std::string(raster.name),
          std::move(backend),
          {bounds_stages<B, Bounds>(), raster, common_stages<B>()},
          std::make_unique<SortStageOf<B, Sort, Bounds>>()};
}

/// Calls f(renderer, name) with a renderer of each of `SomeRastersOf` and the rasterizer's name.
template <class B, class F>
void with_each_renderer(const F& f) {
  with_each_raster<B, std::type_identity_t, SomeRastersOf<B>>([&](const BoundRaster<B>& raster) {
    BoundRenderer<B> renderer = renderer_with<B>(raster);
    f(renderer, raster.name);
  });
}

/// Whether a rasterizer keeps its terms in half precision, which costs accuracy.
inline bool stores_half(std::string_view raster) { return raster.find("half") != std::string_view::npos; }
/// Whether a rasterizer has the split terms, whose exponents round more.
inline bool is_split(std::string_view raster) { return raster.find("split") != std::string_view::npos; }

/// What the planes of a frame may differ from the reference by. Rounding alone reaches half of it: of
/// devices, of split terms and of depths that slope more than of others.
template <class B>
PlaneBounds plane_bounds(const Conventions& conventions = {}, std::string_view raster = {}) {
  const double slack = (on_host<B> ? 1 : 4) * (is_split(raster) ? 2 : 1);
  if (conventions.depth_at == Conventions::DepthAt::centre)
    return {.sum = 1.5e-5 * slack, .mean = 3e-5 * slack, .threshold = 1e-4, .pick = 1e-5};
  return {.sum = 1.5e-5 * slack,
          .mean = 6e-5 * slack,
          .threshold = 1e-4,
          .pick = 1e-5,
          .picked = 1e-5,
          .least = 1,
          .occluder = 1e-5};
}

struct DrawSettings {
  BlendRules rules = blend_rules(Conventions::gsplat());
  vec3 background{0};
  Outputs outputs{true, true};
  bool count = true;
  std::vector<float> occluder{};  ///< @shape{height, width} or empty
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

  std::size_t at(int x, int y) const { return std::size_t(y) * std::size_t(frame.width) + std::size_t(x); }
  float alpha(int x, int y) const { return frame.alpha[at(x, y)]; }
  float depth(int x, int y) const { return frame.depth[at(x, y)]; }
  float colour(int x, int y, int channel) const { return frame.colour[3 * at(x, y) + std::size_t(channel)]; }
};

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
    for_each_plane(
        [&](std::size_t, auto& values, auto& plane) {
          std::fill(values.begin(), values.end(), std::remove_reference_t<decltype(values[0])>(fill));
          plane = to_backend(backend, values);
        },
        frame_, planes_);
  }

  FrameView view() {
    FrameView view{
        .width = frame_.width, .height = frame_.height, .feature_channels = frame_.feature_channels};
    planes_.point(view, 0);
    return view;
  }
  /// What was drawn, after all work of `backend`.
  Frame on_host(const B& backend) {
    for_each_plane(
        [&](std::size_t, auto& values, const auto& plane) { values = to_host(backend, plane.span()); },
        frame_, std::as_const(planes_));
    return frame_;
  }

 private:
  Frame frame_;
  FramePlanes<B> planes_;
};

/// Draws the planes of `settings` into memory that held 7 everywhere, behind `occluder` unless it is empty.
template <class B>
Frame draw_over_sevens(BoundRenderer<B>& renderer, const PlacedScenes& scenes, const Camera& camera,
                       const RenderSettings& settings, const std::vector<float>& occluder = {}) {
  const B& backend = renderer.backend();
  PlanesOn<B> planes(backend, camera.width, camera.height, settings.outputs, 7);
  const auto depths = to_backend(backend, occluder);
  FrameView frame = planes.view();
  if (!occluder.empty()) frame.occluder = {depths.data(), std::ptrdiff_t(sizeof(float)) * camera.width};
  renderer.render_into(scenes, camera, settings, frame);
  return planes.on_host(backend);
}

/// Splats of a backend with lists that every sort builds alike, of tiles of so many pixels a side, and what
/// draws them.
template <class B, class Bounds = OpacityBox>
struct Picture {
  Picture(B& backend_, const SplatSet& set, int width_, int height_, const DrawSettings& settings_ = {},
          int tile_side_ = default_tile_side)
      : backend(backend_),
        splats(backend, set),
        lists(build_lists<StandardSort, Bounds>(backend, splats.job(width_, height_, tile_side_))),
        width(width_),
        height(height_),
        tile_side(tile_side_),
        settings(settings_),
        occluder(to_backend(backend, settings.occluder)),
        counts(settings.count && on_host<B> ? RasterBlocks(tiles_of_frame(view({}))).size() : 0) {}

  View view(FrameView frame) const {
    frame.width = width, frame.height = height;
    if (occluder.size() != 0) frame.occluder = {occluder.data(), std::ptrdiff_t(sizeof(float)) * width};
    return view_into(frame, settings, tile_side);
  }
  void draw(const RasterStage<B>& raster, const FrameView& frame) {
    const View one = view(frame);
    const RasterJob job{splats.view(), splats.colours_view(), lists.view(), {&one, 1}, counts.data()};
    raster.rasterize(backend, job);
    counted = settings.count ? raster.count(backend, job).raster : RasterCounts();
  }

  B& backend;
  SplatsOn<B> splats;
  TileLists<B> lists;
  int width, height, tile_side;
  DrawSettings settings;
  typename B::template Buffer<float> occluder;
  std::vector<RasterCounts> counts;  ///< of hosts
  RasterCounts counted;              ///< of the last frame
};

/// Draws `splats` once.
template <class Bounds = OpacityBox, class B>
Drawing draw(B& backend, const RasterStage<B>& raster, const SplatSet& splats, int width, int height,
             const DrawSettings& settings = {}, int tile_side = default_tile_side) {
  Picture<B, Bounds> picture(backend, splats, width, height, settings, tile_side);
  PlanesOn<B> planes(backend, width, height, settings.outputs);
  picture.draw(raster, planes.view());
  return {planes.on_host(backend), picture.counted};
}
template <class Raster, class Bounds = OpacityBox, class B>
Drawing draw(B& backend, const SplatSet& splats, int width, int height, const DrawSettings& settings = {},
             int tile_side = default_tile_side) {
  return draw<Bounds>(backend, raster_stage<B, Raster>(), splats, width, height, settings, tile_side);
}

}  // namespace swiftgs::test
