// SPDX-License-Identifier: Apache-2.0

// Frames whose lists many warps share: planes, views, graphs, and when sharing ends.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cuda/graph.hpp"
#include "cuda/long_lists.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

SWIFTGS_DEVICE_CASE("cuda long lists: planes change no bit of colour and depth, and share as colour does") {
  const int side = 96;
  for (const Scene& scene : {layers(30'000, 0.0003, 0.006), layers(60'000, 0.0002, 0.002)}) {
    CAPTURE(scene.size());
    const Scene drawn = with_features(scene, 7);
    for_each_segmented([&](auto&& renderer) {
      const DeviceScene uploaded = renderer.backend().upload(drawn);
      const Cuda& cuda = renderer.backend();
      const auto draw = [&](const Outputs& outputs) {
        RenderSettings settings;
        settings.conventions = faint(), settings.outputs = outputs;
        Frame frame;
        renderer.render(uploaded, square_camera(side), settings, frame);
        return frame;
      };
      const Outputs some{.alpha = true, .depth = true};
      const Frame expected = draw(some);
      for (Outputs outputs : {Outputs{.id = true}, Outputs{.median_depth = true}, Outputs{.normal = true},
                              Outputs{.normal = true, .id = true, .features = 7}}) {
        outputs.alpha = outputs.depth = true;
        const Frame frame = draw(outputs);
        cuda.wait();
        CHECK(RasterMemory::of(cuda).known_word == 0);
        CHECK(same_bits(frame.colour, expected.colour));
        CHECK(same_bits(frame.alpha, expected.alpha));
        CHECK(same_bits(frame.depth, expected.depth));
        CHECK(was_shared(cuda));
      }
    });
  }
}

SWIFTGS_DEVICE_CASE("cuda long lists: views of one frame have the bits of frames of their own") {
  const Scene scene = with_features(layers(30'000, 0.0003, 0.006), 7);
  for_each_segmented([&](auto&& renderer) {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    for (const Wanted& wanted : wanted_planes()) {
      CAPTURE(std::string(wanted.name));
      std::vector<AskedView> asked{square_view(96, wanted, faint()), square_view(64, wanted, faint())};
      asked[0].background = vec3(0);
      asked.push_back(asked[1]);
      asked.back().conventions.alpha_min = 1e-6f;
      const std::vector<PlanesMemory> alone = draw_alone(renderer, uploaded.view(), asked).memories;
      for (int run = 0; run < 4; ++run)
        CHECK(differing(draw_together(renderer, uploaded.view(), asked), alone) == 0);
      CHECK(was_shared(renderer.backend()));
    }
  });
}

SWIFTGS_DEVICE_CASE("cuda long lists: a graph that runs again and again has the bits of rendered frames") {
  const Scene scene = with_features(layers(30'000, 0.0003, 0.006), 7);
  for_each_type(Segmented(), [&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Stream stream;
    Usual<Cuda, EarlySort, Raster> recorded{Cuda(stream.get())}, rendered{Cuda(stream.get())};
    const Cuda& cuda = recorded.backend();
    const DeviceScene uploaded = cuda.upload(scene);
    for (const Wanted& wanted : wanted_planes()) {
      CAPTURE(std::string(wanted.name));
      const std::vector<AskedView> asked{square_view(96, wanted, faint())};
      std::vector<AskedView> fainter = asked;
      fainter[0].conventions.alpha_min = 1e-6f;
      draw_together(rendered, uploaded.view(), fainter);
      const Statistics statistics = rendered.statistics();
      CHECK(was_shared(rendered.backend()));

      Report<Cuda> report;
      const PlacedViews reserved(cuda, asked);
      recorded.reserve(uploaded.view(), reserved.span(), {statistics.visible, statistics.intersections});
      const Graph graph(stream, [&] { recorded.record(uploaded.view(), report.data()); });
      for (int run = 0; run < 4; ++run) {
        const std::vector<AskedView>& now = run % 2 ? fainter : asked;
        const std::vector<PlanesMemory> expected = draw_together(rendered, uploaded.view(), now);
        PlacedViews drawn(cuda, now);
        recorded.set_views(drawn.span());
        graph.run();
        CHECK(differing(drawn.finish(cuda), expected) == 0);
        CHECK(report.get(cuda).overflowed == 0);
      }
    }
  });
}

SWIFTGS_DEVICE_CASE("cuda long lists: frames stop sharing after eight short ones, and the bits stay") {
  const int side = 64;
  const Scene long_lists = with_features(layers(30'000, 0.0003, 0.006), 7),
              short_lists = with_features(layers(500, 0.004, 0.01), 7);
  for_each_type(Segmented(), [&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    for (const Wanted& wanted : wanted_planes()) {
      CAPTURE(std::string(wanted.name));
      Usual<Cuda, EarlySort, Raster> renderer;  // knows of no frame
      Cuda& cuda = renderer.backend();
      const DeviceScene of_long = cuda.upload(long_lists), of_short = cuda.upload(short_lists);
      // Picks and several rows are rasterized apart, and both apart from colours of split terms.
      const bool apart = is_split(Raster::name) && (wanted.further.id || wanted.further.normal);
      const std::uint32_t rasterized = (wanted.further.id && wanted.further.features != 0 ? 2 : 1) + apart;
      std::vector<PlanesMemory> drawn;
      // Draws a frame. Returns the host's number of earlier frames without long warp blocks. A frame counts
      // as often as it was rasterized.
      const auto render = [&](const DeviceScene& scene) {
        PlacedViews views(cuda, {square_view(side, wanted, faint())});  // waits for the frame before
        renderer.render_into(scene.view(), views.span());
        const std::uint32_t known = RasterMemory::of(cuda).known_word;
        drawn = views.finish(cuda);
        return known;
      };

      // The first frame shares, also where the renderer had to make room for it and drew nothing at first.
      CHECK(RasterMemory::of(cuda).known_word == 0);
      CHECK(render(of_long) < 8);
      const std::vector<PlanesMemory> expected = drawn;
      const auto check_long_frame = [&] { CHECK(differing(drawn, expected) == 0); };
      CHECK(render(of_long) == 0);
      check_long_frame();

      for (std::uint32_t quiet = 0; quiet < 8; ++quiet)
        CHECK(render(of_short) == std::min(rasterized * quiet, 8u));
      CHECK(render(of_short) == 8);
      CHECK(render(of_short) == 8);  // this one alone
      CHECK(render(of_long) == 8);   // and this one, with traversals that are long
      check_long_frame();
      CHECK(render(of_long) == 0);
      check_long_frame();

      // Now and then a short frame: all share.
      for (int i = 0; i < 4; ++i) {
        CHECK(render(of_short) == 0);
        CHECK(render(of_long) == rasterized);
        check_long_frame();
      }
    }
  });
}
