// SPDX-License-Identifier: Apache-2.0

// What changes no bit of the planes beside colour, alpha and depth, on every backend, and what is refused.
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>

#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Views that ask for different planes: none, some, all.
std::vector<AskedView> different_planes() {
  std::vector<AskedView> views = different_views();
  views[0].further = {.squared_depth = true, .features = 2};
  views[1].further = {.first_depth = true, .id = true};
  views[2].further = all_planes(5);
  views[4].further = all_planes(5);
  views[4].upward = 0b10101010001;
  AskedView features{turned_camera(90, 33, 0.1, 0.2)};
  features.colour = features.alpha = false, features.further.features = 5;
  views.push_back(features);
  AskedView normals{turned_camera(33, 90, -0.1, 0.2)};
  normals.further.normal = normals.further.median_id = normals.further.median_depth = true;
  views.push_back(normals);
  return views;
}

/// Whether all planes that a frame has are those of another one.
bool same_of(const Frame& few, const Frame& whole) {
  bool same = true;
  for_each_plane([&](std::size_t, const auto& plane,
                     const auto& expected) { same = same && (plane.empty() || same_bits(plane, expected)); },
                 few, whole);
  return same;
}

}  // namespace

SWIFTGS_CONTRACT("planes: further ones change no bit of others and no count, at centres and along the ray") {
  const Scene scene = with_features(random_scene(400, 1, 3), 4);
  const Camera camera = forward_camera(70, 45);
  const Outputs some[] = {{.depth = true},       {.squared_depth = true},
                          {.first_depth = true}, {.median_depth = true},
                          {.normal = true},      {.id = true},
                          {.median_id = true},   {.features = 4},
                          all_planes(4),         {.squared_depth = true, .median_depth = true}};
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view) {
    const auto on = renderer.backend().upload(scene);
    for (const Conventions& conventions : {Conventions(), along_ray()}) {
      RenderSettings settings = settings_of({true, true}, vec3(0.2f, 0.3f, 0.4f));
      settings.conventions = conventions, settings.count = true;
      const Frame plain = renderer.render(on, camera, settings);
      const RasterCounts counts = renderer.statistics().raster;
      settings.outputs = all_planes(4);
      const Frame all = renderer.render(on, camera, settings);
      CHECK(same_counts(renderer.statistics().raster, counts));
      CHECK(same_of(plain, all));
      for (std::size_t i = 0; i < std::size(some); ++i)
        for (const bool count : {false, true}) {
          CAPTURE(i);
          settings.outputs = some[i], settings.count = count;
          CHECK(same_of(renderer.render(on, camera, settings), all));
        }
    }
  });
}

SWIFTGS_CONTRACT("planes: views of a frame may ask for different ones") {
  with_each_raster<B>([&](const BoundRaster<B>& raster) {
    BoundRenderer<B> together = renderer_with<B>(raster), alone = renderer_with<B>(raster);
    const auto scene = together.backend().upload(with_features(random_scene(400, 2, 1), 5));
    const std::vector<AskedView> all = different_planes();
    check_views(together, alone, scene.view(), all);
    check_views(together, alone, scene.view(), {all[5], all[0], all[4]});
    check_views(together, alone, scene.view(), {all[2], all[2]});
    check_views(together, alone, scene.view(), {all[3]});  // none of them behind frames with all
  });
}

SWIFTGS_CONTRACT("planes: coarse tiles change no bit") {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(with_features(make_builtin_scene(2'000), 2));
  if constexpr (!on_host<B>) {
    // Few splats in many pixels: a device draws the second frame with coarser tiles.
    const Camera large = builtin_camera(2048, 1024);
    const Frame first = renderer.render(scene, large, settings_of_all(2));
    CHECK(same_planes(renderer.render(scene, large, settings_of_all(2)), first));
    CHECK(renderer.tiles().side > default_tile_side);
  }

  // Tiles of a view's own choice.
  const Camera small = forward_camera(100, 75);
  const auto draw = [&](int side) {
    PlanesOn<B> planes(renderer.backend(), 100, 75, all_planes(2), 7);
    View view = make_view(small, {}, planes.view());
    view.grid = TileGrid::covering(100, 75, side);
    renderer.render_into(scene.view(), {&view, 1});
    return planes.on_host(renderer.backend());
  };
  const Frame usual = draw(16);
  for (const int side : {32, 64, 512}) CHECK(same_planes(draw(side), usual));
}

SWIFTGS_CONTRACT("planes: rows of each may go up in memory") {
  const int width = 37, height = 21;
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(with_features(random_scene(300, 1, 12), 4));
  check_directions(
      width, height,
      [&](PlanesMemory& memory, bool over) {
        PlacedFrame<B> placed(renderer.backend(), memory);
        FrameView frame = placed.frame();
        frame.over = over;
        renderer.render_into(scene.view(), forward_camera(width, height), {}, frame);
        placed.finish(renderer.backend());
      },
      all_planes(4));
}

TEST_CASE("planes: frames have the same bits with one thread and two") {
  const Scene scene = with_features(random_scene(5000, 2, 5), 5);
  with_each_raster<Cpu>([&](const BoundRaster<Cpu>& raster) {
    const auto drawn_by = [&](int threads) {
      BoundRenderer<Cpu> renderer = renderer_with<Cpu>(raster, Cpu(threads));
      const auto uploaded = renderer.backend().upload(scene);
      return draw_together(renderer, uploaded.view(), different_planes());
    };
    CHECK(differing(drawn_by(1), drawn_by(2)) == 0);
  });
}

TEST_CASE("planes: those that cannot be written are refused in words") {
  Usual<Serial> renderer;
  Scene scene = with_features(random_scene(10, 0, 11), 3);
  std::vector<float> memory(3 * 40 * 30 + 1);
  const auto accepts = [&](FrameView frame) {
    frame.width = 40, frame.height = 30;
    renderer.render_into(view(scene), forward_camera(40, 30), {}, frame);
  };
  const auto check = [&](const std::string& name, std::ptrdiff_t least, auto plane, int channels = 0) {
    CAPTURE(name);
    const auto frame = [&](std::ptrdiff_t pitch, std::size_t off = 0) {
      FrameView out{.feature_channels = channels};
      auto& to = out.*plane;
      unsigned char* const bytes = reinterpret_cast<unsigned char*>(memory.data()) + off;
      to = {reinterpret_cast<decltype(to.data)>(bytes), pitch};
      return out;
    };
    CHECK_NOTHROW(accepts(frame(least)));
    for (const std::ptrdiff_t pitch : {least - 4, least + 2, -least + 4}) {
      const std::string message = "the pitch of " + name + " is " + std::to_string(pitch) +
                                  " bytes, expected at least " + std::to_string(least);
      CHECK_THROWS_WITH_AS(accepts(frame(pitch)), doctest::Contains(message.c_str()), std::invalid_argument);
    }
    CHECK_THROWS_WITH_AS(accepts(frame(least, 2)),
                         ("render: expected " + name + " aligned to 4 bytes").c_str(), std::invalid_argument);
  };
  check("squared_depth", 160, &FrameView::squared_depth);
  check("first_depth", 160, &FrameView::first_depth);
  check("median_depth", 160, &FrameView::median_depth);
  check("normal", 480, &FrameView::normal);
  check("id", 160, &FrameView::id);
  check("median_id", 160, &FrameView::median_id);
  check("features", 320, &FrameView::features, 2);
  for (const int channels : {0, -1})
    CHECK_THROWS_WITH_AS(accepts({.features = {memory.data(), 160}, .feature_channels = channels}),
                         "render: expected a frame with features to say how many channels",
                         std::invalid_argument);
  SceneView raw = view(scene);
  --raw.features.size;
  CHECK_THROWS_WITH_AS(validate(raw),
                       doctest::Contains("features of the scene: 9 values, 12 bytes apart; expected 10"),
                       std::invalid_argument);
  scene.features.pop_back();
  CHECK_THROWS_WITH_AS(validate(scene), "scene: features has 29 elements, expected 30",
                       std::invalid_argument);
  scene.feature_channels = -1;
  CHECK_THROWS_WITH_AS(validate(scene), "scene: feature_channels is -1, expected 0 to 16777216",
                       std::invalid_argument);
  Conventions conventions;
  for (const float first_alpha : {-0.1f, 1.0f}) {
    conventions.first_alpha = first_alpha;
    CHECK_THROWS_WITH_AS(validate(conventions), doctest::Contains("expected a first alpha of 0 or more"),
                         std::invalid_argument);
  }
}
