// SPDX-License-Identifier: Apache-2.0

// Planes, pixel formats, composition and occluders of frames, on every backend.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::frame_test {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

RenderSettings settings_with(vec3 background) {
  RenderSettings settings = settings_of(all_planes(), background);
  settings.count = true;
  return settings;
}
/// Brighter than 8 bits hold, darker, and no part of the opacity.
RenderSettings striking_background() { return settings_with(vec3(0.3f, 1.7f, -0.4f)); }

/// Renders into an image, over what it holds or not.
template <class B>
Image render_image(BoundRenderer<B>& renderer, const SceneView& scene, const RenderSettings& settings,
                   Image image, bool over = false) {
  const auto& backend = renderer.backend();
  auto bytes = to_backend(backend, image.bytes);
  FrameView frame = image.frame();
  frame.colour.data = bytes.data(), frame.over = over;
  renderer.render_into(scene, forward_camera(image.width, image.height), settings, frame);
  image.bytes = to_host(backend, std::as_const(bytes).span());
  CHECK(image.kept_to_its_rows());
  return image;
}

/// All planes of a frame behind whose splats the caller's surface stands.
template <class B>
Frame render_before(BoundRenderer<B>& renderer, const SceneView& scene, const Camera& camera,
                    const std::vector<float>& occluder, std::ptrdiff_t pitch, StoredDepth stored = {}) {
  const auto& backend = renderer.backend();
  const auto depths = to_backend(backend, occluder);
  Frame whole;
  // A device has other kernels for each of these frames.
  for (const Outputs& outputs : {all_planes(), Outputs{true, true}})
    for (const bool count : {false, true}) {
      PlanesOn<B> planes(backend, camera.width, camera.height, outputs);
      FrameView view = planes.view();
      view.occluder = {depths.data(), pitch * std::ptrdiff_t(sizeof(float))}, view.stored_depth = stored;
      RenderSettings settings = settings_with(vec3(0.1f, 0.2f, 0.3f));
      settings.count = count;
      renderer.render_into(scene, camera, settings, view);
      const Frame drawn = planes.on_host(backend);
      if (whole.colour.empty()) whole = drawn;
      CHECK(same_of(drawn, whole));
    }
  return whole;
}

/// The same depth at all pixels.
template <class B>
Frame render_before(BoundRenderer<B>& renderer, const SceneView& scene, const Camera& camera, float depth) {
  const std::vector<float> occluder(std::size_t(camera.width) * std::size_t(camera.height), depth);
  return render_before(renderer, scene, camera, occluder, camera.width);
}

/// Checks that `frame` is the reference's, whose depths reach 12. A device may keep or lose a splat at the
/// threshold of alpha, which moves a depth by any amount.
template <class B>
void check_near(std::string_view raster, const Frame& frame, const ReferenceFrame& reference) {
  const bool half = stores_half(raster);
  const double least_db = on_host<B> ? (half ? 65 : 125) : (half ? 40 : 80);
  CHECK(psnr(frame.colour, reference.colour) >= least_db);
  CHECK(psnr(frame.alpha, reference.alpha) >= least_db);
  if (!on_host<B>) return;
  CHECK(psnr(frame.depth, reference.depth) >= (half ? 65 : 115));
  if (half) return;
  CHECK(max_abs_difference(frame.colour, reference.colour) <= 1.0 / 255);
  CHECK(max_abs_difference(frame.alpha, reference.alpha) <= 1.0 / 255);
  CHECK(max_abs_difference(frame.depth, reference.depth) <= 1e-3);
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

SWIFTGS_CONTRACT("frame: each pixel format holds the same frame and its opacity as far as it carries") {
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view) {
    const auto scene = renderer.backend().upload(random_scene(300, 1, 5));
    for (const auto& [w, h] : {std::pair{37, 21}, {16, 16}, {1, 1}, {70, 5}}) {
      const Frame plain = renderer.render(scene, forward_camera(w, h), striking_background());
      Image floats(w, h, PixelFormat::rgba_float);
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
          const std::size_t at = std::size_t(y) * std::size_t(w) + std::size_t(x);
          const float* rgb = plain.colour.data() + 3 * at;
          floats.set(x, y, {rgb[0], rgb[1], rgb[2], plain.alpha[at]});
        }
      for (const PixelFormat format : pixel_formats) {
        CAPTURE(int(format));
        const Image image = render_image(renderer, scene.view(), striking_background(), Image(w, h, format));
        CHECK((image.bytes == converted(floats, format).bytes));
      }
    }
  });
}

SWIFTGS_CONTRACT("frame: what lies below is seen as far as transmittance is left") {
  const int width = 37, height = 21;
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view) {
    const auto scene = renderer.backend().upload(random_scene(60, 1, 6));
    const Frame alone = renderer.render(scene, forward_camera(width, height), settings_with(vec3(0)));
    const auto over = [&](const Image& below) {
      return render_image(renderer, scene.view(), settings_with(vec3(9)), below, true);
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

SWIFTGS_CONTRACT("frame: a surface that hides nothing changes no bit and one before everything leaves none") {
  const Camera camera = forward_camera(70, 45);
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view) {
    const auto scene = renderer.backend().upload(random_scene(500, 0, 7));
    const RenderSettings settings = settings_with(vec3(0.1f, 0.2f, 0.3f));
    const Frame empty = renderer.render(renderer.backend().upload(Scene()), camera, settings);
    const Frame alone = renderer.render(scene, camera, settings);
    const RasterCounts counts = renderer.statistics().raster;
    for (const float nowhere : {infinity, not_a_number, 1e20f}) {
      CAPTURE(nowhere);
      CHECK(same_planes(render_before(renderer, scene.view(), camera, nowhere), alone));
      const RasterCounts again = renderer.statistics().raster;
      CHECK(again.contributing_pairs == counts.contributing_pairs);
      CHECK(again.pixels_stopped == counts.pixels_stopped);
      if (on_host<B>) CHECK(again.intersections_visited == counts.intersections_visited);
    }
    for (const float everywhere : {0.0f, -0.0f, -3.0f, -infinity}) {
      CAPTURE(everywhere);
      CHECK(same_planes(render_before(renderer, scene.view(), camera, everywhere), empty));
      CHECK(renderer.statistics().raster.contributing_pairs == 0);
    }
  });
}

SWIFTGS_CONTRACT("frame: a surface in the middle leaves the image of the Gaussians before it") {
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
      render_reference(all, camera, Conventions::gsplat(), vec3(0.1f, 0.2f, 0.3f), 0, span_of(occluder));
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view raster) {
    const auto scene = renderer.backend().upload(all);
    const auto expected =
        renderer.render(renderer.backend().upload(nearer), camera, settings_with(vec3(0.1f, 0.2f, 0.3f)));
    const Frame frame = render_before(renderer, scene.view(), camera, depth);
    CHECK(same_planes(frame, expected));
    check_near<B>(raster, frame, reference);
    const RasterCounts counts = renderer.statistics().raster;
    CHECK(double(counts.contributing_pairs) ==
          doctest::Approx(double(reference.contributing_pairs)).epsilon(on_host<B> ? 1e-2 : 3e-2));
    CHECK(double(counts.pixels_stopped) ==
          doctest::Approx(double(reference.pixels_stopped)).epsilon(on_host<B> ? 1e-2 : 3e-2));
  });
}

TEST_CASE("frame: stored depths are those of OpenGL, Vulkan and Direct3D") {
  const double n = 0.25, f = 400;
  for (const double z : {0.25, 0.3, 1.0, 7.0, 100.0, 400.0}) {
    CAPTURE(z);
    const auto holds = [&](StoredDepth stored, double value) {
      const double below = stored.r * value + stored.s;
      const double slope = (stored.p * stored.s - stored.q * stored.r) / (below * below);
      // Half a last bit of the value, and of the depth.
      return std::abs(stored.depth(float(value)) - z) <= 0x1p-25 * std::abs(slope) * 1.01 + 0x1p-24 * z;
    };
    const double clip = (f + n) / (f - n) * z - 2 * f * n / (f - n);  // OpenGL's, of -1 to 1
    CHECK(holds(StoredDepth::perspective(n, f), 0.5 * clip / z + 0.5));
    CHECK(holds(StoredDepth::perspective(n, f), (f * z - n * f) / ((f - n) * z)));  // Vulkan's
    CHECK(holds(StoredDepth::perspective(f, n), (n * f - n * z) / ((f - n) * z)));  // reversed
    CHECK(holds(StoredDepth::perspective(infinity, n), n / z));
    CHECK(holds(StoredDepth::perspective(n, infinity), 1 - n / z));
    CHECK(holds(StoredDepth::orthographic(n, f), (z - n) / (f - n)));
    CHECK(StoredDepth().depth(float(z)) == float(z));
  }
  CHECK(StoredDepth::perspective(n, infinity).depth(1) == infinity);
  CHECK(StoredDepth::perspective(infinity, n).depth(0) == infinity);
  CHECK(StoredDepth::perspective(infinity, n).depth(not_a_number) == infinity);
  CHECK(StoredDepth::perspective(n, infinity).depth(1.5f) == infinity);  // behind infinity
  CHECK(StoredDepth().depth(-1) == -1);
  CHECK(StoredDepth().depth(infinity) == infinity);
  CHECK(StoredDepth().depth(-infinity) == -infinity);
  CHECK(std::isnan(StoredDepth().depth(not_a_number)));  // hides nothing, as it compares with nothing
  CHECK(StoredDepth::orthographic(0, 2).depth(0) == 0);
  CHECK(StoredDepth::orthographic(-10, 10).depth(0.25f) == -5);  // before all splats
}

SWIFTGS_CONTRACT("frame: a depth buffer hides the same splats as its depths") {
  const int width = 53, height = 37;
  const Camera camera = forward_camera(width, height);
  const Scene all = random_scene(800, 0, 10);
  const StoredDepth all_stored[] = {
      StoredDepth::perspective(0.5, 40), StoredDepth::perspective(infinity, 0.5),
      StoredDepth::perspective(0.5, infinity), StoredDepth::orthographic(0, 12)};
  std::vector<float> values, depths(std::size_t(width) * height);
  for (std::size_t i = 0; i < depths.size(); ++i) values.push_back(float(i % 97) / 96);
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view) {
    const auto scene = renderer.backend().upload(all);
    for (const StoredDepth& stored : all_stored) {
      std::transform(values.begin(), values.end(), depths.begin(),
                     [&](float value) { return stored.depth(value); });
      CHECK(same_planes(render_before(renderer, scene.view(), camera, values, width, stored),
                        render_before(renderer, scene.view(), camera, depths, width)));
    }
  });
}

SWIFTGS_CONTRACT("frame: each pixel is hidden by its own depth") {
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
      render_reference(all, camera, Conventions::gsplat(), vec3(0.1f, 0.2f, 0.3f), 0, span_of(tight));
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view raster) {
    const auto scene = renderer.backend().upload(all);
    const Frame frame = render_before(renderer, scene.view(), camera, occluder, pitch);
    check_near<B>(raster, frame, reference);
    std::size_t different = 0;
    for (std::size_t k = 0; k < std::size(depths); ++k)
      for_each_plane(
          [&](std::size_t channels, const auto& plane, const auto& even) {
            for (std::size_t i = 0; i < plane.size(); ++i) {
              const std::size_t y = i / channels / width, x = i / channels % width;
              different += (x + 3 * y) % std::size(depths) == k && plane[i] != even[i];
            }
          },
          frame, render_before(renderer, scene.view(), camera, depths[k]));
    CHECK(different == 0);
  });
}

SWIFTGS_CONTRACT("frame: a surface at the depth of a splat hides it") {
  SplatSet splats;
  for (int i = 0; i < 1000; ++i) splats.add(make_splat(16, 8, 500, 500, 0, 0.01), 1.0f + float(i));
  Picture<B> picture(backend, splats, 32, 16, {.occluder = std::vector<float>(32 * 16, 4.0f)});
  with_each_raster<B>([&](const BoundRaster<B>& raster) {
    picture.draw(raster, {});
    CHECK(picture.counted.contributing_pairs == 2 * 3 * 256);
    CHECK(picture.counted.pixels_stopped == 2 * 256);
    CHECK(picture.counted.intersections_visited >= 2 * 4);
    CHECK(picture.counted.intersections_visited <= 2 * 64);  // a backend may look at lists in batches
  });
}

SWIFTGS_CONTRACT("frame: rows of each plane may go up in memory") {
  const int width = 37, height = 21;
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view) {
    const auto scene = renderer.backend().upload(with_features(random_scene(300, 1, 12), 4));
    const auto draw = [&](PlanesMemory& memory, bool over) {
      PlacedFrame<B> placed(renderer.backend(), memory);
      FrameView frame = placed.frame();
      frame.over = over;
      renderer.render_into(scene.view(), forward_camera(width, height), striking_background(), frame);
      placed.finish(renderer.backend());
    };
    check_directions(width, height, draw);
    check_directions(width, height, draw, all_planes(4));
  });
}

TEST_CASE("frame: a view asks for what its frame has memory for and else for its request") {
  float depth = 0;
  for (const Outputs& outputs : each_plane(2)) {
    const Request request = Request::planes_of(outputs);
    for_each_plane([](std::size_t, bool asked, const auto& wanted) { CHECK(asked == bool(wanted)); },
                   request.planes(), outputs);
    View view{.request = request};
    CHECK(view.asked() == request);
    Frame frame;
    view.frame = prepare(frame, 4, 3, outputs), view.request = {.occluder = true};
    CHECK(view.asked() == request);
    view.frame.occluder.data = &depth;
    CHECK(view.asked() != request);
    CHECK(view.asked().occluder);
  }
}

TEST_CASE("frame: planes that cannot be written are refused in words") {
  Renderer<Serial, EarlySort, PerPixel, Ellipse> renderer;
  const Scene scene = with_features(random_scene(10, 0, 11), 3);
  std::vector<float> memory(4 * 40 * 30);
  const auto accepts = [&](FrameView frame) {
    frame.width = 40, frame.height = 30;
    renderer.render_into(view(scene), forward_camera(40, 30), {}, frame);
  };
  const auto refuses = [&](const FrameView& frame, const std::string& message) {
    CHECK_THROWS_WITH_AS(accepts(frame), doctest::Contains(message.c_str()), std::invalid_argument);
  };
  using enum PixelFormat;
  const auto colour = [&](PixelFormat format, std::ptrdiff_t pitch) {
    return FrameView{.colour = {memory.data(), pitch}, .format = format};
  };
  refuses(colour(rgb_float, 479), "colour is 479 bytes, expected at least 480 up or down, a multiple of 4");
  refuses(colour(rgb_float, -476), "colour is -476 bytes, expected at least 480 up or down, a multiple of 4");
  refuses(colour(rgb_float, -482), "colour is -482 bytes, expected at least 480 up or down, a multiple of 4");
  refuses(colour(rgba_float, 642), "colour is 642 bytes, expected at least 640 up or down, a multiple of 4");
  refuses(colour(rgba_half, 323), "colour is 323 bytes, expected at least 320 up or down, a multiple of 2");
  refuses(colour(rgba_8, 159), "colour is 159 bytes, expected at least 160 up or down, a multiple of 1");
  refuses({.occluder = {memory.data(), 156}}, "occluder is 156 bytes");
  for (const StoredDepth& stored : {StoredDepth::perspective(2, 2), StoredDepth::perspective(0, 1)})
    refuses({.stored_depth = stored}, "expected stored depths that are finite and differ");
  refuses({.over = true}, "expected colour to render over");
  const auto check = [&](const PlaneRow& plane) {
    const std::string name = plane.name;
    CAPTURE(name);
    const std::ptrdiff_t least = 160 * (plane.channels != 0 ? plane.channels : 2);
    const auto frame = [&](std::ptrdiff_t pitch, std::size_t off = 0) {
      FrameView out{.feature_channels = 2};
      unsigned char* const bytes = reinterpret_cast<unsigned char*>(memory.data()) + off;
      for_each_plane(
          [&]<class T>(std::size_t, Plane<T>& to, const PlaneRow& row) {
            if (row.name == name) to = {reinterpret_cast<T*>(bytes), pitch};
          },
          out, plane_table);
      return out;
    };
    CHECK_NOTHROW(accepts(frame(least)));
    for (const std::ptrdiff_t pitch : {least - 4, least + 2, -least + 4})
      refuses(frame(pitch), "the pitch of " + name + " is " + std::to_string(pitch) +
                                " bytes, expected at least " + std::to_string(least));
    refuses(frame(least, 2), "render: expected " + name + " aligned to 4 bytes");
  };
  for_each_plane([&](std::size_t, const PlaneRow& row) { check(row); }, plane_table);
  for (const int channels : {0, -1})
    refuses({.features = {memory.data(), 160}, .feature_channels = channels},
            "render: expected a frame with features to say how many channels");
  CHECK_NOTHROW(accepts(colour(rgb_float, 480)));
  CHECK_NOTHROW(accepts({.colour = {memory.data() + 29 * 120, -480}}));
  CHECK_NOTHROW(accepts(colour(rgba_half, 322)));
  CHECK_NOTHROW(accepts(colour(rgba_8, 161)));
  // No memory is so large that 30 rows may lie as far apart; the least number has no magnitude of its type.
  const std::ptrdiff_t most = std::numeric_limits<std::ptrdiff_t>::max() / 30;
  for (const std::ptrdiff_t pitch : {-most - 1, most + 1, std::numeric_limits<std::ptrdiff_t>::min(),
                                     std::numeric_limits<std::ptrdiff_t>::max()})
    CHECK_THROWS_AS(accepts({.alpha = {memory.data(), pitch}}), std::invalid_argument);
}

TEST_CASE("frame: channels of 8 bits lie in memory in the order that their format names") {
  using Bytes = std::array<unsigned char, 4>;
  const auto bytes_of = [](PixelFormat format) {
    Image image(1, 1, format);
    image.set(0, 0, {1, 0.6f, 0, 0.2f});
    CHECK(image.at(0, 0) == vec4(255, 153, 0, 51) * (1.0f / 255));
    return Bytes{image.bytes[0], image.bytes[1], image.bytes[2], image.bytes[3]};
  };
  CHECK(bytes_of(PixelFormat::rgba_8) == Bytes{255, 153, 0, 51});
  CHECK(bytes_of(PixelFormat::bgra_8) == Bytes{0, 153, 255, 51});
}

}  // namespace swiftgs::test::frame_test
