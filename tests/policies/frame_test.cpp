// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "policies/directions.hpp"
#include "policies/images.hpp"
#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

template <class B, class Raster>
using RendererWith = Renderer<B, EarlySort, Raster, Ellipse>;

RenderSettings settings_with(vec3 background) {
  RenderSettings settings;
  settings.background = background, settings.outputs = {true, true}, settings.count = true;
  return settings;
}

/// Checks that `frame` is the reference's, whose depths reach 12.
template <class Raster>
void check_near(const Frame& frame, const ReferenceFrame& reference) {
  const bool half = stores_half<Raster>;
  CHECK(psnr(frame.colour, reference.colour) >= (half ? 65 : 125));
  CHECK(psnr(frame.alpha, reference.alpha) >= (half ? 65 : 125));
  CHECK(psnr(frame.depth, reference.depth) >= (half ? 65 : 115));
  if (half) return;
  CHECK(max_abs_difference(frame.colour, reference.colour) <= 1.0 / 255);
  CHECK(max_abs_difference(frame.alpha, reference.alpha) <= 1.0 / 255);
  CHECK(max_abs_difference(frame.depth, reference.depth) <= 1e-3);
}

/// A frame behind whose splats the caller's surface stands.
template <class R, class SceneOn>
Frame render_before(R& renderer, const SceneOn& scene, const Camera& camera,
                    const std::vector<float>& occluder, std::ptrdiff_t pitch) {
  Frame frame;
  FrameView view = prepare(frame, camera.width, camera.height, {true, true});
  view.occluder = {occluder.data(), pitch * std::ptrdiff_t(sizeof(float))};
  renderer.render_into(scene.view(), camera, settings_with(vec3(0.1f, 0.2f, 0.3f)), view);
  return frame;
}

/// The same depth at all pixels.
template <class R, class SceneOn>
Frame render_before(R& renderer, const SceneOn& scene, const Camera& camera, float depth) {
  const std::vector<float> occluder(std::size_t(camera.width) * std::size_t(camera.height), depth);
  return render_before(renderer, scene, camera, occluder, camera.width);
}

bool same_bits(const Frame& a, const Frame& b) {
  return a.colour == b.colour && a.alpha == b.alpha && a.depth == b.depth;
}

}  // namespace

TEST_CASE("frame: a channel of 8 bits is the nearest of 255 steps") {
  for (int k = 0; k <= 255; ++k) CHECK(to_unorm8(float(k) / 255) == k);
  for (int k = 0; k < 255; ++k) {
    const float middle = float((k + 0.5) / 255);
    CHECK(to_unorm8(middle * (1 - 1e-6f)) == k);
    CHECK(to_unorm8(middle * (1 + 1e-6f)) == k + 1);
  }
  for (const float nothing : {-0.0f, -1.0f, -infinity, not_a_number, 1e-40f}) CHECK(to_unorm8(nothing) == 0);
  for (const float all : {1.0f, 1.001f, 1e30f, infinity}) CHECK(to_unorm8(all) == 255);
}

TEST_CASE_TEMPLATE("frame: each pixel format holds the same frame and its opacity as far as it carries", B,
                   SWIFTGS_TEST_BACKENDS) {
  for (const auto& [width, height] : {std::pair{37, 21}, {16, 16}, {1, 1}, {70, 5}})
    for_each_raster([&, w = width, h = height]<class Raster>(Raster) {
      CAPTURE(Raster::name);
      RendererWith<B, Raster> renderer(make_backend<B>());
      const auto scene = renderer.backend().upload(random_scene(300, 1, 5));
      const Camera camera = forward_camera(w, h);
      // Brighter than 8 bits hold, darker, and no part of the opacity.
      const RenderSettings settings = settings_with(vec3(0.3f, 1.7f, -0.4f));
      const Frame plain = renderer.render(scene, camera, settings);
      Image floats(w, h, PixelFormat::rgba_float);
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
          const std::size_t at = std::size_t(y) * std::size_t(w) + std::size_t(x);
          const float* rgb = plain.colour.data() + 3 * at;
          floats.set(x, y, {rgb[0], rgb[1], rgb[2], plain.alpha[at]});
        }
      for (const PixelFormat format : pixel_formats) {
        CAPTURE(int(format));
        Image image(w, h, format);
        renderer.render_into(scene.view(), camera, settings, image.frame());
        CHECK((image.bytes == converted(floats, format).bytes));
        CHECK(image.kept_to_its_rows());
      }
    });
}

TEST_CASE_TEMPLATE("frame: what lies below is seen as far as transmittance is left", B,
                   SWIFTGS_TEST_BACKENDS) {
  const int width = 37, height = 21;
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    RendererWith<B, Raster> renderer(make_backend<B>());
    const auto scene = renderer.backend().upload(random_scene(60, 1, 6));
    const Camera camera = forward_camera(width, height);
    const Frame alone = renderer.render(scene, camera, settings_with(vec3(0)));
    const auto over = [&](Image image) {
      FrameView frame = image.frame();
      frame.over = true;
      renderer.render_into(scene.view(), camera, settings_with(vec3(9)), frame);
      CHECK(image.kept_to_its_rows());
      return image;
    };
    for (const PixelFormat format : pixel_formats) {
      CAPTURE(int(format));
      Image below = pattern(width, height, format), above = over(below);
      // In float the arithmetic is that of the composition; other formats round its result once.
      CHECK((above.bytes == converted(over(converted(below, PixelFormat::rgba_float)), format).bytes));
      if (format != PixelFormat::rgba_float) continue;
      double worst = 0;
      std::size_t clear = 0, unchanged = 0;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const std::size_t at = std::size_t(y) * width + std::size_t(x);
          const double alpha = double(alone.alpha[at]);
          for (int c = 0; c < 4; ++c) {
            const double own = c < 3 ? double(alone.colour[3 * at + std::size_t(c)]) : alpha;
            const double expected = own + (1 - alpha) * double(below.at(x, y)[c]);
            worst = std::max(worst, std::abs(double(above.at(x, y)[c]) - expected));
          }
          clear += alpha == 0, unchanged += alpha == 0 && above.at(x, y) == below.at(x, y);
        }
      CHECK(worst < 1e-6);
      CHECK(clear > 10);
      CHECK(unchanged == clear);
    }
  });
}

TEST_CASE_TEMPLATE("frame: a surface that hides nothing changes no bit", B, SWIFTGS_TEST_BACKENDS) {
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    RendererWith<B, Raster> renderer(make_backend<B>());
    const auto scene = renderer.backend().upload(random_scene(500, 0, 7));
    const Camera camera = forward_camera(70, 45);
    const Frame alone = renderer.render(scene, camera, settings_with(vec3(0.1f, 0.2f, 0.3f)));
    const RasterCounts counts = renderer.statistics().raster;
    for (const float nowhere : {infinity, not_a_number, 1e20f}) {
      CAPTURE(nowhere);
      CHECK(same_bits(render_before(renderer, scene, camera, nowhere), alone));
      const RasterCounts again = renderer.statistics().raster;
      CHECK(again.contributing_pairs == counts.contributing_pairs);
      CHECK(again.pixels_stopped == counts.pixels_stopped);
      CHECK(again.intersections_visited == counts.intersections_visited);
    }
  });
}

TEST_CASE_TEMPLATE("frame: a surface before everything leaves the background", B, SWIFTGS_TEST_BACKENDS) {
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    RendererWith<B, Raster> renderer(make_backend<B>());
    const auto scene = renderer.backend().upload(random_scene(500, 0, 8));
    const auto nothing = renderer.backend().upload(Scene());
    const Camera camera = forward_camera(70, 45);
    const Frame empty = renderer.render(nothing, camera, settings_with(vec3(0.1f, 0.2f, 0.3f)));
    for (const float everywhere : {0.0f, -0.0f, -3.0f, -infinity}) {
      CAPTURE(everywhere);
      CHECK(same_bits(render_before(renderer, scene, camera, everywhere), empty));
      CHECK(renderer.statistics().raster.contributing_pairs == 0);
    }
  });
}

TEST_CASE_TEMPLATE("frame: a surface in the middle leaves the image of the Gaussians before it", B,
                   SWIFTGS_TEST_BACKENDS) {
  const Camera camera = forward_camera(70, 45);
  const Scene all = random_scene(800, 0, 9);
  // One Gaussian lies in the surface, and is hidden by it.
  const float depth = all.means[100].z;
  REQUIRE(depth > 2);
  Scene nearer = all;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all.means[i].z >= depth) nearer.opacities[i] = 0;
  const std::vector<float> occluder(70 * 45, depth);
  const ReferenceFrame reference =
      render_reference(all, camera, Conventions::gsplat(), vec3(0.1f, 0.2f, 0.3f), 0,
                       Span<const float>{occluder.data(), occluder.size()});
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    RendererWith<B, Raster> renderer(make_backend<B>());
    const auto scene = renderer.backend().upload(all);
    const auto expected =
        renderer.render(renderer.backend().upload(nearer), camera, settings_with(vec3(0.1f, 0.2f, 0.3f)));
    const Frame frame = render_before(renderer, scene, camera, depth);
    CHECK(same_bits(frame, expected));
    check_near<Raster>(frame, reference);
    const RasterCounts counts = renderer.statistics().raster;
    CHECK(double(counts.contributing_pairs) ==
          doctest::Approx(double(reference.contributing_pairs)).epsilon(1e-2));
    CHECK(double(counts.pixels_stopped) == doctest::Approx(double(reference.pixels_stopped)).epsilon(1e-2));
  });
}

TEST_CASE_TEMPLATE("frame: each pixel is hidden by its own depth", B, SWIFTGS_TEST_BACKENDS) {
  const int width = 53, height = 37;
  const std::size_t pitch = 61;
  const Camera camera = forward_camera(width, height);
  const Scene all = random_scene(800, 0, 10);
  const float depths[] = {3, not_a_number, 1.5f, 0, 7, infinity, 5};
  std::vector<float> occluder(pitch * height, 0.0f), tight;
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      tight.push_back(occluder[y * pitch + x] = depths[(x + 3 * y) % std::size(depths)]);
  const ReferenceFrame reference =
      render_reference(all, camera, Conventions::gsplat(), vec3(0.1f, 0.2f, 0.3f), 0,
                       Span<const float>{tight.data(), tight.size()});
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    RendererWith<B, Raster> renderer(make_backend<B>());
    const auto scene = renderer.backend().upload(all);
    const Frame frame = render_before(renderer, scene, camera, occluder, pitch);
    check_near<Raster>(frame, reference);
    std::size_t different = 0;
    for (std::size_t k = 0; k < std::size(depths); ++k) {
      const Frame even = render_before(renderer, scene, camera, depths[k]);
      for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x) {
          if ((x + 3 * y) % std::size(depths) != k) continue;
          const std::size_t at = y * width + x;
          different += std::memcmp(&frame.colour[3 * at], &even.colour[3 * at], 12) != 0 ||
                       frame.alpha[at] != even.alpha[at] || frame.depth[at] != even.depth[at];
        }
    }
    CHECK(different == 0);
  });
}

TEST_CASE_TEMPLATE("frame: a tile ends when the surface has hidden all its pixels", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet splats;
  for (int i = 0; i < 1000; ++i) splats.add(make_splat(16, 8, 500, 500, 0, 0.01), 1.0f + float(i));
  const SortInput job = splats.job(32, 16);
  const TileLists<B> lists = build_lists<EarlySort, Ellipse>(backend, job);
  const std::vector<float> occluder(32 * 16, 4.0f);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    RasterCounts counts[2];
    const View view =
        view_into({.width = 32, .height = 16, .occluder = {occluder.data(), 32 * sizeof(float)}});
    rasterize(backend, Raster{},
              RasterJob{splats.view(), splats.colours_view(), lists.view(), {&view, 1}, counts});
    for (const RasterCounts& block : counts) {
      CHECK(block.contributing_pairs == 3 * 256);
      CHECK(block.pixels_stopped == 256);
      CHECK(block.intersections_visited >= 4);
      CHECK(block.intersections_visited <= 64);  // a backend may look at lists in batches
    }
  });
}

TEST_CASE_TEMPLATE("frame: rows of each plane may go up in memory", B, SWIFTGS_TEST_BACKENDS) {
  const int width = 37, height = 21;
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    RendererWith<B, Raster> renderer(make_backend<B>());
    const auto scene = renderer.backend().upload(random_scene(300, 1, 12));
    const RenderSettings settings = settings_with(vec3(0.3f, 1.7f, -0.4f));
    check_directions(width, height, [&](PlanesMemory& memory, bool over) {
      auto& bytes = memory.bytes;
      FrameView frame = memory.frame({bytes[0].data(), bytes[1].data(), bytes[2].data(), bytes[3].data()});
      frame.over = over;
      renderer.render_into(scene.view(), forward_camera(width, height), settings, frame);
    });
  });
}

TEST_CASE("frame: planes that cannot be written are refused in words") {
  RendererWith<Serial, PerPixel> renderer;
  const Scene scene = random_scene(10, 0, 11);
  std::vector<float> memory(4 * 40 * 30);
  const auto refusal = [&](FrameView frame) {
    frame.width = 40, frame.height = 30;
    try {
      renderer.render_into(view(scene), forward_camera(40, 30), {}, frame);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const auto colour = [&](PixelFormat format, std::ptrdiff_t pitch) {
    float* const top = pitch == -480 ? memory.data() + 29 * 120 : memory.data();
    return refusal({.colour = {top, pitch}, .format = format});
  };
  CHECK(colour(PixelFormat::rgb_float, 480) == "accepted");
  CHECK(colour(PixelFormat::rgb_float, 479) ==
        "render: the pitch of colour is 479 bytes, expected at least 480 up or down, a multiple of 4");
  CHECK(colour(PixelFormat::rgb_float, -480) == "accepted");
  CHECK(colour(PixelFormat::rgb_float, -476) ==
        "render: the pitch of colour is -476 bytes, expected at least 480 up or down, a multiple of 4");
  CHECK(colour(PixelFormat::rgb_float, -482) ==
        "render: the pitch of colour is -482 bytes, expected at least 480 up or down, a multiple of 4");
  CHECK(colour(PixelFormat::rgba_float, 642) ==
        "render: the pitch of colour is 642 bytes, expected at least 640 up or down, a multiple of 4");
  CHECK(colour(PixelFormat::rgba_half, 322) == "accepted");
  CHECK(colour(PixelFormat::rgba_half, 323) ==
        "render: the pitch of colour is 323 bytes, expected at least 320 up or down, a multiple of 2");
  CHECK(colour(PixelFormat::rgba_8, 161) == "accepted");
  CHECK(colour(PixelFormat::rgba_8, 159) ==
        "render: the pitch of colour is 159 bytes, expected at least 160 up or down, a multiple of 1");
  CHECK(refusal({.occluder = {memory.data(), 156}}) ==
        "render: the pitch of occluder is 156 bytes, expected at least 160 up or down, a multiple of 4");
  CHECK(refusal({.occluder = {memory.data(), -1}}) ==
        "render: the pitch of occluder is -1 bytes, expected at least 160 up or down, a multiple of 4");
  CHECK(refusal({.depth = {memory.data(), -162}}) ==
        "render: the pitch of depth is -162 bytes, expected at least 160 up or down, a multiple of 4");
  CHECK(refusal({.alpha = {memory.data(), 162}}) ==
        "render: the pitch of alpha is 162 bytes, expected at least 160 up or down, a multiple of 4");
  // No memory is so large that 30 rows may lie as far apart; the least number has no magnitude of its type.
  const std::ptrdiff_t most = std::numeric_limits<std::ptrdiff_t>::max() / 30;
  for (const std::ptrdiff_t pitch : {-most - 1, most + 1, std::numeric_limits<std::ptrdiff_t>::min(),
                                     std::numeric_limits<std::ptrdiff_t>::max()})
    CHECK(refusal({.alpha = {memory.data(), pitch}}) ==
          "render: the pitch of alpha is " + std::to_string(pitch) + " bytes, expected at most " +
              std::to_string(most) + " up or down, a multiple of 4");
  CHECK(refusal({.over = true}) == "render: expected colour to render over");
}
