// SPDX-License-Identifier: Apache-2.0

// Lists that no warp traverses alone: many warps blend their segments, with the bits of one warp that blends
// them all.
#include <cstddef>
#include <utility>
#include <vector>

#include <swiftgs/cpu.hpp>
#include <swiftgs/type_list.hpp>

#include "cuda/device.hpp"
#include "cuda/drawings.hpp"
#include "cuda/graph.hpp"
#include "policies/random_splats.hpp"
#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Faint Gaussians, one behind the other, that reach over much of an image: pixels stop at very different
/// places of very long lists.
Scene layers(std::size_t count, double faintest, double densest) {
  Random random(count);
  Scene scene = random_scene(count, 0, count);
  for (std::size_t i = 0; i < count; ++i) {
    const float z = 2 + 8 * float(i) / float(count), side = 0.5f * z;
    const float x = random.f(-side, side), y = random.f(-side, side);
    scene.means[i] = vec3(x, y, z);
    const float wide = random.f(0.1 * z, 0.8 * z), narrow = random.f(0.1 * z, 0.8 * z);
    scene.scales[i] = vec3(wide, narrow, 0.01f);
    scene.opacities[i] = float(random.scale(faintest, densest));
  }
  return scene;
}

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

/// Keeps Gaussians that are much fainter than those that frames usually show, so that lists of ten thousands
/// are needed to stop a pixel.
Conventions faint() {
  Conventions conventions;
  conventions.alpha_min = 1e-5f;
  return conventions;
}

Camera square_camera(int side) {
  Camera camera = forward_camera(side, side, side);
  camera.cx = camera.cy = 0.5 * side;
  return camera;
}

/// Colour, alpha and depth of an image in device memory, rows of the image `side` wide.
struct Planes {
  DeviceBuffer<float> colour, alpha, depth;
  int side;

  explicit Planes(int of) : side(of) {
    const std::size_t pixels = std::size_t(of) * std::size_t(of);
    colour.reset(3 * pixels), alpha.reset(pixels), depth.reset(pixels);
  }
  /// Overwrites all pixels, when the device has nothing to do and before it has.
  void poison() {
    for (DeviceBuffer<float>* plane : {&colour, &alpha, &depth})
      check_cuda(cudaMemset(plane->data(), 0xa5, plane->size() * sizeof(float)), "cudaMemset");
    check_cuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
  }
  /// A part of the image, from a pixel on.
  FrameView part(int size, FirstPixel first, bool extras) {
    const std::size_t at = std::size_t(first.y) * std::size_t(side) + std::size_t(first.x);
    const auto row = std::ptrdiff_t(sizeof(float)) * side;
    FrameView frame{.width = size, .height = size, .colour = {colour.data() + 3 * at, 3 * row}};
    frame.alpha = {alpha.data() + at, row};
    if (extras) frame.depth = {depth.data() + at, row};
    return frame;
  }
};

/// Whether two images have the same bits; their depth where there are `extras`.
bool same_planes(const Cuda& cuda, const Planes& a, const Planes& b, bool extras) {
  const auto same = [&](const DeviceBuffer<float>& one, const DeviceBuffer<float>& other) {
    return same_bits(to_host(cuda, one.span()), to_host(cuda, other.span()));
  };
  return same(a.colour, b.colour) && same(a.alpha, b.alpha) && (!extras || same(a.depth, b.depth));
}

/// Renders an image as a whole and in parts before white, and compares their bits.
template <class R>
void check_parts(R& renderer, const SceneView& scene, int side, int size, bool extras,
                 const Conventions& conventions = {}) {
  CAPTURE(R::name);
  CAPTURE(side);
  CAPTURE(extras);
  const Camera camera = square_camera(side);
  Planes whole(side), parts(side);
  const View view = make_view(camera, conventions, whole.part(side, {}, extras), vec3(1));
  renderer.render_into(scene, {&view, 1});
  for (int y = 0; y < side; y += size)
    for (int x = 0; x < side; x += size) {
      const View part = make_view(camera, conventions, parts.part(size, {x, y}, extras), vec3(1), {x, y});
      renderer.render_into(scene, {&part, 1});
    }
  CHECK(same_planes(renderer.backend(), whole, parts, extras));
}

template <class Raster>
using With = Renderer<Cuda, EarlySort, Raster, Ellipse>;

/// Rasterizers that cut lists into segments.
using Segmented = TypeList<AxisSharedThreshold<FloatCholesky>, AxisShared<FloatCholesky>,
                           AxisSharedThreshold<FloatSplit>, AxisShared<FloatSplit>>;

/// Calls f(renderer) for each of them.
template <class F>
void for_each_segmented(const F& f) {
  for_each_type(Segmented(), [&]<class Raster>(Raster) { f(With<Raster>()); });
}

RasterCounts counts_of(auto& renderer, const DeviceScene& scene, const Camera& camera,
                       const Conventions& conventions = {}) {
  RenderSettings settings;
  settings.conventions = conventions, settings.count = true;
  Frame frame;
  renderer.render(scene, camera, settings, frame);
  return renderer.statistics().raster;
}

}  // namespace

TEST_CASE(
    "cuda long lists: warp blocks that thread blocks share have the bits of warp blocks that a warp "
    "traverses") {
  if (without_device()) return;
  // The whole image has more long warp blocks than there is room for, so warps traverse the rest of them
  // alone.
  const int side = 1024;
  Scene scene = layers(492'000, 0.00015, 0.015);
  put_dots(scene, 160'000, side);
  for_each_segmented([&](auto&& renderer) {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    CHECK(counts_of(renderer, uploaded, square_camera(side), faint()).segments > 10'000);
    for (const bool extras : {false, true})
      check_parts(renderer, uploaded.view(), side, 256, extras, faint());
  });
}

TEST_CASE(
    "cuda long lists: warp blocks that clusters share have the bits of warp blocks that thread blocks "
    "share") {
  if (without_device()) return;
  // The whole image has more warp blocks than clusters have room for. Blocks take the rest.
  const int side = 384;
  Scene scene = layers(228'000, 0.0001, 0.002);
  put_dots(scene, 36'000, side);
  for_each_segmented([&](auto&& renderer) {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    CHECK(counts_of(renderer, uploaded, square_camera(side), faint()).segments > 10'000);
    for (const bool extras : {false, true})
      check_parts(renderer, uploaded.view(), side, 128, extras, faint());
  });
}

TEST_CASE("cuda long lists: lists that end with a segment have the same bits too") {
  if (without_device()) return;
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
    for_each_segmented([&](auto&& renderer) {
      const DeviceScene uploaded = renderer.backend().upload(scene);
      CHECK(counts_of(renderer, uploaded, square_camera(side), conventions).segments > 10'000);
      for (const bool extras : {false, true})
        check_parts(renderer, uploaded.view(), side, 256, extras, conventions);
    });
  }
}

TEST_CASE("cuda long lists: every sort and all conservative bounds give the same bits, run after run") {
  if (without_device()) return;
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
          CHECK(counts_of(renderer, uploaded, camera, settings.conventions).segments > 100);
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

TEST_CASE("cuda long lists: lists of larger tiles have the same bits") {
  if (without_device()) return;
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
  Picture picture(std::move(splats), 128, 128);
  for_each_type(Segmented(), [&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    picture.tile_side = 16;
    picture.use_bounds(Ellipse());
    const Drawing usual = draw_on_device<Raster>(cuda, picture);
    CHECK(usual.counts.segments == 0);
    for (const int side : {64, 128}) {
      CAPTURE(side);
      picture.tile_side = side;
      picture.use_bounds(Ellipse());
      const Drawing drawn = draw_on_device<Raster>(cuda, picture);
      CHECK(drawn.counts.segments > 100);
      CHECK(same_bits(drawn.frame.colour, usual.frame.colour));
      CHECK(same_bits(drawn.frame.alpha, usual.frame.alpha));
      CHECK(same_bits(drawn.frame.depth, usual.frame.depth));
      CHECK(drawn.counts.contributing_pairs == usual.counts.contributing_pairs);
      CHECK(drawn.counts.pixels_stopped == usual.counts.pixels_stopped);
      const Drawing lean = draw_on_device<Raster>(cuda, picture, true);
      CHECK(same_bits(lean.frame.colour, usual.frame.colour));
      CHECK(same_bits(lean.frame.alpha, usual.frame.alpha));
    }
  });
}

TEST_CASE("cuda long lists: frames are those of hosts, and their counts") {
  if (without_device()) return;
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
    Renderer<Cpu, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> host;
    RenderSettings settings;
    settings.conventions = conventions;
    settings.count = true, settings.outputs = {true, true};
    Frame expected, drawn;
    host.render(host.backend().upload(scene), camera, settings, expected);
    const RasterCounts counted = host.statistics().raster;
    for_each_segmented([&](auto&& renderer) {
      CAPTURE(std::decay_t<decltype(renderer)>::name);
      const DeviceScene uploaded = renderer.backend().upload(scene);
      renderer.render(uploaded, camera, settings, drawn);
      double colour = 0, alpha = 0, depth = 0;
      for (std::size_t i = 0; i < drawn.colour.size(); ++i)
        colour = std::max(colour, std::abs(double(drawn.colour[i]) - double(expected.colour[i])));
      for (std::size_t i = 0; i < drawn.alpha.size(); ++i) {
        alpha = std::max(alpha, std::abs(double(drawn.alpha[i]) - double(expected.alpha[i])));
        depth = std::max(depth, std::abs(double(drawn.depth[i]) - double(expected.depth[i])));
      }
      // A splat at alpha 1/255 that only one of both keeps, of a thousand that each pixel shows.
      CHECK(colour < 0.005);
      CHECK(alpha < 0.001);
      CHECK(depth < 0.05);
      const RasterCounts counts = renderer.statistics().raster;
      CHECK((counts.segments > 0) == in_segments);
      CHECK(double(counts.contributing_pairs) ==
            doctest::Approx(double(counted.contributing_pairs)).epsilon(2e-3));
      CHECK(double(counts.pixels_stopped) == doctest::Approx(double(counted.pixels_stopped)).epsilon(1e-2));
    });
  }
}

TEST_CASE(
    "cuda long lists: warp blocks that show next to nothing behind their first segment are shared too") {
  if (without_device()) return;
  // More warp blocks than would be taken up at the end of their first segment.
  const int side = 96;
  const Camera camera = square_camera(side);
  const Scene scene = layers_before_corners(50'000, side);
  const Scene short_lists = layers_before_corners(50'000, side, false);
  RenderSettings settings;
  settings.outputs = {true, true};
  for_each_segmented([&](auto&& renderer) {
    CAPTURE(std::decay_t<decltype(renderer)>::name);
    const DeviceScene uploaded = renderer.backend().upload(scene);
    for (const bool extras : {false, true}) check_parts(renderer, uploaded.view(), side, 32, extras);

    // A traversal alone would visit 50,600 intersections. Others take them over behind the first 512 or
    // later.
    const RasterCounts counts = counts_of(renderer, uploaded, camera);
    CHECK(counts.segments > 100);
    CHECK(counts.longest_item < 50'300);
    for (int run = 0; run < 5; ++run) {
      const RasterCounts again = counts_of(renderer, uploaded, camera);
      CHECK(again.contributing_pairs == counts.contributing_pairs);
      CHECK(again.pixels_stopped == counts.pixels_stopped);
    }

    // The other quarters look as they do without the dots of the first, when warps traverse all lists alone.
    Frame drawn, expected;
    renderer.render(uploaded, camera, settings, drawn);
    const DeviceScene uploaded_short = renderer.backend().upload(short_lists);
    CHECK(counts_of(renderer, uploaded_short, camera).segments == 0);
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

TEST_CASE("cuda long lists: views of one frame have the bits of frames of their own") {
  if (without_device()) return;
  const int sides[] = {96, 64};
  const Scene scene = layers(30'000, 0.0003, 0.006);
  for_each_segmented([&](auto&& renderer) {
    CAPTURE(std::decay_t<decltype(renderer)>::name);
    const DeviceScene uploaded = renderer.backend().upload(scene);
    for (const bool extras : {false, true}) {
      CAPTURE(extras);
      Planes together[] = {Planes(sides[0]), Planes(sides[1])},
             alone[] = {Planes(sides[0]), Planes(sides[1])};
      std::vector<View> views;
      for (std::size_t v = 0; v < 2; ++v) {
        const auto view_into = [&](Planes& planes) {
          return make_view(square_camera(sides[v]), faint(), planes.part(sides[v], {}, extras),
                           vec3(float(v)));
        };
        views.push_back(view_into(together[v]));
        const View single = view_into(alone[v]);
        renderer.render_into(uploaded.view(), {&single, 1});
      }
      for (int run = 0; run < 3; ++run) {
        renderer.render_into(uploaded.view(), {views.data(), views.size()});
        for (std::size_t v = 0; v < 2; ++v)
          CHECK(same_planes(renderer.backend(), together[v], alone[v], extras));
      }
      renderer.render_into(uploaded.view(), {views.data(), views.size()}, {.count = true});
      CHECK(renderer.statistics().raster.segments > 100);
      for (std::size_t v = 0; v < 2; ++v)
        CHECK(same_planes(renderer.backend(), together[v], alone[v], extras));
    }
  });
}

TEST_CASE("cuda long lists: a graph that runs again and again has the bits of rendered frames") {
  if (without_device()) return;
  const int side = 96;
  const Scene scene = layers(30'000, 0.0003, 0.006);
  for_each_type(Segmented(), [&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Stream stream;
    With<Raster> recorded{Cuda(stream.get())}, rendered{Cuda(stream.get())};
    const Cuda& cuda = recorded.backend();
    const DeviceScene uploaded = cuda.upload(scene);
    for (const bool extras : {false, true}) {
      CAPTURE(extras);
      Planes replayed(side), expected(side);
      const auto view_into = [&](Planes& planes) {
        return make_view(square_camera(side), faint(), planes.part(side, {}, extras), vec3(1));
      };
      const View view = view_into(expected), recorded_view = view_into(replayed);
      rendered.render_into(uploaded.view(), {&view, 1}, {.count = true});
      const Statistics statistics = rendered.statistics();
      CHECK(statistics.raster.segments > 100);
      rendered.render_into(uploaded.view(), {&view, 1});

      DeviceBuffer<FrameReport> report;
      report.reset(1);
      recorded.reserve(uploaded.view(), {&recorded_view, 1}, {statistics.visible, statistics.intersections});
      const Graph graph(stream, [&] { recorded.record(uploaded.view(), report.data()); });
      for (int run = 0; run < 3; ++run) {
        replayed.poison();
        graph.run();
        CHECK(same_planes(cuda, replayed, expected, extras));
        CHECK(to_host(cuda, std::as_const(report).span())[0].overflowed == 0);
      }
    }
  });
}

TEST_CASE(
    "cuda long lists: thread blocks that share warp blocks work no longer than the frame is rasterized") {
  if (without_device()) return;
  const int side = 384;
  const Scene scene = layers(228'000, 0.0001, 0.002);
  for_each_segmented([&](auto&& renderer) {
    CAPTURE(std::decay_t<decltype(renderer)>::name);
    const DeviceScene uploaded = renderer.backend().upload(scene);
    RenderSettings settings;
    settings.conventions = faint(), settings.count = settings.time = true;
    Frame frame;
    for (int i = 0; i < 2; ++i)  // the first frame has kernels loaded
      renderer.render(uploaded, square_camera(side), settings, frame);
    const Statistics statistics = renderer.statistics();
    CHECK(statistics.raster.segments > 10'000);
    const double evenness = statistics.balanced_ms() / renderer.times().raster;
    CHECK(evenness > 0.05);
    CHECK(evenness < 1);
  });
}

TEST_CASE("cuda long lists: frames stop sharing after eight without long warp blocks, and the bits stay") {
  if (without_device()) return;
  const int side = 64;
  const Scene long_lists = layers(30'000, 0.0003, 0.006), short_lists = layers(500, 0.004, 0.01);
  for_each_segmented([&](auto&& renderer) {
    CAPTURE(std::decay_t<decltype(renderer)>::name);
    Cuda& cuda = renderer.backend();
    const DeviceScene of_long = cuda.upload(long_lists), of_short = cuda.upload(short_lists);
    for (const bool extras : {false, true}) {
      CAPTURE(extras);
      Planes drawn(side), expected(side);
      // Returns what the host knows when the next frame begins: frames without long warp blocks, of those
      // before the one that is drawn.
      const auto render = [&](const DeviceScene& scene, Planes& planes, bool counted = false) {
        const View view = make_view(square_camera(side), faint(), planes.part(side, {}, extras), vec3(1));
        planes.poison();
        renderer.render_into(scene.view(), {&view, 1}, {.count = counted});
        return cuda.known_raster_word();
      };
      const auto check_long_frame = [&] { CHECK(same_planes(cuda, drawn, expected, extras)); };

      // The first frame shares, also where the renderer had to make room for it and drew nothing at first.
      CHECK(cuda.known_raster_word() == 0);
      CHECK(render(of_long, expected) < 8);
      CHECK(render(of_long, drawn) == 0);
      check_long_frame();

      for (std::uint32_t quiet = 0; quiet < 8; ++quiet) CHECK(render(of_short, drawn) == quiet);
      CHECK(render(of_short, drawn) == 8);
      CHECK(render(of_short, drawn) == 8);  // this one alone
      CHECK(render(of_long, drawn) == 8);   // and this one, with traversals that are long
      check_long_frame();
      CHECK(render(of_long, drawn) == 0);
      check_long_frame();

      // Now and then a short frame: all share.
      for (int i = 0; i < 4; ++i) {
        CHECK(render(of_short, drawn) == 0);
        CHECK(render(of_long, drawn) == 1);
        check_long_frame();
      }

      // Counted frames share, whatever was before.
      for (int i = 0; i < 10; ++i) render(of_short, drawn);
      CHECK(render(of_long, drawn, true) == 8);
      CHECK(renderer.statistics().raster.segments > 100);
      check_long_frame();
      CHECK(render(of_short, drawn, true) == 0);
      CHECK(renderer.statistics().raster.segments == 0);
      CHECK(render(of_long, drawn) == 1);
      check_long_frame();
      CHECK(render(of_long, drawn) == 0);
    }
  });
}

TEST_CASE("cuda long lists: counts tell of segments only where lists are long") {
  if (without_device()) return;
  With<AxisSharedThreshold<FloatCholesky>> renderer;
  const Camera camera = square_camera(64);
  const RasterCounts usual = counts_of(renderer, renderer.backend().upload(layers(500, 0.004, 0.01)), camera);
  CHECK(usual.segments == 0);
  CHECK(usual.pixels_joined == 0);
  CHECK(usual.longest_item > 100);
  CHECK(usual.longest_item <= 500);
  Scene scene = layers(14'700, 0.0003, 0.012);
  put_dots(scene, 900, 64);
  const RasterCounts longer = counts_of(renderer, renderer.backend().upload(scene), camera, faint());
  CHECK(longer.segments > 64);
  CHECK(longer.pixels_joined > 4 * longer.segments);
  CHECK(longer.pixels_joined <= 64 * longer.segments);
  CHECK(longer.longest_item >= 2048);
  CHECK(longer.longest_item < 9'700);  // a traversal alone would visit 9,990
  // Where warp blocks show little of a list, a traversal is long too.
  const RasterCounts visited = counts_of(renderer, renderer.backend().upload(corners(14'000, 64)), camera);
  CHECK(visited.longest_item >= 2048);
  CHECK(visited.longest_item < 13'900);  // a traversal alone would visit 14,080
}
