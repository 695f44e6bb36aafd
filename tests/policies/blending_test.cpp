// SPDX-License-Identifier: Apache-2.0

// What every rasterizer draws on every backend. Where SWIFTGS_TEST_RASTER_PIXELS is defined, a device draws
// by the form of rasterizers without kernels of their own.
#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "policies/double_drawing.hpp"

namespace swiftgs::test::blending_test {

namespace {

#if defined(SWIFTGS_TEST_RASTER_PIXELS)
#define SWIFTGS_BLENDING(sentence) SWIFTGS_CASE_ON("raster pixels: " sentence, swiftgs::Cuda)

/// The library's rasterizer, as one that has no kernel of its own.
template <class Raster>
struct Tested {
  static constexpr std::string_view name = Raster::name;
  using Kernel = typename Raster::Kernel;
};
#else
#define SWIFTGS_BLENDING(sentence) SWIFTGS_CONTRACT("blend: " sentence)

template <class Raster>
using Tested = Raster;
#endif

template <class B, class F>
void with_each(const F& f) {
  with_each_raster<B, Tested>(f);
}
/// Of long lists, for which `Vulkan` has more shaders.
template <class B, class F>
void with_some(const F& f) {
  with_each_raster<B, Tested, SomeRastersOf<B>>(f);
}

/// How much more than a host a backend may differ from double. A device differs from `Serial` by as much as
/// that differs from double.
template <class B>
constexpr double slack = on_host<B> ? 1 : 2;

/// Thresholds that are powers of two, so that every arithmetic meets them exactly.
DrawSettings exact_settings(float stop, bool stop_at_equal) {
  Conventions conventions;
  conventions.alpha_min = 1.0f / 256, conventions.alpha_max = 1;
  conventions.stop = stop, conventions.stop_at_equal = stop_at_equal;
  DrawSettings settings;
  settings.rules = blend_rules(conventions);
  return settings;
}

/// A splat whose alpha at pixel (8, 8) is `opacity` to the last bit, for opacities that are powers of two.
void add_half_clear(SplatSet& splats, float depth, vec3 rgb = vec3(1), double opacity = 0.5) {
  splats.add(make_splat(8.5, 8.5, 3, 3, 0, opacity, 1.0 / 256), depth, rgb);
}
SplatSet five_half_clear() {
  SplatSet splats;
  for (int i = 0; i < 5; ++i) add_half_clear(splats, 1.0f + float(i));
  return splats;
}

}  // namespace

SWIFTGS_BLENDING("splats are laid over each other from the nearest to the farthest") {
  SplatSet splats;
  add_half_clear(splats, 4, {0, 1, 0});
  add_half_clear(splats, 2, {1, 0, 0}, 0.25);
  DrawSettings settings = exact_settings(1e-4f, true);
  settings.background = vec3(0, 0, 1);
  with_each<B>([&](const BoundRaster<B>& raster) {
    const Drawing drawing = draw(backend, raster, splats, 17, 17, settings);
    CHECK(drawing.colour(8, 8, 0) == doctest::Approx(0.25).epsilon(1e-6));
    CHECK(drawing.colour(8, 8, 1) == doctest::Approx(0.75 * 0.5).epsilon(1e-6));
    CHECK(drawing.colour(8, 8, 2) == doctest::Approx(0.75 * 0.5).epsilon(1e-6));
    CHECK(drawing.alpha(8, 8) == doctest::Approx(1 - 0.75 * 0.5).epsilon(1e-6));
    // The mean of 2 and 4, weighted 0.25 and 0.375.
    CHECK(drawing.depth(8, 8) == doctest::Approx(3.2).epsilon(1e-6));
  });
}

SWIFTGS_BLENDING("a pixel that nothing reaches shows the background and no alpha and no depth") {
  SplatSet none, far_off;
  far_off.add(make_splat(60, 60, 1, 1, 0, 0.9), 1);
  DrawSettings settings;
  settings.background = vec3(0.1f, 0.2f, 3.0f);
  with_each<B>([&](const BoundRaster<B>& raster) {
    for (const SplatSet* splats : {&none, &far_off}) {
      const Drawing drawing = draw(backend, raster, *splats, 40, 40, settings);
      for (const int at : {0, 39}) {
        for (int c = 0; c < 3; ++c) CHECK(drawing.colour(at, at, c) == settings.background[c]);
        CHECK(drawing.alpha(at, at) == 0);
        CHECK(drawing.depth(at, at) == 0);
      }
      CHECK(drawing.counts.contributing_pairs == 0);
    }
  });
}

SWIFTGS_BLENDING("a pixel ends before the splat that brings it to the limit or only below it") {
  with_each<B>([&](const BoundRaster<B>& raster) {
    const auto drawn = [&](float stop, bool at_equal) {
      const DrawSettings settings = exact_settings(stop, at_equal);
      const Drawing drawing = draw(backend, raster, five_half_clear(), 17, 17, settings);
      CHECK(drawing.colour(8, 8, 0) == drawing.alpha(8, 8));
      CHECK(draw(backend, raster, five_half_clear(), 17, 17, lean(settings)).alpha(8, 8) ==
            drawing.alpha(8, 8));
      return drawing;
    };
    const Drawing inclusive = drawn(0.25f, true), exclusive = drawn(0.25f, false);
    CHECK(inclusive.alpha(8, 8) == 0.5f);
    CHECK(exclusive.alpha(8, 8) == 0.75f);
    CHECK(inclusive.counts.contributing_pairs < exclusive.counts.contributing_pairs);
    // Where the limit is zero, of either sign, none ends.
    for (const float zero : {0.0f, -0.0f}) {
      CHECK(drawn(zero, false).alpha(8, 8) == 1 - 1.0f / 32);
      CHECK(drawn(zero, false).counts.pixels_stopped == 0);
    }
  });
}

SWIFTGS_BLENDING("a stopped pixel stays stopped though fainter splats follow") {
  for (const int before : {0, 1, 2, 3}) {  // places in a group
    CAPTURE(before);
    SplatSet splats;
    for (int i = 0; i < before; ++i) add_half_clear(splats, 0.1f, vec3(1), 1.0 / 256);
    // The second half would bring it to 1/4: it ends there. The others would not, were they asked.
    for (const double opacity : {0.5, 0.5, 1.0 / 64, 1.0 / 64, 1.0 / 64, 1.0 / 64, 1.0 / 64})
      add_half_clear(splats, float(splats.shapes.size() + 1), vec3(1), opacity);
    const DrawSettings settings = exact_settings(0.25f, true);
    const double expected = 1 - 0.5 * std::pow(1 - 1.0 / 256, before);
    with_each<B>([&](const BoundRaster<B>& raster) {
      for (const DrawSettings& each : {settings, lean(settings)})
        CHECK(draw(backend, raster, splats, 17, 17, each).alpha(8, 8) ==
              doctest::Approx(expected).epsilon(1e-6));
    });
  }
}

SWIFTGS_BLENDING("an opacity of exactly the threshold is kept at the centre alone and less is not") {
  const DrawSettings settings = exact_settings(1e-4f, true);
  SplatSet at_threshold;
  at_threshold.add(make_splat(8.5, 8.5, 4, 4, 0, 1.0 / 256, 1.0 / 256), 1);
  SplatSet below = at_threshold;
  below.shapes[0].opacity = std::nextafter(1.0f / 256, 0.0f), below.shapes[0].cutoff = -1e-7f;
  REQUIRE(at_threshold.shapes[0].cutoff == 0);
  with_each<B>([&](const BoundRaster<B>& raster) {
    const Drawing drawing = draw(backend, raster, at_threshold, 32, 32, settings);
    CHECK(drawing.alpha(8, 8) == 1.0f / 256);
    CHECK(drawing.counts.contributing_pairs == 1);
    CHECK(draw(backend, raster, below, 32, 32, settings).counts.contributing_pairs == 0);
  });
}

SWIFTGS_BLENDING("alpha is cut so that one opaque splat lets a hundredth through") {
  SplatSet splats;
  splats.add(make_splat(8.5, 8.5, 40, 40, 0, 1), 1);
  with_each<B>([&](const BoundRaster<B>& raster) {
    for (const DrawSettings& each : {DrawSettings(), lean()})
      CHECK(draw(backend, raster, splats, 16, 16, each).alpha(8, 8) == doctest::Approx(0.99).epsilon(1e-6));
  });
}

SWIFTGS_BLENDING("images of any size are those of double") {
  struct Size {
    int width, height;
  };
  for (const Size size : {Size{1, 1}, {15, 1}, {1, 17}, {16, 16}, {17, 33}, {23, 9}, {70, 45}, {200, 150}}) {
    CAPTURE(size.width);
    CAPTURE(size.height);
    const SplatSet splats = usual_splats(400, size.width, size.height, 11);
    DrawSettings settings;
    settings.background = vec3(0.3f, 0.2f, 0.1f);
    const DoubleDrawing exact = draw_in_double(splats, size.width, size.height, settings);
    with_each<B>([&](const BoundRaster<B>& raster) {
      const Drawing drawing = draw(backend, raster, splats, size.width, size.height, settings);
      const Drawing again = draw(backend, raster, splats, size.width, size.height, lean(settings));
      CHECK(same_bits(again.frame.colour, drawing.frame.colour));
      CHECK(same_bits(again.frame.alpha, drawing.frame.alpha));
      if (stores_half(raster.name)) return;
      // Rounding alone stays below 2e-5; a pixel at a threshold may gain or lose a splat: 0.011 at most.
      const Difference colour = difference(drawing.frame.colour, exact.colour, 2e-5 * slack<B>);
      CHECK(colour.largest < 0.011 * slack<B>);
      CHECK(colour.part_above < 0.002 * slack<B>);
      const Difference alpha = difference(drawing.frame.alpha, exact.alpha, 2e-5 * slack<B>);
      CHECK(alpha.part_above < 0.002 * slack<B>);
      const Difference depth = difference(drawing.frame.depth, exact.depth, 1e-3 * slack<B>);
      CHECK(depth.part_above < 0.002 * slack<B>);
    });
  }
}

SWIFTGS_BLENDING("half-split images are those of double as far as half carries") {
  const SplatSet splats = usual_splats(300, 128, 64, 12);
  const DoubleDrawing exact = draw_in_double(splats, 128, 64);
  with_each<B>([&](const BoundRaster<B>& raster) {
    if (!stores_half(raster.name)) return;
    const Difference colour =
        difference(draw(backend, raster, splats, 128, 64).frame.colour, exact.colour, 1e-4);
    CHECK(colour.largest < 0.011 * slack<B>);
    CHECK(colour.part_above > 0.01);  // or its terms are not stored as half at all
  });
}

SWIFTGS_BLENDING("what is counted is what double counts") {
  const SplatSet splats = usual_splats(1500, 100, 70, 13);
  const DoubleDrawing exact = draw_in_double(splats, 100, 70);
  REQUIRE(exact.pixels_stopped > 100);
  with_each<B>([&](const BoundRaster<B>& raster) {
    if (stores_half(raster.name)) return;
    const RasterCounts counts = draw(backend, raster, splats, 100, 70).counts;
    CHECK(double(counts.contributing_pairs) ==
          doctest::Approx(double(exact.contributing_pairs)).epsilon(1e-3 * slack<B>));
    CHECK(double(counts.pixels_stopped) ==
          doctest::Approx(double(exact.pixels_stopped)).epsilon(1e-2 * slack<B>));
  });
}

SWIFTGS_BLENDING("colours may be as large as floats are") {
  const SplatSet splats = usual_splats(500, 70, 45, 13);
  SplatSet bright = splats, brightest = splats;
  for (SplatColour& colour : bright.colours) colour.rgb *= 0x1p20f;
  for (SplatColour& colour : brightest.colours) colour.rgb = vec3(3e38f);
  with_each<B>([&](const BoundRaster<B>& raster) {
    const Frame usual = draw(backend, raster, splats, 70, 45).frame;
    Frame scaled = draw(backend, raster, bright, 70, 45).frame;
    for (float& value : scaled.colour) value *= 0x1p-20f;
    CHECK(difference(scaled.colour, usual.colour, 0).largest < 1e-6);
    const Frame largest = draw(backend, raster, brightest, 70, 45, lean()).frame;
    CHECK(std::all_of(largest.colour.begin(), largest.colour.end(),
                      [](float v) { return v >= 0 && v < 3.1e38f; }));
  });
}

SWIFTGS_BLENDING("tiles of any side give the same bits") {
  const SplatSet splats = random_splats(1000, 200, 150, 31);
  with_each<B>([&](const BoundRaster<B>& raster) {
    const Drawing usual = draw(backend, raster, splats, 200, 150);
    for (const int side : {32, 64, 512}) {
      CAPTURE(side);
      const Drawing drawn = draw(backend, raster, splats, 200, 150, {}, side);
      CHECK(same_planes(drawn.frame, usual.frame));
      CHECK(drawn.counts.contributing_pairs == usual.counts.contributing_pairs);
      CHECK(drawn.counts.intersections_visited >= usual.counts.intersections_visited);
      CHECK(
          same_bits(draw(backend, raster, splats, 200, 150, lean(), side).frame.colour, usual.frame.colour));
    }
  });
}

namespace {

/// Checks one rasterizer against `Serial`, with depth and counts and without. Returns the pixels that stop.
template <class B>
std::uint64_t check_against_serial(B& backend, const BoundRaster<B>& raster, const SplatSet& splats,
                                   int width, int height, const DrawSettings& settings = {}) {
  CAPTURE(raster.name);
  Serial serial;
  const Drawing expected = draw(serial, raster.on_serial, splats, width, height, settings);
  const Drawing drawn = draw(backend, raster, splats, width, height, settings);
  // Of half terms a few round to the other side, for which no more than their share of the pixels differs.
  const double share = !stores_half(raster.name) ? 0.001 : width * height > 1000 ? 0.05 : 1;
  // A threshold may fall differently: for a splat at alpha 1/255, or for one before which a pixel ends.
  const Difference colour = difference(drawn.frame.colour, expected.frame.colour, 2e-5);
  const Difference alpha = difference(drawn.frame.alpha, expected.frame.alpha, 2e-5);
  for (const Difference& plane : {colour, alpha}) {
    CHECK(plane.largest < 0.011);
    CHECK(plane.part_above <= share);
  }
  CHECK(difference(drawn.frame.depth, expected.frame.depth, 1e-3).part_above <= share);

  const RasterCounts &counts = drawn.counts, &by_serial = expected.counts;
  CHECK(
      double(counts.contributing_pairs) ==
      doctest::Approx(double(by_serial.contributing_pairs)).epsilon(stores_half(raster.name) ? 1e-2 : 1e-3));
  CHECK(std::abs(double(counts.pixels_stopped) - double(by_serial.pixels_stopped)) <=
        1 + 1e-2 * double(by_serial.pixels_stopped));
  CHECK(counts.intersections_visited <=
        build_lists<StandardSort, OpacityBox>(serial, splats.job(width, height)).intersections);
#if defined(SWIFTGS_TEST_RASTER_PIXELS)
  // The same traversal: it ends elsewhere only where a threshold falls differently.
  CHECK(double(counts.intersections_visited) ==
        doctest::Approx(double(by_serial.intersections_visited)).epsilon(1e-2));
  CHECK(double(counts.rows_visited) == doctest::Approx(double(by_serial.rows_visited)).epsilon(1e-2));
#else
  CHECK(counts.intersections_visited >= by_serial.intersections_visited);
#endif
  const Frame again = draw(backend, raster, splats, width, height, lean(settings)).frame;
  CHECK(same_bits(again.colour, drawn.frame.colour));
  CHECK(same_bits(again.alpha, drawn.frame.alpha));
  return by_serial.pixels_stopped;
}

/// Splats that each cover 16 x 16 pixels and are faint, so that many are blended.
SplatSet veils(int count, double opacity) {
  SplatSet splats;
  Random random(31);
  for (int i = 0; i < count; ++i)
    splats.add(make_splat(random.in(0, 16), random.in(0, 16), 40, 30, random.in(0, 3), opacity),
               1.0f + float(i), vec3(random.f(0, 1), random.f(0, 1), random.f(0, 1)));
  return splats;
}

}  // namespace

SWIFTGS_BLENDING("images of many splats are those of Serial with either rule of stopping") {
  for (const Conventions& conventions : {Conventions::gsplat(), Conventions::inria()})
    with_some<B>([&](const BoundRaster<B>& raster) {
      CHECK(check_against_serial(backend, raster, usual_splats(6000, 200, 150, 12), 200, 150,
                                 {.rules = blend_rules(conventions)}) > 1000);
    });
}

SWIFTGS_BLENDING("lists of every length are blended to their end") {
  Serial serial;
  for (const int count : {0, 1, 3, 4, 5, 7, 8, 9, 31, 32, 33, 63, 64, 65, 255, 256, 257, 511, 513, 1500}) {
    CAPTURE(count);
    const SplatSet splats = veils(count, 1.5 / 255);
    REQUIRE(build_lists<StandardSort, OpacityBox>(serial, splats.job(16, 16)).intersections ==
            std::size_t(count));
    with_each<B>(
        [&](const BoundRaster<B>& raster) { check_against_serial(backend, raster, splats, 16, 16); });
  }
}

SWIFTGS_BLENDING("pixels stop at every place of a list") {
  for (int count = 1; count < 80; count += count < 12 ? 1 : 7) {
    CAPTURE(count);
    // Faint splats, then opaque ones that end the pixel in the middle of a group, then more that must not
    // show.
    SplatSet splats = veils(count, 0.02);
    for (int i = 0; i < 4; ++i)
      splats.add(make_splat(8, 8, 300, 300, 0, 0.99), float(500 + i), vec3(1, 0, 0));
    for (int i = 0; i < 40; ++i)
      splats.add(make_splat(8, 8, 300, 300, 0, 0.5), float(600 + i), vec3(0, 0, 1));
    with_each<B>([&](const BoundRaster<B>& raster) {
      CHECK(check_against_serial(backend, raster, splats, 16, 16) == 256);
    });
  }
}

#if !defined(SWIFTGS_TEST_RASTER_PIXELS)
SWIFTGS_CASE_ON("blend: lists of another number than the frame's tiles are refused", SWIFTGS_TEST_HOSTS) {
  std::vector<float> alpha(64 * 48);
  const std::vector<TileRange> ranges(12);
  for (const int side : {16, 32}) {
    const View view = view_into({.width = 64, .height = 48, .alpha = {alpha.data(), 256}}, {}, side);
    const auto draw_lists = [&] {
      rasterize(backend, PerPixel(), RasterJob{{}, {}, {{}, {ranges.data(), ranges.size()}}, {&view, 1}});
    };
    if (side == 16)
      CHECK_NOTHROW(draw_lists());
    else
      CHECK_THROWS_WITH_AS(
          draw_lists(),
          "rasterize: the number of lists is 12, expected a list for each of the frame's 4 tiles",
          std::invalid_argument);
  }
}
#endif

}  // namespace swiftgs::test::blending_test
