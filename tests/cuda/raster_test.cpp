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

/// Checks both kinds of kernels against the serial backend.
template <class Raster>
void check_drawing(Cuda& cuda, const Picture& picture) {
  CAPTURE(Raster::name);
  CAPTURE(picture.width);
  CAPTURE(picture.height);
  const Drawing expected = draw_on_host<Raster>(picture), drawn = draw_on_device<Raster>(cuda, picture);
  // Of half terms a few round to the other side, for which no more than their share of the pixels differs.
  const double share = stores_half<Raster> ? (picture.width * picture.height > 1000 ? 0.05 : 1.0) : 0.001;
  const Difference colour = difference(drawn.frame.colour, expected.frame.colour, 2e-5);
  CHECK(colour.largest < crossing);
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
  CHECK(drawn.counts.instances_visited <= picture.lists.ids.size());
  if (own_kernels) {
    CHECK(drawn.counts.instances_visited >= expected.counts.instances_visited);
  } else {
    // The same walk: it ends elsewhere only where a threshold falls differently.
    CHECK(double(drawn.counts.instances_visited) ==
          doctest::Approx(double(expected.counts.instances_visited)).epsilon(1e-2));
    CHECK(double(drawn.counts.rows_visited) ==
          doctest::Approx(double(expected.counts.rows_visited)).epsilon(1e-2));
  }

  const Drawing lean = draw_on_device<Raster>(cuda, picture, true);
  CHECK(same_bits(lean.frame.colour, drawn.frame.colour));
  CHECK(same_bits(lean.frame.alpha, drawn.frame.alpha));
}

void check_all(const Picture& picture) {
  Cuda cuda;
  for_each_tested([&]<class Raster>(Raster) { check_drawing<Raster>(cuda, picture); });
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
  for (const SquareCounts& square : to_host(cuda, std::as_const(device.counts).span()))
    statistics.raster += square;
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
