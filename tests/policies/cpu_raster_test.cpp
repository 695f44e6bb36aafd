// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>
#include <hwy/targets.h>

#include "policies/double_drawing.hpp"
#include "policies/images.hpp"
#include "policies/only_targets.hpp"

namespace swiftgs::test::cpu_raster_test {

namespace {

/// What a vector kernel may differ by from the plain form, or from another target: order of operations and
/// the exponential's last bits. A pixel at a threshold may then gain or lose one splat, so a few values
/// differ by up to 0.011, the weight of a splat that the stop rule excludes.
void check_close(const Drawing& a, const Drawing& b, bool half) {
  // A term that lies between two halves may be rounded to either, which moves alpha by up to 2%.
  const Difference colour = difference(a.frame.colour, b.frame.colour, half ? 1e-3 : 1e-5);
  CHECK(colour.largest < (half ? 0.03 : 0.011));
  CHECK(colour.part_above < 0.002);
  CHECK(difference(a.frame.alpha, b.frame.alpha, half ? 1e-3 : 1e-5).part_above < 0.002);
  CHECK(difference(a.frame.depth, b.frame.depth, half ? 1e-2 : 1e-3).part_above < 0.002);
  CHECK(double(a.counts.contributing_pairs) ==
        doctest::Approx(double(b.counts.contributing_pairs)).epsilon(1e-3));
}

const Outputs all_picks{
    .alpha = true, .first_depth = true, .median_depth = true, .id = true, .median_id = true};

/// Part of the values that differ.
template <class T>
double part_unlike(const std::vector<T>& a, const std::vector<T>& b) {
  REQUIRE(a.size() == b.size());
  std::size_t unlike = 0;
  for (std::size_t i = 0; i < a.size(); ++i) unlike += a[i] != b[i];
  return double(unlike) / double(a.size());
}

/// Adds a splat that has its opacity in all pixels of a small image.
void add_flat(SplatSet& splats, float depth, double opacity) {
  splats.add(make_splat(8, 8, 1e7, 1e7, 0, opacity), depth);
}

/// Adds splats of a corner of a raster block, so many that those behind them are of a later batch.
void add_batches(SplatSet& splats, float depth) {
  for (int i = 0; i < 150; ++i) splats.add(make_splat(14, 14, 0.55, 0.55, 0, 0.02), depth);
}

/// Checks that every vector target picks in the first pixel what plain kernels pick: Gaussian `id`.
void check_picks(const SplatSet& splats, const DrawSettings& settings, std::uint32_t id) {
  Serial serial;
  Cpu cpu(1);
  with_each_raster<Cpu>([&](const BoundRaster<Cpu>& raster) {
    const Frame plain = draw(serial, raster.on_serial, splats, 16, 16, settings).frame;
    CHECK(plain.id[0] == id);
    on_each_target([&] {
      const Frame frame = draw(cpu, raster, splats, 16, 16, settings).frame;
      CHECK(frame.id[0] == plain.id[0]);
      CHECK(frame.median_id[0] == plain.median_id[0]);
      CHECK(frame.first_depth[0] == plain.first_depth[0]);
      CHECK(frame.median_depth[0] == plain.median_depth[0]);
    });
  });
}

}  // namespace

TEST_CASE("cpu raster: every vector target draws what the plain kernels draw") {
  Serial serial;
  Cpu cpu(4);
  REQUIRE(!hwy::SupportedAndGeneratedTargets().empty());
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    const SplatSet splats = usual_splats(400 * seed * seed, 150, 110, seed);
    with_each_raster<Cpu>([&](const BoundRaster<Cpu>& raster) {
      const Drawing plain = draw(serial, raster.on_serial, splats, 150, 110);
      on_each_target(
          [&] { check_close(draw(cpu, raster, splats, 150, 110), plain, stores_half(raster.name)); });
    });
  }
}

TEST_CASE("cpu raster: every vector target stores each pixel format and ends at the occluder") {
  const int width = 150, height = 110;
  const SplatSet splats = usual_splats(800, width, height, 8);
  const SortInput job = splats.job(width, height);
  std::vector<float> occluder;
  Random random(9);
  for (int i = 0; i < width * height; ++i) occluder.push_back(random.f(0, 30));
  const auto over = [&](auto& backend, Image image, Conversion conversion) {
    const auto lists = build_lists<EarlySort, Ellipse>(backend, job);
    View view = view_into(image.frame(), {.background = vec3(9)});
    view.frame.over = true, view.frame.occluder = {occluder.data(), width * sizeof(float)};
    view.frame.conversion = conversion;
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
    const std::vector<float> plain = channels(over(serial, floats, Conversion::as_is));
    on_each_target([&] {
      const Image above = over(cpu, floats, Conversion::as_is);
      const Difference colour = difference(channels(above), plain, 1e-5);
      CHECK(colour.largest < 0.011);
      CHECK(colour.part_above < 0.002);
      CHECK((over(cpu, below, Conversion::as_is).bytes == converted(above, format).bytes));
      if (format == PixelFormat::rgb_float) return;  // a whole picture
      for (const Conversion conversion : {Conversion::srgb_to_linear, Conversion::linear_to_srgb})
        CHECK((over(cpu, below, conversion).bytes == converted(over(cpu, floats, conversion), format).bytes));
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
  const auto check = [&](const BoundRaster<Cpu>& raster) {
    CAPTURE(raster.name);
    const RasterCounts plain = draw(serial, raster.on_serial, splats, 640, 480).counts;
    REQUIRE(plain.pixels_stopped == 0);
    on_each_target([&] {
      const RasterCounts counts = draw(cpu, raster, splats, 640, 480).counts;
      // A pixel at the threshold may fall on the other side of it.
      CHECK(double(counts.contributing_pairs) ==
            doctest::Approx(double(plain.contributing_pairs)).epsilon(1e-5));
      CHECK(double(counts.rows_visited) == doctest::Approx(double(plain.rows_visited)).epsilon(1e-5));
    });
  };
  check(BoundRaster<Cpu>::of<AxisShared<FloatCholesky>>());
  check(BoundRaster<Cpu>::of<AxisSharedThreshold<FloatCholesky>>());
}

TEST_CASE("cpu raster: every vector target picks the splats that the plain kernels pick") {
  const int width = 150, height = 110;  // lists longer than a batch, and raster blocks across the borders
  const SplatSet splats = usual_splats(3000, width, height, 12);
  DrawSettings settings{.outputs = all_picks, .count = false};
  Serial serial;
  Cpu cpu(2);
  for (const bool occluded : {false, true}) {
    CAPTURE(occluded);
    Random random(13);
    for (int i = 0; occluded && i < width * height; ++i) settings.occluder.push_back(random.f(0, 30));
    with_each_raster<Cpu>([&](const BoundRaster<Cpu>& raster) {
      const double few = stores_half(raster.name) ? 0.02 : 0.002;
      const Frame plain = draw(serial, raster.on_serial, splats, width, height, settings).frame;
      on_each_target([&] {
        const Frame frame = draw(cpu, raster, splats, width, height, settings).frame;
        CHECK(part_unlike(frame.id, plain.id) < few);
        CHECK(part_unlike(frame.median_id, plain.median_id) < few);
        CHECK(part_unlike(frame.first_depth, plain.first_depth) < few);
        CHECK(part_unlike(frame.median_depth, plain.median_depth) < few);
        DrawSettings counted = settings;
        counted.count = true;
        CHECK(same_planes(draw(cpu, raster, splats, width, height, counted).frame, frame));
      });
    });
  }
}

TEST_CASE("cpu raster: of equal weights the nearest Gaussian is picked in one batch and in two") {
  DrawSettings settings{.outputs = all_picks};
  settings.rules.alpha_max = 1, settings.rules.stop_below = 0;
  for (const bool apart : {false, true})
    for (const bool lowest_first : {false, true}) {
      CAPTURE(apart);
      CAPTURE(lowest_first);
      SplatSet splats;  // the front one halves the light, and the other takes what is left
      add_flat(splats, lowest_first ? 1 : 3, lowest_first ? 0.5 : 1);
      add_flat(splats, lowest_first ? 3 : 1, lowest_first ? 1 : 0.5);
      if (apart) add_batches(splats, 2);
      check_picks(splats, settings, lowest_first ? 0 : 1);
    }
}

TEST_CASE("cpu raster: both limits are crossed by one splat or by two of a batch or of two") {
  DrawSettings settings{.outputs = all_picks};
  for (const bool apart : {false, true}) {
    CAPTURE(apart);
    SplatSet thick, halves, stopped;
    if (apart)
      for (SplatSet* splats : {&thick, &halves, &stopped}) add_batches(*splats, 2);
    const auto before = std::uint32_t(thick.shapes.size());
    add_flat(thick, 1, 0.04), add_flat(thick, 3, 0.8), add_flat(thick, 4, 0.9);
    check_picks(thick, settings, before + 1);
    // The first leaves one half, which is not below it.
    add_flat(halves, 1, 0.5), add_flat(halves, 3, 0.25), add_flat(halves, 4, 0.5);
    check_picks(halves, settings, before);
    // The second would cross one half, and ends the pixel.
    add_flat(stopped, 1, 0.3), add_flat(stopped, 3, 0.8);
    settings.rules.stop_below = 0.2f;
    check_picks(stopped, settings, before);
    settings.rules.stop_below = DrawSettings().rules.stop_below;
  }
}

TEST_CASE("cpu raster: every vector target sums attributes beside other planes and alone") {
  const int width = 150, height = 110;
  const SplatSet splats = usual_splats(800, width, height, 14);
  const SortInput input = splats.job(width, height);
  const Outputs outputs{.alpha = true, .depth = true, .id = true, .features = int(AttributesView::most)};
  Random random(15);
  std::vector<AttributeRow> rows(AttributesView::most_rows * splats.shapes.size());
  for (AttributeRow& row : rows)
    for (float& value : row.values) value = random.f(-1, 1);
  const auto drawn = [&](auto& backend, bool alone) {
    const auto lists = build_lists<EarlySort, Ellipse>(backend, input);
    Frame frame;
    const View view = view_into(prepare(frame, width, height, outputs));
    for (std::vector<float>* values : {&frame.colour, &frame.alpha, &frame.depth})
      std::fill(values->begin(), values->end(), 7.0f);
    frame.id.assign(frame.pixels(), 7);
    RasterJob job{splats.view(), splats.colours_view(), lists.view(), {&view, 1}};
    job.attributes = {rows.data(), AttributesView::most_rows, 0};
    job.only_attributes = alone;
    rasterize(backend, AxisSharedThreshold<FloatCholesky>(), job);
    return frame;
  };
  Serial serial;
  Cpu cpu(2);
  for (const bool alone : {false, true}) {
    CAPTURE(alone);
    const Frame plain = drawn(serial, alone);
    on_each_target([&] {
      const Frame frame = drawn(cpu, alone);
      CHECK(difference(frame.features, plain.features, 1e-5).part_above < 0.002);
      CHECK(difference(frame.colour, plain.colour, 1e-5).part_above < 0.002);
      CHECK(part_unlike(frame.id, plain.id) < 0.002);
      if (alone) CHECK(frame.colour == plain.colour);
    });
  }
}

}  // namespace swiftgs::test::cpu_raster_test
