// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>
#include <hwy/targets.h>

#include "policies/double_drawing.hpp"
#include "policies/images.hpp"
#include "policies/only_targets.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// What a vector kernel may differ by from the plain form, or from another target: order of operations and
/// the exponential's last bits. A pixel at a threshold may then gain or lose one splat, so a few values
/// differ by up to 0.011, the weight of a splat that the stop rule excludes.
template <class Raster>
void check_close(const Drawing& a, const Drawing& b) {
  const bool half = stores_half<Raster>;
  // A term that lies between two halves may be rounded to either, which moves alpha by up to 2%.
  const Difference colour = difference(a.frame.colour, b.frame.colour, half ? 1e-3 : 1e-5);
  CHECK(colour.largest < (half ? 0.03 : 0.011));
  CHECK(colour.part_above < 0.002);
  CHECK(difference(a.frame.alpha, b.frame.alpha, half ? 1e-3 : 1e-5).part_above < 0.002);
  CHECK(difference(a.frame.depth, b.frame.depth, half ? 1e-2 : 1e-3).part_above < 0.002);
  CHECK(double(a.counts.contributing_pairs) ==
        doctest::Approx(double(b.counts.contributing_pairs)).epsilon(1e-3));
}

}  // namespace

TEST_CASE("cpu raster: vector kernels draw what the plain kernels draw") {
  Serial serial;
  Cpu cpu(4);
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    const SplatSet splats = usual_splats(400 * seed * seed, 150, 110, seed);
    for_each_raster([&]<class Raster>(Raster) {
      CAPTURE(Raster::name);
      check_close<Raster>(draw<Raster>(cpu, splats, 150, 110), draw<Raster>(serial, splats, 150, 110));
    });
  }
}

TEST_CASE("cpu raster: every vector target draws the same image") {
  const SplatSet splats = usual_splats(800, 150, 110, 4);
  Cpu cpu(2);
  REQUIRE(!hwy::SupportedAndGeneratedTargets().empty());
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing best = draw<Raster>(cpu, splats, 150, 110);
    on_each_target([&] { check_close<Raster>(draw<Raster>(cpu, splats, 150, 110), best); });
  });
}

TEST_CASE("cpu raster: every vector target stores each pixel format and ends at the occluder") {
  const int width = 150, height = 110;
  const SplatSet splats = usual_splats(800, width, height, 8);
  const SortInput job = splats.job(width, height);
  std::vector<float> occluder;
  Random random(9);
  for (int i = 0; i < width * height; ++i) occluder.push_back(random.f(0, 30));
  const auto over = [&](auto& backend, Image image) {
    const auto lists = build_lists<EarlySort, Ellipse>(backend, job);
    View view = view_into(image.frame(), {.background = vec3(9)});
    view.frame.over = true, view.frame.occluder = {occluder.data(), width * sizeof(float)};
    rasterize(backend, AxisSharedThreshold<FloatCholesky>(),
              RasterJob{splats.view(), splats.colours_view(), lists.view(), {&view, 1}});
    return image;
  };
  const auto channels = [](Image image) {
    std::vector<float> out;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < 4; ++c) out.push_back(image.at(x, y)[c]);
    return out;
  };
  Serial serial;
  Cpu cpu(2);
  for (const PixelFormat format : pixel_formats) {
    CAPTURE(int(format));
    const Image below = pattern(width, height, format), floats = converted(below, PixelFormat::rgba_float);
    const std::vector<float> plain = channels(over(serial, floats));
    on_each_target([&] {
      const Image above = over(cpu, floats);
      const Difference colour = difference(channels(above), plain, 1e-5);
      CHECK(colour.largest < 0.011);
      CHECK(colour.part_above < 0.002);
      CHECK((over(cpu, below).bytes == converted(above, format).bytes));
    });
  }
}

TEST_CASE("cpu raster: every vector target stores terms beyond the largest half as infinite") {
  SplatSet needles;
  add_needles(needles, 7);
  Serial serial;
  Cpu cpu(2);
  const Drawing plain = draw<AxisShared<HalfSplit>>(serial, needles, 64, 64);
  on_each_target([&] {
    const Drawing drawing = draw<AxisShared<HalfSplit>>(cpu, needles, 64, 64);
    CHECK(difference(drawing.frame.alpha, plain.frame.alpha, 1e-2).part_above < 0.01);
  });
}

TEST_CASE("cpu sort: every vector target lists the same tiles") {
  const SplatSet splats = random_splats(3000, 400, 300, 5);
  const SortInput job = splats.job(400, 300);
  const Lists expected = brute_force_lists<Ellipse>(job);
  Cpu cpu(2);
  on_each_target([&] {
    CHECK(to_vectors(build_lists<EarlySort, Ellipse>(cpu, job).view()) == expected);
    CHECK(to_vectors(build_lists<StandardSort, Ellipse>(cpu, job).view()) == expected);
  });
}

TEST_CASE("cpu raster: the same bits on 1 2 4 and 8 threads and in every run") {
  const SplatSet splats = usual_splats(2000, 300, 200, 6);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    Cpu one(1);
    const Drawing expected = draw<Raster>(one, splats, 300, 200);
    for (const int threads : {1, 2, 4, 8}) {
      CAPTURE(threads);
      Cpu cpu(threads);
      for (int run = 0; run < 2; ++run) {
        const Drawing drawing = draw<Raster>(cpu, splats, 300, 200);
        CHECK(same_planes(drawing.frame, expected.frame));
        CHECK(drawing.counts.contributing_pairs == expected.counts.contributing_pairs);
      }
    }
  });
}

TEST_CASE("cpu raster: no block is refused that has a pixel to show") {
  // Faint and apart, so that no pixel stops and each that is lost is a pair less.
  SplatSet splats;
  Random random(11);
  for (int i = 0; i < 20000; ++i) {
    const double x = random.in(0, 640), y = random.in(0, 480), angle = random.in(0, 3.14159);
    const double along = random.scale(0.55, 30), across = random.scale(0.55, 2);
    splats.add(make_splat(x, y, along, across, angle, random.scale(0.004, 0.02)), float(1 + i));
  }
  Serial serial;
  Cpu cpu(2);
  const auto check = [&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const RasterCounts plain = draw<Raster>(serial, splats, 640, 480).counts;
    REQUIRE(plain.pixels_stopped == 0);
    on_each_target([&] {
      const RasterCounts counts = draw<Raster>(cpu, splats, 640, 480).counts;
      // A pixel at the threshold may fall on the other side of it.
      CHECK(double(counts.contributing_pairs) ==
            doctest::Approx(double(plain.contributing_pairs)).epsilon(1e-5));
      CHECK(double(counts.rows_visited) == doctest::Approx(double(plain.rows_visited)).epsilon(1e-5));
    });
  };
  check(AxisShared<FloatCholesky>());
  check(AxisSharedThreshold<FloatCholesky>());
}
