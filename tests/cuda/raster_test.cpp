// SPDX-License-Identifier: Apache-2.0

// Rasterizers on the device against the serial backend's, from the same splats and lists: the library's
// kernels, or the form of rasterizers without any where SWIFTGS_TEST_RASTER_PIXELS is defined.
#include <algorithm>
#include <cmath>
#include <utility>

#include "cuda/drawings.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

#if defined(SWIFTGS_TEST_RASTER_PIXELS)
#define SWIFTGS_RASTERS "cuda raster pixels"
constexpr bool own_kernels = false;

/// The library's rasterizer, as one that has no kernel of its own.
template <class Raster>
struct WithoutKernel {
  static constexpr std::string_view name = Raster::name;
  using Kernel = typename Raster::Kernel;
};

template <class F>
void for_each_tested(const F& f) {
  for_each_raster([&]<class Raster>(Raster) { f(WithoutKernel<Raster>()); });
}
#else
#define SWIFTGS_RASTERS "cuda raster"
constexpr bool own_kernels = true;

template <class F>
void for_each_tested(const F& f) {
  for_each_raster(f);
}
#endif

/// Largest difference where a threshold falls differently: a splat at alpha 1/255, or one before which a
/// pixel ends.
constexpr double crossing = 0.011;

/// Thresholds that are powers of two, so that every arithmetic meets them exactly.
DrawSettings exact_settings(float stop, bool stop_at_equal) {
  Conventions conventions;
  conventions.alpha_min = 1.0f / 256, conventions.alpha_max = 1;
  conventions.stop = stop, conventions.stop_at_equal = stop_at_equal;
  DrawSettings settings;
  settings.rules = BlendRules::from(conventions);
  return settings;
}

/// Checks both kinds of kernels against the serial backend; `brightest` is the largest channel of any splat.
template <class Raster>
void check_drawing(Cuda& cuda, const Picture& picture, double brightest = 1) {
  CAPTURE(Raster::name);
  CAPTURE(picture.width);
  CAPTURE(picture.height);
  const Drawing expected = draw_on_host<Raster>(picture), drawn = draw_on_device<Raster>(cuda, picture);
  // Of half terms a few round to the other side, for which no more than their share of the pixels differs.
  const double share = stores_half<Raster> ? (picture.width * picture.height > 1000 ? 0.05 : 1.0) : 0.001;
  const Difference colour = difference(drawn.frame.colour, expected.frame.colour, 2e-5 * brightest);
  CHECK(colour.largest < crossing * brightest);
  CHECK(colour.part_above <= share);
  const Difference alpha = difference(drawn.frame.alpha, expected.frame.alpha, 2e-5);
  CHECK(alpha.largest < crossing);
  CHECK(alpha.part_above <= share);
  CHECK(difference(drawn.frame.depth, expected.frame.depth, 1e-3).part_above <= share);

  const double tolerance = stores_half<Raster> ? 1e-2 : 1e-3;
  CHECK(double(drawn.counts.contributing_pairs) ==
        doctest::Approx(double(expected.counts.contributing_pairs)).epsilon(tolerance));
  CHECK(std::abs(double(drawn.counts.pixels_stopped) - double(expected.counts.pixels_stopped)) <=
        1 + 1e-2 * double(expected.counts.pixels_stopped));
  CHECK(drawn.counts.intersections_visited <= picture.lists.ids.size());
  if (own_kernels) {
    CHECK(drawn.counts.intersections_visited >= expected.counts.intersections_visited);
  } else {
    // The same traversal: it ends elsewhere only where a threshold falls differently.
    CHECK(double(drawn.counts.intersections_visited) ==
          doctest::Approx(double(expected.counts.intersections_visited)).epsilon(1e-2));
    CHECK(double(drawn.counts.rows_visited) ==
          doctest::Approx(double(expected.counts.rows_visited)).epsilon(1e-2));
  }

  const Drawing lean = draw_on_device<Raster>(cuda, picture, true);
  CHECK(same_bits(lean.frame.colour, drawn.frame.colour));
  CHECK(same_bits(lean.frame.alpha, drawn.frame.alpha));
}

void check_all(const Picture& picture, double brightest = 1) {
  Cuda cuda;
  for_each_tested([&]<class Raster>(Raster) { check_drawing<Raster>(cuda, picture, brightest); });
}

/// Splats that each cover the image and are faint, so that many are blended.
SplatSet veils(int count, double opacity) {
  SplatSet splats;
  Random random(31);
  for (int i = 0; i < count; ++i)
    splats.add(make_splat(random.in(0, 16), random.in(0, 16), 40, 30, random.in(0, 3), opacity),
               1.0f + float(i), vec3(random.f(0, 1), random.f(0, 1), random.f(0, 1)));
  return splats;
}

}  // namespace

TEST_CASE(SWIFTGS_RASTERS ": images of any size are the serial backend's") {
  if (without_device()) return;
  struct Size {
    int width, height;
  };
  DrawSettings settings;
  settings.background = vec3(0.3f, 0.2f, 0.1f);
  for (const Size size : {Size{1, 1}, {15, 1}, {1, 17}, {16, 16}, {17, 33}, {23, 9}, {70, 45}, {200, 150}})
    check_all(Picture(usual_splats(400, size.width, size.height, 11), size.width, size.height, settings));
}

TEST_CASE(SWIFTGS_RASTERS ": images of many splats are the serial backend's with either rule of stopping") {
  if (without_device()) return;
  for (const bool inria : {false, true}) {
    CAPTURE(inria);
    DrawSettings settings;
    settings.rules = BlendRules::from(inria ? Conventions::inria() : Conventions::gsplat());
    const Picture picture(usual_splats(6000, 200, 150, 12), 200, 150, settings);
    REQUIRE(draw_on_host<PerPixel>(picture).counts.pixels_stopped > 1000);
    check_all(picture);
  }
}

TEST_CASE(SWIFTGS_RASTERS ": lists of every length are blended to their end") {
  if (without_device()) return;
  for (const int count : {0, 1, 3, 4, 5, 7, 8, 9, 31, 32, 33, 63, 64, 65, 255, 256, 257, 511, 513, 1500}) {
    CAPTURE(count);
    const Picture picture(veils(count, 1.5 / 255), 16, 16);
    REQUIRE(picture.lists.ids.size() == std::size_t(count));
    check_all(picture);
  }
}

TEST_CASE(SWIFTGS_RASTERS ": pixels stop at every place of a list") {
  if (without_device()) return;
  for (int count = 1; count < 80; count += count < 12 ? 1 : 7) {
    CAPTURE(count);
    // Faint splats, then opaque ones that end the pixel in the middle of a group, then more that must not
    // show.
    SplatSet splats = veils(count, 0.02);
    for (int i = 0; i < 4; ++i)
      splats.add(make_splat(8, 8, 300, 300, 0, 0.99), float(500 + i), vec3(1, 0, 0));
    for (int i = 0; i < 40; ++i)
      splats.add(make_splat(8, 8, 300, 300, 0, 0.5), float(600 + i), vec3(0, 0, 1));
    const Picture picture(std::move(splats), 16, 16);
    REQUIRE(draw_on_host<PerPixel>(picture).counts.pixels_stopped == 256);
    check_all(picture);
  }
}

TEST_CASE(SWIFTGS_RASTERS ": a pixel ends before the splat that brings it to the limit or only below it") {
  if (without_device()) return;
  Cuda cuda;
  SplatSet splats;
  for (int i = 0; i < 5; ++i) splats.add(make_splat(8.5, 8.5, 3, 3, 0, 0.5, 1.0 / 256), 1.0f + float(i));
  const Picture inclusive(splats, 17, 17, exact_settings(0.25f, true));
  const Picture exclusive(splats, 17, 17, exact_settings(0.25f, false));
  for_each_tested([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    for (const bool lean : {false, true}) {
      CAPTURE(lean);
      CHECK(draw_on_device<Raster>(cuda, inclusive, lean).alpha(8, 8) == 0.5f);
      CHECK(draw_on_device<Raster>(cuda, inclusive, lean).colour(8, 8, 0) == 0.5f);
      CHECK(draw_on_device<Raster>(cuda, exclusive, lean).alpha(8, 8) == 0.75f);
      CHECK(draw_on_device<Raster>(cuda, exclusive, lean).colour(8, 8, 0) == 0.75f);
    }
  });
}

TEST_CASE(SWIFTGS_RASTERS ": a stopped pixel stays stopped though fainter splats follow") {
  if (without_device()) return;
  Cuda cuda;
  for (const int before : {0, 1, 2, 3}) {  // places in a group
    CAPTURE(before);
    SplatSet splats;
    for (int i = 0; i < before; ++i) splats.add(make_splat(8.5, 8.5, 3, 3, 0, 1.0 / 256, 1.0 / 256), 0.1f);
    for (const double opacity : {0.5, 0.5, 1.0 / 64, 1.0 / 64, 1.0 / 64, 1.0 / 64, 1.0 / 64})
      splats.add(make_splat(8.5, 8.5, 3, 3, 0, opacity, 1.0 / 256), float(splats.shapes.size() + 1));
    const Picture picture(splats, 17, 17, exact_settings(0.25f, true));
    for_each_tested([&]<class Raster>(Raster) {
      CAPTURE(Raster::name);
      const float expected = draw_on_host<Raster>(picture).alpha(8, 8);
      for (const bool lean : {false, true})
        CHECK(draw_on_device<Raster>(cuda, picture, lean).alpha(8, 8) ==
              doctest::Approx(expected).epsilon(1e-6));
    });
  }
}

TEST_CASE(SWIFTGS_RASTERS
          ": an opacity of exactly the threshold is kept at the centre alone and less is not") {
  if (without_device()) return;
  Cuda cuda;
  const DrawSettings settings = exact_settings(1e-4f, true);
  SplatSet at_threshold, below;
  at_threshold.add(make_splat(8.5, 8.5, 4, 4, 0, 1.0 / 256, 1.0 / 256), 1);
  below = at_threshold;
  below.shapes[0].opacity = std::nextafter(1.0f / 256, 0.0f), below.shapes[0].cutoff = -1e-7f;
  REQUIRE(at_threshold.shapes[0].cutoff == 0);
  for_each_tested([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    Picture picture(at_threshold, 32, 32, settings);
    CHECK(draw_on_device<Raster>(cuda, picture).alpha(8, 8) == 1.0f / 256);
    CHECK(draw_on_device<Raster>(cuda, picture).counts.contributing_pairs == 1);
    picture.splats = below;
    CHECK(draw_on_device<Raster>(cuda, picture).counts.contributing_pairs == 0);
  });
}

TEST_CASE(SWIFTGS_RASTERS ": alpha is cut so that one opaque splat lets a hundredth through") {
  if (without_device()) return;
  Cuda cuda;
  SplatSet splats;
  splats.add(make_splat(8.5, 8.5, 40, 40, 0, 1), 1);
  const Picture picture(splats, 16, 16);
  for_each_tested([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    CHECK(draw_on_device<Raster>(cuda, picture).alpha(8, 8) == doctest::Approx(0.99).epsilon(1e-6));
    check_drawing<Raster>(cuda, picture);
  });
}

TEST_CASE(SWIFTGS_RASTERS ": pixels that nothing reaches show the background and no alpha and no depth") {
  if (without_device()) return;
  Cuda cuda;
  DrawSettings settings;
  settings.background = vec3(0.1f, 0.2f, 3.0f);
  SplatSet far_off;
  far_off.add(make_splat(60, 60, 1, 1, 0, 0.9), 1);
  for (const SplatSet& splats : {SplatSet(), far_off})
    for_each_tested([&]<class Raster>(Raster) {
      CAPTURE(Raster::name);
      const Drawing drawing = draw_on_device<Raster>(cuda, Picture(splats, 40, 40, settings));
      for (const int at : {0, 39}) {
        for (int c = 0; c < 3; ++c) CHECK(drawing.colour(at, at, c) == settings.background[c]);
        CHECK(drawing.alpha(at, at) == 0);
        CHECK(drawing.depth(at, at) == 0);
      }
      CHECK(drawing.counts.contributing_pairs == 0);
    });
}

TEST_CASE(SWIFTGS_RASTERS ": colours may be as large as floats are") {
  if (without_device()) return;
  SplatSet splats = usual_splats(500, 70, 45, 13);
  for (SplatColour& colour : splats.colours) colour.rgb *= 1e6f;
  check_all(Picture(splats, 70, 45), 1e6);
  for (SplatColour& colour : splats.colours) colour.rgb = vec3(3e38f);
  Cuda cuda;
  for_each_tested([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing drawing = draw_on_device<Raster>(cuda, Picture(splats, 70, 45), true);
    CHECK(std::all_of(drawing.frame.colour.begin(), drawing.frame.colour.end(),
                      [](float v) { return v >= 0 && v < 3.1e38f; }));
  });
}

TEST_CASE(SWIFTGS_RASTERS ": needles and giants leave no pixel that is not a number") {
  if (without_device()) return;
  Cuda cuda;
  Random random(16);
  SplatSet needles = random_splats(500, 64, 64, 17);
  for (int i = 0; i < 300; ++i) {
    const double angle = random.in(0, 3.14159), away = random.in(-3000, 3000);
    needles.add(make_splat(32 + away * std::cos(angle), 32 + away * std::sin(angle), 4000, 0.6, angle, 0.9),
                random.f(1, 2));
  }
  const Picture picture(std::move(needles), 64, 64);
  for_each_tested([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    for (const bool lean : {false, true}) {
      const Frame frame = draw_on_device<Raster>(cuda, picture, lean).frame;
      CHECK(std::all_of(frame.colour.begin(), frame.colour.end(),
                        [](float v) { return v >= 0 && v <= 1.001f; }));
      CHECK(std::all_of(frame.alpha.begin(), frame.alpha.end(), [](float v) { return v >= 0 && v <= 1; }));
    }
  });
}

TEST_CASE(SWIFTGS_RASTERS ": conservative bounds draw the same bits of any splats") {
  if (without_device()) return;
  Cuda cuda;
  // Splats that barely reach the threshold are so large that a rounding of the exponent is pixels wide.
  Random random(5);
  SplatSet faint;
  for (int i = 0; i < 300; ++i) {
    const double along = random.scale(300, 3e4);
    faint.add(make_splat(random.in(0, 400), random.in(0, 300), along, along * random.scale(0.02, 1),
                         random.in(0, 3.14), (1 + random.scale(1e-6, 1e-2)) / 255),
              float(i + 1));
  }
  for (const SplatSet& splats : {random_splats(3000, 400, 300, 18), faint}) {
    Picture box(splats, 400, 300), ellipse(splats, 400, 300);
    ellipse.use_bounds(Ellipse());
    REQUIRE(ellipse.lists.ids.size() < box.lists.ids.size());
    for_each_tested([&]<class Raster>(Raster) {
      CAPTURE(Raster::name);
      const Frame a = draw_on_device<Raster>(cuda, box).frame,
                  b = draw_on_device<Raster>(cuda, ellipse).frame;
      CHECK(same_bits(a.colour, b.colour));
      CHECK(same_bits(a.alpha, b.alpha));
      CHECK(same_bits(a.depth, b.depth));
    });
  }
}

TEST_CASE(SWIFTGS_RASTERS ": tiles of any side give the same bits") {
  if (without_device()) return;
  Cuda cuda;
  Picture picture(random_splats(3000, 300, 200, 31), 300, 200);
  for_each_tested([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    picture.tile_side = default_tile_side;
    picture.use_bounds(Ellipse());
    const Drawing usual = draw_on_device<Raster>(cuda, picture);
    for (const int side : {32, 64, 512}) {
      CAPTURE(side);
      picture.tile_side = side;
      picture.use_bounds(Ellipse());
      const Drawing drawn = draw_on_device<Raster>(cuda, picture);
      CHECK(same_bits(drawn.frame.colour, usual.frame.colour));
      CHECK(same_bits(drawn.frame.alpha, usual.frame.alpha));
      CHECK(same_bits(drawn.frame.depth, usual.frame.depth));
      CHECK(same_bits(draw_on_device<Raster>(cuda, picture, true).frame.colour, usual.frame.colour));
    }
  });
}

namespace {

/// Balanced time over raster time of a counted frame.
template <class Raster>
double evenness(Cuda& cuda, const Picture& picture) {
  DevicePicture device(picture);
  DeviceFrame frame(picture.width, picture.height);
  double raster = 0;
  for (int i = 0; i < 2; ++i) {  // the first frame has kernels loaded
    const Cuda::TimePoint begin = cuda.now();
    rasterize(cuda, Raster{}, device.job(frame.view(), true));
    const Cuda::TimePoint end = cuda.now();
    cuda.wait();
    raster = cuda.milliseconds(begin, end).value();
  }
  Statistics statistics;
  for (const RasterCounts& raster_block : to_host(cuda, std::as_const(device.counts).span()))
    statistics.raster += raster_block;
  return statistics.balanced_ms() / raster;
}

}  // namespace

TEST_CASE(SWIFTGS_RASTERS ": the balanced time is what warps are at work of the raster time") {
  if (without_device()) return;
  Cuda cuda;
  const Picture many(faint_splats(200'000, 1280, 720), 1280, 720), one(faint_splats(400, 16, 16), 16, 16);
  for_each_tested([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const double of_many = evenness<Raster>(cuda, many), of_one = evenness<Raster>(cuda, one);
    CHECK(of_many > 0.05);
    CHECK(of_many < 1);
    CHECK(of_one > 0);
    CHECK(of_one < 0.05);  // eight warps at most, on devices that run hundreds
  });
}
