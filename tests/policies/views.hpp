// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames of several views against frames of one view.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/renderer.hpp>

#include "policies/all_planes.hpp"
#include "policies/directions.hpp"
#include "policies/random_splats.hpp"
#include "policies/tile_lists.hpp"

namespace swiftgs::test {

/// A view and what is asked of it.
struct AskedView {
  Camera camera;
  Conventions conventions = Conventions::gsplat();
  vec3 background{0};
  PixelFormat format = PixelFormat::rgb_float;
  bool colour = true, alpha = true, depth = true, occluder = false, over = false;
  Conversion conversion = Conversion::as_is;
  unsigned upward = 0;                               ///< a bit for each plane whose rows go up in memory
  FirstPixel first{};                                ///< of the part of the image that is shown
  int width = camera.width, height = camera.height;  ///< of this part
  std::size_t beside = 24;                           ///< bytes behind each row, as of `PlanesMemory`
  Outputs further{};                                 ///< planes besides, as of `PlanesMemory`

  PlanesMemory memory() const {
    PlanesMemory memory(width, height, format, beside, further);
    for (std::size_t plane = 0; plane < PlanesMemory::planes; ++plane)
      if (upward >> plane & 1) memory.turn(plane);
    return memory;
  }
  /// `planes` without those that are not asked for.
  FrameView frame(FrameView planes) const {
    if (!colour) planes.colour = {};
    if (!alpha) planes.alpha = {};
    if (!depth) planes.depth = {};
    if (!occluder) planes.occluder = {};
    planes.over = over, planes.conversion = conversion;
    return planes;
  }
  View view(const FrameView& planes) const {
    return make_view(camera, conventions, frame(planes), background, first);
  }
  RenderSettings settings() const {
    RenderSettings settings;
    settings.conventions = conventions, settings.background = background;
    return settings;
  }
};

/// A copy of a frame's memory where backend `B` draws.
template <class B>
class PlacedFrame {
 public:
  PlacedFrame(const B& backend, PlanesMemory& memory) : memory_(&memory) {
    for (std::size_t plane = 0; plane < PlanesMemory::planes; ++plane)
      planes_[plane] = to_backend(backend, memory.bytes[plane]);
  }

  FrameView frame() {
    std::array<unsigned char*, PlanesMemory::planes> memory;
    for (std::size_t plane = 0; plane < PlanesMemory::planes; ++plane) memory[plane] = planes_[plane].data();
    return memory_->frame(memory);
  }
  /// Brings what was drawn back to the host.
  void finish(const B& backend) {
    for (std::size_t plane = 0; plane < PlanesMemory::planes; ++plane)
      memory_->bytes[plane] = to_host(backend, std::as_const(planes_[plane]).span());
  }

 private:
  PlanesMemory* memory_;
  std::array<typename B::template Buffer<unsigned char>, PlanesMemory::planes> planes_;
};

/// Views into memory of their own, where backend `B` draws.
template <class B>
class PlacedViews {
 public:
  PlacedViews(const B& backend, const std::vector<AskedView>& asked) {
    for (const AskedView& view : asked) memories_.push_back(view.memory());
    places_.reserve(asked.size());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      places_.emplace_back(backend, memories_[i]);
      views.push_back(asked[i].view(places_[i].frame()));
    }
  }
  PlacedViews(const PlacedViews&) = delete;
  PlacedViews& operator=(const PlacedViews&) = delete;

  Span<const View> span() const { return span_of(views); }

  /// The memory of each view after all work of `backend`.
  const std::vector<PlanesMemory>& finish(const B& backend) {
    for (PlacedFrame<B>& place : places_) place.finish(backend);
    return memories_;
  }

  std::vector<View> views;

 private:
  std::vector<PlanesMemory> memories_;
  std::vector<PlacedFrame<B>> places_;
};

/// The report of a recorded frame, in memory of a backend.
template <class B>
struct Report {
  typename B::template Buffer<FrameReport> memory;

  Report() { memory.reset(1); }
  FrameReport* data() { return memory.data(); }
  FrameReport get(const B& backend) const { return to_host(backend, memory.span())[0]; }
};

/// What one frame of the views draws.
template <class B>
std::vector<PlanesMemory> draw_together(BoundRenderer<B>& renderer, const SceneView& scene,
                                        const std::vector<AskedView>& asked, const Measures& measures = {}) {
  PlacedViews placed(renderer.backend(), asked);
  renderer.render_into(scene, placed.span(), measures);
  return placed.finish(renderer.backend());
}

/// How many of the views differ in a byte, or have bytes beside their rows that were written.
inline std::size_t differing(const std::vector<PlanesMemory>& drawn,
                             const std::vector<PlanesMemory>& expected) {
  REQUIRE(drawn.size() == expected.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < drawn.size(); ++i)
    count += drawn[i].bytes != expected[i].bytes || !drawn[i].kept_to_its_rows();
  return count;
}

/// A camera beside the one of `forward_camera`, turned about the vertical by `angle`.
inline Camera turned_camera(int width, int height, double angle, double aside = 0) {
  Camera camera = forward_camera(width, height);
  const double c = std::cos(angle), s = std::sin(angle);
  camera.rotation[0] = dvec3(c, 0, s), camera.rotation[1] = dvec3(0, 1, 0),
  camera.rotation[2] = dvec3(-s, 0, c);
  camera.translation = dvec3(aside, -0.3 * aside, 0);
  return camera;
}

/// Cameras on several sides of `random_scene`.
inline std::vector<Camera> cameras_around() {
  return {turned_camera(120, 80, 0.1, 0.2), forward_camera(120, 80), turned_camera(120, 80, -0.2, 0.1)};
}

/// Checks that each of `cameras_around` sees the same bits in both.
template <class B>
void check_same(BoundRenderer<B>& renderer, const PlacedScenes& found, const PlacedScenes& expected,
                const RenderSettings& settings = {}) {
  for (const Camera& camera : cameras_around())
    CHECK(same_planes(renderer.render(found, camera, settings), renderer.render(expected, camera, settings)));
}

/// Looks away from every Gaussian of `random_scene` that lies ahead.
inline AskedView empty_view(int width, int height) {
  AskedView view{turned_camera(width, height, 3.14159265)};
  view.camera.translation = dvec3(0, 0, -20);
  view.background = vec3(0.4f, 0.1f, 0.7f);
  return view;
}

/// Five views that have nothing in common. The third shows nothing, the fourth is the second again.
inline std::vector<AskedView> different_views() {
  AskedView plain{forward_camera(37, 21)};
  plain.background = vec3(0.3f, 1.7f, -0.4f);
  AskedView over{turned_camera(64, 48, 0.2, 0.4), Conventions::inria(), vec3(9), PixelFormat::rgba_8};
  over.over = true, over.depth = false, over.conversion = Conversion::linear_to_srgb;
  AskedView empty = empty_view(16, 16);
  empty.format = PixelFormat::rgba_half, empty.alpha = false;
  AskedView hidden{turned_camera(100, 75, -0.3, -0.5)};
  hidden.conventions.antialiased = true, hidden.conventions.alpha_min = 1.0f / 100;
  hidden.background = vec3(0.5f, 0.2f, 0), hidden.format = PixelFormat::rgba_float, hidden.occluder = true;
  hidden.conversion = Conversion::srgb_to_linear;
  return {plain, over, empty, over, hidden};
}

/// The whole images of cameras, of which nothing is asked.
inline std::vector<View> views_without_planes(const std::vector<AskedView>& asked) {
  std::vector<View> views;
  for (const AskedView& view : asked)
    views.push_back(
        make_view(view.camera, view.conventions, {.width = view.camera.width, .height = view.camera.height}));
  return views;
}

/// A view of each format over an image and over a background, behind a surface and without one. Of each
/// plane some have rows that go up; alpha and depth are asked of most.
inline std::vector<AskedView> views_of_every_kind() {
  std::vector<AskedView> views;
  for (const PixelFormat format : pixel_formats)
    for (const bool over : {false, true})
      for (const bool occluder : {false, true})
        for (const unsigned upward : {0b0101u, 0b1010u}) {
          const int i = int(views.size());
          AskedView view{turned_camera(20 + i, 40 - i, 0.01 * i, 0.02 * i),
                         i % 3 == 0 ? Conventions::inria() : Conventions::gsplat(),
                         vec3(0.3f, 1.7f, -0.4f + 0.1f * float(i)), format};
          view.over = over, view.occluder = occluder, view.upward = upward;
          view.alpha = i % 5 != 0, view.depth = i % 7 != 0, view.conversion = Conversion(i % 3);
          views.push_back(view);
        }
  return views;
}

inline bool same_counts(const RasterCounts& a, const RasterCounts& b) {
  return a.intersections_visited == b.intersections_visited && a.rows_visited == b.rows_visited &&
         a.contributing_pairs == b.contributing_pairs && a.pixels_stopped == b.pixels_stopped;
}

/// Draws a view in a frame of its own, by the call that takes a camera.
template <class B>
PlanesMemory draw_one(BoundRenderer<B>& renderer, const SceneView& scene, const AskedView& asked,
                      bool count) {
  PlanesMemory memory = asked.memory();
  PlacedFrame<B> place(renderer.backend(), memory);
  RenderSettings settings = asked.settings();
  settings.count = count;
  renderer.render_into(scene, asked.camera, settings, asked.frame(place.frame()));
  place.finish(renderer.backend());
  return memory;
}

/// What frames of one view each draw, and what they took together.
struct DrawnAlone {
  std::vector<PlanesMemory> memories;
  Statistics sum;
  bool coarse = false;  ///< whether a counted frame had coarser tiles than its view
};

template <class B>
DrawnAlone draw_alone(BoundRenderer<B>& renderer, const SceneView& scene,
                      const std::vector<AskedView>& asked) {
  DrawnAlone out;
  out.sum.gaussians = scene.size();
  for (const AskedView& view : asked) {
    out.memories.push_back(draw_one(renderer, scene, view, false));
    draw_one(renderer, scene, view, true);
    const Statistics statistics = renderer.statistics();
    out.sum.visible += statistics.visible, out.sum.intersections += statistics.intersections;
    out.sum.raster += statistics.raster;
    out.coarse = out.coarse || renderer.tiles().side != default_tile_side;
  }
  return out;
}

/// Checks that one frame of all views draws what frames of one view draw, byte by byte, and takes as much if
/// all had tiles of the same side. `alone` draws the latter, so that `together` may go from frame to frame of
/// many views.
template <class B>
void check_views(BoundRenderer<B>& together, BoundRenderer<B>& alone, const SceneView& scene,
                 const std::vector<AskedView>& asked) {
  const DrawnAlone expected = draw_alone(alone, scene, asked);
  for (const bool count : {false, true}) {
    CAPTURE(count);
    CHECK(differing(draw_together(together, scene, asked, {.count = count}), expected.memories) == 0);
    const Statistics statistics = together.statistics();
    CHECK(statistics.gaussians == expected.sum.gaussians);
    CHECK(statistics.visible == expected.sum.visible);
    const RasterCounts raster = count ? expected.sum.raster : RasterCounts();
    CHECK(statistics.raster.contributing_pairs == raster.contributing_pairs);
    CHECK(statistics.raster.pixels_stopped == raster.pixels_stopped);
    if (expected.coarse || together.tiles().side != default_tile_side) continue;
    CHECK(statistics.intersections == expected.sum.intersections);
    CHECK(same_counts(statistics.raster, raster));
  }
}

/// `check_views` with one, two and five views, the same ones in other orders, views that show nothing and the
/// same view twice. One renderer draws all these frames.
template <class B>
void check_lists_of_views(BoundRenderer<B>& together, BoundRenderer<B>& alone, const SceneView& scene) {
  const std::vector<AskedView> all = different_views();
  AskedView unseen = all[4];
  unseen.colour = unseen.alpha = unseen.depth = false;
  const std::pair<const char*, std::vector<AskedView>> lists[] = {
      {"one", {all[1]}},
      {"two", {all[0], all[4]}},
      {"five", all},
      {"five in another order", {all[4], all[3], all[0], all[1], all[2]}},
      {"the same twice", {all[4], all[4]}},
      {"one that shows nothing among others", {all[2], all[0], all[2], all[1], all[2]}},
      {"none that shows anything", {empty_view(40, 30), empty_view(5, 70)}},
      {"one of which nothing is asked", {all[0], unseen, all[1]}},
      {"one after many", {all[0]}}};
  for (const auto& list : lists) {
    CAPTURE(std::string(list.first));
    const std::vector<AskedView>& asked = list.second;
    check_views(together, alone, scene, asked);
    const bool shows_nothing = asked[0].camera.width == 40;
    CHECK((together.statistics().raster.contributing_pairs < 1000) == shows_nothing);
  }
}

/// The Gaussians of each tile's list, nearest first.
template <class B>
Lists gaussians_of_lists(BoundRenderer<B>& renderer) {
  const auto gaussians = to_host(renderer.backend(), renderer.splats().view().gaussians);
  Lists out = to_vectors(host_lists(renderer.backend(), renderer.lists()).view());
  for (std::vector<std::uint32_t>& list : out)
    for (std::uint32_t& id : list) id = gaussians.at(id);
  return out;
}

/// Checks that each tile of views of any size, one of them a part of an image, lists the Gaussians that it
/// lists in a frame of its view alone, and that other numbers list none.
template <class B>
void check_lists(BoundRenderer<B>& together, BoundRenderer<B>& alone, const SceneView& scene) {
  std::vector<AskedView> asked = different_views();
  asked.push_back({forward_camera(300, 200)});
  std::vector<View> views = views_without_planes(asked);
  views.push_back(make_view(asked[5].camera, asked[5].conventions, {.width = 268, .height = 150}, vec3(0),
                            {.x = 32, .y = 16}));
  together.render_into(scene, span_of(std::as_const(views)));
  const Lists lists = gaussians_of_lists(together);
  std::vector<View> numbered = views;
  number_tiles(span_of(numbered));
  REQUIRE(lists.size() == Views(numbered.data(), numbered.size()).tiles.size());
  std::size_t intersections = 0, listed = 0, different = 0;
  for (const std::vector<std::uint32_t>& list : lists) listed += list.size();
  for (std::size_t v = 0; v < views.size(); ++v) {
    alone.render_into(scene, Span<const View>{&views[v], 1});
    const Lists expected = gaussians_of_lists(alone);
    const TileGrid& grid = numbered[v].grid;
    REQUIRE(expected.size() == grid.size());
    std::size_t tile = 0;
    for (int row = grid.rows.begin; row < grid.rows.end; ++row)
      for (int column = grid.columns.begin; column < grid.columns.end; ++column, ++tile) {
        different += lists[grid.number(column, row)] != expected[tile];
        intersections += expected[tile].size();
      }
  }
  CHECK(different == 0);
  CHECK(listed == intersections);
  CHECK(intersections > 5000);
}

/// Checks that a frame of three times as many views is drawn whole: their rows of raster blocks may be more
/// than a device's grid has room for.
template <class B, class SceneOn>
void check_many_rows(BoundRenderer<B>& renderer, const SceneOn& scene, std::size_t triples = 11'000) {
  const Camera kinds[] = {forward_camera(1, 1), forward_camera(17, 2), turned_camera(3, 1, 0.1)};
  RenderSettings settings = settings_of({true, true}, vec3(0.1f, 0.2f, 0.3f));
  settings.count = true;
  std::vector<Frame> expected;
  std::vector<std::uint64_t> pairs;
  for (const Camera& camera : kinds) {
    expected.push_back(renderer.render(scene, camera, settings));
    pairs.push_back(renderer.statistics().raster.contributing_pairs);
  }
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < 3 * triples + 1; ++i) cameras.push_back(kinds[i % 3]);
  std::vector<Frame> frames(cameras.size());
  renderer.render(scene, span_of(cameras), settings, span_of(frames));
  std::size_t different = 0;
  for (std::size_t i = 0; i < frames.size(); ++i)
    different += frames[i].colour != expected[i % 3].colour || frames[i].alpha != expected[i % 3].alpha ||
                 frames[i].depth != expected[i % 3].depth;
  CHECK(different == 0);
  CHECK(renderer.statistics().raster.contributing_pairs ==
        triples * (pairs[0] + pairs[1] + pairs[2]) + pairs[0]);
}

/// A part of an image with all planes. From `k` to `k` everything changes that `set_views` may change.
inline AskedView changing_view(int k) {
  AskedView view{turned_camera(148, 134, 0.03 * k, 0.05 * k)};
  view.width = 100, view.height = 70, view.first = {16 * (k % 4), 16 * (k % 5)};
  if (k % 3 == 1) view.conventions = Conventions::inria();
  if (k % 3 == 2) view.conventions.antialiased = true, view.conventions.alpha_min = 1.0f / 100;
  if (k % 4 == 3) view.conventions.alpha_min = 1e-6f;
  view.background = vec3(0.3f, 1.7f, -0.1f * float(k));
  view.format = pixel_formats[std::size_t(k) % std::size(pixel_formats)];
  view.over = k / 4 % 2, view.upward = unsigned(7 * k) % 16, view.beside = std::size_t(24 + 8 * (k % 3));
  view.occluder = true;
  return view;
}

/// The same with colour alone, of another size, and converted.
inline AskedView changing_lean_view(int k) {
  AskedView view = changing_view(k + 6);
  view.conversion = k % 2 ? Conversion::srgb_to_linear : Conversion::linear_to_srgb;
  view.width = 77, view.height = 61;
  view.alpha = view.depth = view.occluder = false;
  return view;
}

/// Checks that frames which are recorded of changing views, in new memory each, are those that `other`
/// renders. `capture(report)` returns what draws the recorded frame.
template <class B, class Capture>
void check_changing_views(BoundRenderer<B>& renderer, BoundRenderer<B>& other, const SceneView& scene,
                          const Capture& capture) {
  const auto& backend = renderer.backend();
  Report<B> report;
  using Asked = std::vector<AskedView> (*)(int k);
  for (const Asked asked : {Asked([](int k) { return std::vector{changing_view(k)}; }),
                            Asked([](int k) { return std::vector{changing_lean_view(k)}; }), Asked([](int k) {
                              return std::vector{changing_lean_view(k), changing_view(k)};
                            })}) {
    CAPTURE(asked(0).size());
    const PlacedViews reserved(backend, asked(0));
    renderer.reserve(scene, reserved.span(), {8000, 200'000});
    const auto draw = capture(report.data());
    std::size_t wrong = 0, least = scene.size();
    for (int k = 16; k-- != 0;) {
      PlacedViews drawn(backend, asked(k)), expected(backend, asked(k));
      renderer.set_views(drawn.span());
      draw();
      other.render_into(scene, expected.span());
      wrong += differing(drawn.finish(backend), expected.finish(backend));
      const FrameReport found = report.get(backend);
      const Statistics taken = other.statistics();
      wrong += found.overflowed != 0 || found.visible != taken.visible ||
               found.intersections != taken.intersections;
      least = std::min(least, taken.visible);
    }
    CHECK(wrong == 0);
    CHECK(least > 100);
  }
}

}  // namespace swiftgs::test
