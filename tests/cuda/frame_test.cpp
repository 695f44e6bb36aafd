// SPDX-License-Identifier: Apache-2.0

// Planes, pixel formats, composition and occluders in the memory of a device.
#include <algorithm>
#include <cmath>
#include <limits>

#include "cuda/drawings.hpp"
#include "policies/images.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// An image of the host drawn by the device into memory of its own.
template <class Raster>
Image draw_image(Cuda& cuda, const Picture& picture, Image image, bool over) {
  DevicePicture device(picture);
  DeviceBuffer<unsigned char> bytes = to_device(image.bytes);
  FrameView frame = image.frame();
  frame.colour.data = bytes.data(), frame.over = over;
  rasterize(cuda, Raster{}, device.job(frame, false));
  image.bytes = to_host(cuda, std::as_const(bytes).span());
  return image;
}

/// Brighter than 8 bits hold, darker, and no part of the opacity.
DrawSettings striking_background() {
  DrawSettings settings;
  settings.background = vec3(0.3f, 1.7f, -0.4f);
  return settings;
}

}  // namespace

TEST_CASE("cuda frame: each pixel format holds the same frame as far as it carries") {
  if (without_device()) return;
  Cuda cuda;
  for (const auto& [width, height] : {std::pair{37, 21}, {16, 16}, {1, 1}, {70, 5}}) {
    const Picture picture(usual_splats(300, width, height, 5), width, height, striking_background());
    for_each_raster([&, w = width, h = height]<class Raster>(Raster) {
      CAPTURE(Raster::name);
      const Drawing plain = draw_on_device<Raster>(cuda, picture);
      Image floats(w, h, PixelFormat::rgba_float);
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x)
          floats.set(
              x, y, {plain.colour(x, y, 0), plain.colour(x, y, 1), plain.colour(x, y, 2), plain.alpha(x, y)});
      for (const PixelFormat format : pixel_formats) {
        CAPTURE(int(format));
        const Image drawn = draw_image<Raster>(cuda, picture, Image(w, h, format), false);
        CHECK(same_bits(drawn.bytes, converted(floats, format).bytes));
        CHECK(drawn.kept_to_its_rows());
      }
    });
  }
}

TEST_CASE("cuda frame: what lies below is seen as far as transmittance is left") {
  if (without_device()) return;
  Cuda cuda;
  const int width = 37, height = 21;
  const Picture picture(usual_splats(60, width, height, 6), width, height);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing alone = draw_on_device<Raster>(cuda, picture);
    for (const PixelFormat format : pixel_formats) {
      CAPTURE(int(format));
      Image below = pattern(width, height, format);
      Image above = draw_image<Raster>(cuda, picture, below, true);
      Image floats = draw_image<Raster>(cuda, picture, converted(below, PixelFormat::rgba_float), true);
      CHECK(above.kept_to_its_rows());
      CHECK(same_bits(above.bytes, converted(floats, format).bytes));
      double worst = 0;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          for (int c = 0; c < 4; ++c) {
            const double alpha = double(alone.alpha(x, y)),
                         own = c < 3 ? double(alone.colour(x, y, c)) : alpha;
            const double expected = own + (1 - alpha) * double(below.at(x, y)[c]);
            worst = std::max(worst, std::abs(double(floats.at(x, y)[c]) - expected));
          }
      CHECK(worst < 1e-6);
    }
  });
}

TEST_CASE("cuda frame: rows may lie further apart than their pixels need") {
  if (without_device()) return;
  Cuda cuda;
  const Picture picture(usual_splats(200, 37, 21, 14), 37, 21);
  DevicePicture device(picture);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Frame tight = draw_on_device<Raster>(cuda, picture).frame;
    DeviceFrame frame(37, 21, PixelFormat::rgb_float, 52);
    rasterize(cuda, Raster{}, device.job(frame.view(), false));
    CHECK(same_bits(frame.pixels(cuda, frame.colour, 12), tight.colour));
    CHECK(same_bits(frame.pixels(cuda, frame.alpha, 4), tight.alpha));
    CHECK(same_bits(frame.pixels(cuda, frame.depth, 4), tight.depth));
    CHECK(frame.kept_to_its_rows(cuda, frame.colour, 12));
    CHECK(frame.kept_to_its_rows(cuda, frame.alpha, 4));
    CHECK(frame.kept_to_its_rows(cuda, frame.depth, 4));
  });
}

TEST_CASE("cuda frame: each plane alone is the same as with the others and none may be there") {
  if (without_device()) return;
  Cuda cuda;
  const Picture picture(usual_splats(200, 50, 30, 15), 50, 30);
  DevicePicture device(picture);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Frame all = draw_on_device<Raster>(cuda, picture).frame;
    DeviceFrame planes(50, 30);
    const FrameView whole = planes.view();
    const auto run = [&](const auto& keep) {
      FrameView frame{.width = 50, .height = 30};
      keep(frame);
      rasterize(cuda, Raster{}, device.job(frame, false));
    };
    run([](FrameView&) {});
    run([&](FrameView& frame) { frame.colour = whole.colour; });
    run([&](FrameView& frame) { frame.alpha = whole.alpha; });
    run([&](FrameView& frame) { frame.depth = whole.depth; });
    CHECK(same_bits(planes.pixels(cuda, planes.colour, 12), all.colour));
    CHECK(same_bits(planes.pixels(cuda, planes.alpha, 4), all.alpha));
    CHECK(same_bits(planes.pixels(cuda, planes.depth, 4), all.depth));
  });
}

TEST_CASE("cuda frame: splats behind the caller's surface are hidden as on the serial backend") {
  if (without_device()) return;
  Cuda cuda;
  Picture picture(usual_splats(1500, 70, 45, 16), 70, 45, striking_background());
  const float depths[] = {3, NAN, 1.5f, 0, 7, infinity, 5, 12};
  for (std::size_t i = 0; i < 70 * 45; ++i)
    picture.occluder.push_back(depths[(i + i / 70 * 3) % std::size(depths)]);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing expected = draw_on_host<Raster>(picture), drawn = draw_on_device<Raster>(cuda, picture);
    REQUIRE(expected.counts.pixels_stopped > 1000);
    const double share = stores_half<Raster> ? 0.05 : 0.001;
    const Difference colour = difference(drawn.frame.colour, expected.frame.colour, 2e-5);
    CHECK(colour.largest < 0.011 * 1.7);  // through it the background is seen
    CHECK(colour.part_above <= share);
    CHECK(difference(drawn.frame.depth, expected.frame.depth, 1e-3).part_above <= share);
    CHECK(double(drawn.counts.pixels_stopped) ==
          doctest::Approx(double(expected.counts.pixels_stopped)).epsilon(1e-2));
  });
}

TEST_CASE("cuda frame: a surface hides what lies at its depth and nothing where it is nowhere") {
  if (without_device()) return;
  Cuda cuda;
  SplatSet splats;
  for (const float depth : {1.0f, 2.0f, 3.0f}) splats.add(make_splat(8.5, 8.5, 30, 30, 0, 0.5), depth);
  Picture picture(splats, 16, 16);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const auto alpha_before = [&](float depth) {
      picture.occluder.assign(256, depth);
      return draw_on_device<Raster>(cuda, picture).alpha(8, 8);
    };
    CHECK(alpha_before(0.5f) == 0);
    CHECK(alpha_before(1) == 0);
    CHECK(alpha_before(2) == doctest::Approx(0.5).epsilon(1e-6));
    CHECK(alpha_before(3) == doctest::Approx(0.75).epsilon(1e-6));
    picture.occluder.clear();
    const Frame alone = draw_on_device<Raster>(cuda, picture).frame;
    for (const float nowhere : {infinity, NAN, 1e20f}) {
      picture.occluder.assign(256, nowhere);
      const Frame frame = draw_on_device<Raster>(cuda, picture).frame;
      CHECK(same_bits(frame.colour, alone.colour));
      CHECK(same_bits(frame.depth, alone.depth));
    }
  });
}
