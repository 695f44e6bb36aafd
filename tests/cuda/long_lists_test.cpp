// SPDX-License-Identifier: Apache-2.0

// Lists that no warp traverses alone: many warps blend their segments, with the bits of one warp that blends
// them all.
#include "cuda/long_lists.hpp"

#include <cstddef>
#include <string>
#include <vector>

#include <swiftgs/cpu.hpp>

#include "policies/double_drawing.hpp"
#include "policies/image_parts.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Makes the first Gaussians opaque dots in front of the others, of about two pixels in an image so wide:
/// most pixels of a warp block stop early, and few go on.
void put_dots(Scene& scene, std::size_t dots, int side) {
  Random random(dots);
  const float size = 0.9f / float(side);
  for (std::size_t i = 0; i < dots; ++i) {
    const float x = random.f(-0.5, 0.5), y = random.f(-0.5, 0.5);
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k)  // one leaves a hundredth
      scene.means[k] = vec3(x, y, 1), scene.scales[k] = vec3(size), scene.opacities[k] = 1;
  }
}

/// `of_tile` faint dots for every tile of 16x16 pixels, most of them in its first quarter. Anywhere in the
/// tile lie 5 in 100 of the first 8,600, and `anywhere` in 100 of the rest.
Scene corners(std::size_t of_tile, int side, std::size_t anywhere = 5) {
  Random random(of_tile);
  const std::size_t across = std::size_t(side) / 16;
  Scene scene = random_scene(of_tile * across * across, 0, of_tile);
  const float pixel = 1 / float(side);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const std::size_t tile = i % (across * across);
    const std::size_t nth = i / (across * across);
    const double width = nth % 100 < (nth < 8600 ? 5 : anywhere) ? 14 : 4;
    const float x = float(16 * (tile % across)) + random.f(2, 2 + width);
    const float y = float(16 * (tile / across)) + random.f(2, 2 + width);
    const float z = 1 + float(i) / float(scene.size());
    scene.means[i] = vec3(x * pixel - 0.5f, y * pixel - 0.5f, 1) * z;
    scene.scales[i] = vec3(0.5f * pixel * z), scene.opacities[i] = random.f(0.005, 0.03);
  }
  return scene;
}

/// 600 layers over a whole image, and behind them `of_tile` dots for every tile of 16x16 pixels: 24 opaque
/// ones anywhere in the tile, and after them one of five thousand. The rest are faint and lie in its first
/// quarter, if there is to be a rest. So warp blocks of the other quarters end one segment, begin another, in
/// which pixels stop, and show next to nothing of what follows.
Scene layers_before_corners(std::size_t of_tile, int side, bool with_rest = true) {
  Random random(of_tile);
  const std::size_t layer_count = 600, across = std::size_t(side) / 16, tiles = across * across;
  const Scene any = random_scene(layer_count + of_tile * tiles, 0, of_tile);
  const float pixel = 1 / float(side);
  Scene scene;
  const auto add = [&](std::size_t i, vec3 mean, vec3 scales, float opacity) {
    scene.means.push_back(mean), scene.scales.push_back(scales), scene.opacities.push_back(opacity);
    scene.rotations.push_back(any.rotations[i]), scene.sh0.push_back(any.sh0[i]);
  };
  for (std::size_t i = 0; i < any.size(); ++i) {
    const float z = 1 + float(i) / float(any.size());
    if (i < layer_count) {
      add(i, vec3(0, 0, z), vec3(50), 0.008f);
      continue;
    }
    const std::size_t tile = (i - layer_count) % tiles, nth = (i - layer_count) / tiles;
    const bool anywhere = nth < 24 || nth % 5000 == 0;
    const double width = anywhere ? 14 : 4;
    const float x = float(16 * (tile % across)) + random.f(2, 2 + width);
    const float y = float(16 * (tile / across)) + random.f(2, 2 + width);
    const float opacity = anywhere ? 1 : random.f(0.005, 0.03);
    if (anywhere || with_rest)
      add(i, vec3(x * pixel - 0.5f, y * pixel - 0.5f, 1) * z, vec3(0.5f * pixel * z), opacity);
  }
  return scene;
}

/// The same of frames of `scene`. The first ones may share none if short lists were drawn before.
bool are_shared(auto& renderer, const DeviceScene& scene, const Camera& camera,
                const Conventions& conventions = {}) {
  RenderSettings settings;
  settings.conventions = conventions;
  Frame frame;
  for (int run = 0; run < 4; ++run) renderer.render(scene, camera, settings, frame);
  return was_shared(renderer.backend());
}

/// Compares the bits of a square image with those of its parts, of which each is a square.
void check_squares(auto& renderer, const DeviceScene& scene, int side, int size,
                   const Conventions& conventions = {}) {
  for (const Wanted& wanted : wanted_planes()) {
    CAPTURE(std::string(wanted.name));
    check_parts(renderer, scene.view(), square_view(side, wanted, conventions),
                cut(side, side, every(side, size), every(side, size)), false);
  }
}

/// The same of long lists, with each rasterizer that cuts them into segments.
void check_squares_of_all(const Scene& scene, int side, int size, const Conventions& conventions) {
  const Scene drawn = with_features(scene, 7);
  for_each_segmented([&](auto&& renderer) {
    const DeviceScene uploaded = renderer.backend().upload(drawn);
    CHECK(are_shared(renderer, uploaded, square_camera(side), conventions));
    check_squares(renderer, uploaded, side, size, conventions);
  });
}

}  // namespace

SWIFTGS_DEVICE_CASE("cuda long lists: thread blocks that share warp blocks draw the bits of one warp") {
  // The whole image has more long warp blocks than there is room for, so warps traverse the rest of them
  // alone.
  const int side = 1024;
  Scene scene = layers(492'000, 0.00015, 0.015);
  put_dots(scene, 160'000, side);
  check_squares_of_all(scene, side, 256, faint());
}

SWIFTGS_DEVICE_CASE("cuda long lists: clusters that share warp blocks draw the bits of thread blocks") {
  // The whole image has more warp blocks than clusters have room for. Blocks take the rest.
  const int side = 384;
  Scene scene = layers(228'000, 0.0001, 0.002);
  put_dots(scene, 36'000, side);
  check_squares_of_all(scene, side, 128, faint());
}

SWIFTGS_DEVICE_CASE("cuda long lists: lists that end with a segment have the same bits too") {
  // Black before white, so that a pixel is its transmittance. None stops, and each warp block keeps every
  // splat. A warp block of the second that is pushed to a work queue ends with a round, too.
  const int side = 768;
  for (const std::size_t segments : {64, 68}) {
    Scene scene = layers(512 + segments * 128, 0.004, 0.0045);
    for (std::size_t i = 0; i < scene.size(); ++i) {
      scene.means[i].x = scene.means[i].y = 0;
      scene.scales[i] = vec3(50, 50, 0.01f);
      scene.sh0[i] = vec3(-10);
    }
    Conventions conventions;
    conventions.stop = 0;
    check_squares_of_all(scene, side, 256, conventions);
  }
}

SWIFTGS_DEVICE_CASE("cuda long lists: sorts, conservative bounds and runs change no bit") {
  const Camera camera = square_camera(96);
  RenderSettings settings;
  settings.conventions = faint();
  // Blocks share the lists of the first, clusters those of the second.
  for (const Scene& scene : {layers(30'000, 0.0003, 0.006), layers(60'000, 0.0002, 0.002)}) {
    CAPTURE(scene.size());
    std::vector<float> expected;
    for_each_type(AllSorts(), [&]<class Sort>(Sort) {
      for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
        if constexpr (Bounds::conservative) {
          CAPTURE(Sort::name);
          CAPTURE(Bounds::name);
          Renderer<Cuda, Sort, AxisSharedThreshold<FloatCholesky>, Bounds> renderer;
          const DeviceScene uploaded = renderer.backend().upload(scene);
          CHECK(are_shared(renderer, uploaded, camera, settings.conventions));
          Frame frame;
          for (int run = 0; run < 5; ++run) {
            renderer.render(uploaded, camera, settings, frame);
            if (expected.empty()) expected = frame.colour;
            CHECK((frame.colour == expected));
          }
        }
      });
    });
  }
}

SWIFTGS_DEVICE_CASE("cuda long lists: lists of larger tiles have the same bits") {
  // Small splats: each warp block shows about a thousand. Lists of 16-pixel tiles are short enough for a warp
  // alone. Lists of larger tiles are long, and a warp block refuses most of them. Pixels stop earlier towards
  // the right.
  Cuda cuda;
  Random random(9);
  SplatSet splats;
  for (int i = 0; i < 100'000; ++i) {
    const double x = random.in(0, 128);
    splats.add(make_splat(x, random.in(0, 128), 0.8, 0.7, random.in(0, 3), 0.01 + 0.9 * x / 128),
               float(i + 1), vec3(random.f(0, 1), random.f(0, 1), random.f(0, 1)));
  }
  for_each_type(Segmented(), [&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing usual = draw<Raster, Ellipse>(cuda, splats, 128, 128);
    CHECK_FALSE(was_shared(cuda));
    for (const int side : {64, 128}) {
      CAPTURE(side);
      const Drawing drawn = draw<Raster, Ellipse>(cuda, splats, 128, 128, {}, side);
      CHECK(was_shared(cuda));
      CHECK(same_planes(drawn.frame, usual.frame));
      const Frame again = draw<Raster, Ellipse>(cuda, splats, 128, 128, lean(), side).frame;
      CHECK(same_bits(again.colour, usual.frame.colour));
      CHECK(same_bits(again.alpha, usual.frame.alpha));
    }
  });
}

SWIFTGS_DEVICE_CASE("cuda long lists: frames are those of hosts") {
  const Camera camera = square_camera(64);
  struct Drawn {
    const char* name;
    Scene scene;
    Conventions conventions;
    bool in_segments;
  };
  // Parts show most of the lists of layers, and little of the lists of corners. Each scene names who blends
  // it.
  const Drawn all[] = {{"warps", layers(2500, 0.004, 0.05), {}, false},
                       {"blocks", layers(30'000, 0.0003, 0.006), faint(), true},
                       {"clusters", layers(60'000, 0.0002, 0.002), faint(), true},
                       {"little, for blocks", corners(12'000, 64, 50), {}, true},
                       {"little, for clusters", corners(48'000, 64, 50), {}, true},
                       {"much, then little", layers_before_corners(50'000, 64), {}, true}};
  for (const auto& [name, scene, conventions, in_segments] : all) {
    CAPTURE(name);
    Usual<Cpu> host;
    RenderSettings settings = settings_of({true, true});
    settings.conventions = conventions;
    Frame expected, drawn;
    host.render(host.backend().upload(scene), camera, settings, expected);
    for_each_segmented([&](auto&& renderer) {
      const DeviceScene uploaded = renderer.backend().upload(scene);
      renderer.render(uploaded, camera, settings, drawn);
      // A splat at alpha 1/255 that only one of both keeps, of a thousand that each pixel shows.
      CHECK(difference(drawn.colour, expected.colour, 0).largest < 0.005);
      CHECK(difference(drawn.alpha, expected.alpha, 0).largest < 0.001);
      CHECK(difference(drawn.depth, expected.depth, 0).largest < 0.05);
      CHECK(was_shared(renderer.backend()) == in_segments);
    });
  }
}

SWIFTGS_DEVICE_CASE(
    "cuda long lists: warp blocks that show little behind their first segment are shared too") {
  // More warp blocks than would be taken up at the end of their first segment.
  const int side = 96;
  const Camera camera = square_camera(side);
  const Scene scene = with_features(layers_before_corners(50'000, side), 7);
  const Scene short_lists = layers_before_corners(50'000, side, false);
  const RenderSettings settings = settings_of({true, true});
  for_each_segmented([&](auto&& renderer) {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    check_squares(renderer, uploaded, side, 32);

    CHECK(are_shared(renderer, uploaded, camera));

    // The other quarters look as they do without the dots of the first, when warps traverse all lists alone.
    Frame drawn, expected;
    renderer.render(uploaded, camera, settings, drawn);
    const DeviceScene uploaded_short = renderer.backend().upload(short_lists);
    CHECK_FALSE(are_shared(renderer, uploaded_short, camera));
    renderer.render(uploaded_short, camera, settings, expected);
    std::size_t differing = 0;
    for (std::size_t i = 0; i < drawn.alpha.size(); ++i) {
      const std::size_t x = i % std::size_t(side), y = i / std::size_t(side);
      if (x % 16 < 8 && y % 16 < 8) continue;
      differing += drawn.alpha[i] != expected.alpha[i] || drawn.depth[i] != expected.depth[i];
      for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) differing += drawn.colour[c] != expected.colour[c];
    }
    CHECK(differing == 0);
  });
}
