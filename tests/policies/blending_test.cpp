// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "policies/double_drawing.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Thresholds that are powers of two, so that every arithmetic meets them exactly.
DrawSettings exact_settings(float stop, bool stop_at_equal) {
  Conventions conventions;
  conventions.alpha_min = 1.0f / 256, conventions.stop = stop, conventions.stop_at_equal = stop_at_equal;
  DrawSettings settings;
  settings.rules = BlendRules::from(conventions);
  return settings;
}

/// A splat whose alpha at pixel (8, 8) is `opacity` to the last bit, for opacities that are powers of two.
void add_half_clear(SplatSet& splats, float depth, vec3 rgb = vec3(1), double opacity = 0.5) {
  splats.add(make_splat(8.5, 8.5, 3, 3, 0, opacity, 1.0 / 256), depth, rgb);
}

}  // namespace

TEST_CASE_TEMPLATE("blend: splats are laid over each other from the nearest to the farthest", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet splats;
  add_half_clear(splats, 4, {0, 1, 0});
  add_half_clear(splats, 2, {1, 0, 0}, 0.25);
  DrawSettings settings = exact_settings(1e-4f, true);
  settings.background = vec3(0, 0, 1);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing drawing = draw<Raster>(backend, splats, 17, 17, settings);
    CHECK(drawing.colour(8, 8, 0) == doctest::Approx(0.25).epsilon(1e-6));
    CHECK(drawing.colour(8, 8, 1) == doctest::Approx(0.75 * 0.5).epsilon(1e-6));
    CHECK(drawing.colour(8, 8, 2) == doctest::Approx(0.75 * 0.5).epsilon(1e-6));
    CHECK(drawing.alpha(8, 8) == doctest::Approx(1 - 0.75 * 0.5).epsilon(1e-6));
    // The mean of 2 and 4, weighted 0.25 and 0.375.
    CHECK(drawing.depth(8, 8) == doctest::Approx(3.2).epsilon(1e-6));
  });
}

TEST_CASE_TEMPLATE("blend: a pixel that nothing reaches shows the background and no alpha and no depth", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet none, far_off;
  far_off.add(make_splat(60, 60, 1, 1, 0, 0.9), 1);
  DrawSettings settings;
  settings.background = vec3(0.1f, 0.2f, 3.0f);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    for (const SplatSet* splats : {&none, &far_off}) {
      const Drawing drawing = draw<Raster>(backend, *splats, 40, 40, settings);
      for (int c = 0; c < 3; ++c) CHECK(drawing.colour(39, 39, c) == settings.background[c]);
      CHECK(drawing.alpha(39, 39) == 0);
      CHECK(drawing.depth(39, 39) == 0);
    }
  });
}

TEST_CASE_TEMPLATE("blend: a pixel ends before the splat that brings it to the limit or only below it", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet splats;
  for (int i = 0; i < 5; ++i) add_half_clear(splats, 1.0f + float(i));
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing inclusive = draw<Raster>(backend, splats, 17, 17, exact_settings(0.25f, true));
    CHECK(inclusive.alpha(8, 8) == 0.5f);
    CHECK(inclusive.colour(8, 8, 0) == 0.5f);
    const Drawing exclusive = draw<Raster>(backend, splats, 17, 17, exact_settings(0.25f, false));
    CHECK(exclusive.alpha(8, 8) == 0.75f);
    CHECK(exclusive.colour(8, 8, 0) == 0.75f);
    CHECK(inclusive.counts.contributing_pairs < exclusive.counts.contributing_pairs);
  });
}

TEST_CASE_TEMPLATE("blend: no pixel ends where the limit is zero, of either sign", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet splats;
  for (int i = 0; i < 5; ++i) add_half_clear(splats, 1.0f + float(i));
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    for (const float stop : {0.0f, -0.0f}) {
      CAPTURE(std::signbit(stop));
      const Drawing drawing = draw<Raster>(backend, splats, 17, 17, exact_settings(stop, false));
      CHECK(drawing.alpha(8, 8) == 1 - 1.0f / 32);
      CHECK(drawing.counts.pixels_stopped == 0);
    }
  });
}

TEST_CASE_TEMPLATE("blend: a stopped pixel stays stopped though fainter splats follow", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet splats;
  add_half_clear(splats, 1);
  add_half_clear(splats, 2);                     // would bring it to 1/4: it ends here
  add_half_clear(splats, 3, vec3(1), 1.0 / 64);  // would not, were it asked
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    CHECK(draw<Raster>(backend, splats, 17, 17, exact_settings(0.25f, true)).alpha(8, 8) == 0.5f);
  });
}

TEST_CASE_TEMPLATE("blend: alpha is cut so that one opaque splat lets a hundredth through", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet splats;
  splats.add(make_splat(8.5, 8.5, 40, 40, 0, 1), 1);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    CHECK(draw<Raster>(backend, splats, 16, 16).alpha(8, 8) == doctest::Approx(0.99).epsilon(1e-6));
  });
}

TEST_CASE_TEMPLATE("blend: images of any size are those of double", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  struct Size {
    int width, height;
  };
  for (const Size size : {Size{1, 1}, {15, 1}, {1, 17}, {16, 16}, {17, 33}, {70, 45}, {128, 64}}) {
    CAPTURE(size.width);
    CAPTURE(size.height);
    const SplatSet splats = usual_splats(300, size.width, size.height, 11);
    DrawSettings settings;
    settings.background = vec3(0.3f, 0.2f, 0.1f);
    const DoubleDrawing exact = draw_in_double(splats, size.width, size.height, settings);
    for_each_raster([&]<class Raster>(Raster) {
      if (stores_half<Raster>) return;
      CAPTURE(Raster::name);
      const Drawing drawing = draw<Raster>(backend, splats, size.width, size.height, settings);
      // Rounding alone stays below 2e-5; a pixel at a threshold may gain or lose a splat: 0.011 at most.
      const Difference colour = difference(drawing.frame.colour, exact.colour, 2e-5);
      CHECK(colour.largest < 0.011);
      CHECK(colour.part_above < 0.002);
      CHECK(difference(drawing.frame.alpha, exact.alpha, 2e-5).part_above < 0.002);
      CHECK(difference(drawing.frame.depth, exact.depth, 1e-3).part_above < 0.002);
    });
  }
}

TEST_CASE_TEMPLATE("blend: half-split images are those of double as far as half carries", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = usual_splats(300, 128, 64, 12);
  const DoubleDrawing exact = draw_in_double(splats, 128, 64);
  for_each_raster([&]<class Raster>(Raster) {
    if (!stores_half<Raster>) return;
    CAPTURE(Raster::name);
    const Difference colour =
        difference(draw<Raster>(backend, splats, 128, 64).frame.colour, exact.colour, 1e-4);
    CHECK(colour.largest < 0.011);
    CHECK(colour.part_above > 0.01);  // or its terms are not stored as half at all
  });
}

TEST_CASE_TEMPLATE("blend: what is counted is what double counts", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = usual_splats(1500, 100, 70, 13);
  const DoubleDrawing exact = draw_in_double(splats, 100, 70);
  REQUIRE(exact.pixels_stopped > 100);
  for_each_raster([&]<class Raster>(Raster) {
    if (stores_half<Raster>) return;
    CAPTURE(Raster::name);
    const RasterCounts counts = draw<Raster>(backend, splats, 100, 70).counts;
    CHECK(double(counts.contributing_pairs) ==
          doctest::Approx(double(exact.contributing_pairs)).epsilon(1e-3));
    CHECK(double(counts.pixels_stopped) == doctest::Approx(double(exact.pixels_stopped)).epsilon(1e-2));
  });
}

TEST_CASE_TEMPLATE("blend: memory beyond each row of a pitched frame is left alone", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const int width = 37, height = 21;
  const SplatSet splats = usual_splats(100, width, height, 14);
  const SortInput job = splats.job(width, height);
  const TileLists<B> lists = build_lists<EarlySort, Ellipse>(backend, job);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing tight = draw<Raster>(backend, splats, width, height);
    const std::size_t pitch = 53;
    std::vector<float> colour(3 * pitch * height, -7), alpha(pitch * height, -7), depth(pitch * height, -7);
    const FrameView frame{.width = width,
                          .height = height,
                          .colour = {colour.data(), 12 * pitch},
                          .alpha = {alpha.data(), 4 * pitch},
                          .depth = {depth.data(), 4 * pitch}};
    const View view = view_into(frame);
    rasterize(backend, Raster{}, RasterJob{splats.view(), splats.colours_view(), lists.view(), {&view, 1}});
    bool same = true, untouched = true;
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < pitch; ++x) {
        const std::size_t at = y * pitch + x, from = y * width + x;
        if (x < width) {
          same = same && alpha[at] == tight.frame.alpha[from] && depth[at] == tight.frame.depth[from];
          for (std::size_t c = 0; c < 3; ++c)
            same = same && colour[3 * at + c] == tight.frame.colour[3 * from + c];
        } else {
          untouched = untouched && alpha[at] == -7 && depth[at] == -7;
          for (std::size_t c = 0; c < 3; ++c) untouched = untouched && colour[3 * at + c] == -7;
        }
      }
    CHECK(same);
    CHECK(untouched);
  });
}

TEST_CASE_TEMPLATE("blend: each output alone is the same as with the others", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = usual_splats(100, 50, 30, 15);
  const SortInput job = splats.job(50, 30);
  const TileLists<B> lists = build_lists<EarlySort, Ellipse>(backend, job);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing all = draw<Raster>(backend, splats, 50, 30);
    const auto run = [&](const FrameView& frame) {
      const View view = view_into(frame);
      rasterize(backend, Raster{}, RasterJob{splats.view(), splats.colours_view(), lists.view(), {&view, 1}});
    };
    std::vector<float> colour(50 * 30 * 3), alpha(50 * 30), depth(50 * 30);
    run({.width = 50, .height = 30, .colour = {colour.data(), 600}});
    run({.width = 50, .height = 30, .alpha = {alpha.data(), 200}});
    run({.width = 50, .height = 30, .depth = {depth.data(), 200}});
    CHECK(colour == all.frame.colour);
    CHECK(alpha == all.frame.alpha);
    CHECK(depth == all.frame.depth);
  });
}

TEST_CASE_TEMPLATE("blend: conservative bounds draw the same bits of splats that barely reach the threshold",
                   B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const int width = 400, height = 300;
  for (const double faintness : {1e-6, 1e-5, 1e-3}) {
    CAPTURE(faintness);
    // So large that a rounding of the exponent, which is close to 0 everywhere, is pixels wide.
    Random random(5);
    SplatSet splats;
    for (int i = 0; i < 300; ++i) {
      const double along = random.scale(300, 3e4);
      splats.add(make_splat(random.in(0, width), random.in(0, height), along, along * random.scale(0.02, 1),
                            random.in(0, 3.14), (1 + faintness) / 255),
                 float(i + 1));
    }
    const SortInput job = splats.job(width, height);
    for_each_raster([&]<class Raster>(Raster) {
      CAPTURE(Raster::name);
      const auto alpha_within = [&]<class Bounds>(Bounds) {
        const TileLists<B> lists = build_lists<EarlySort, Bounds>(backend, job);
        std::vector<float> alpha(std::size_t(width * height));
        const View view = view_into({.width = width, .height = height, .alpha = {alpha.data(), 4 * width}});
        rasterize(backend, Raster{},
                  RasterJob{splats.view(), splats.colours_view(), lists.view(), {&view, 1}});
        return alpha;
      };
      const std::vector<float> expected = alpha_within(Ellipse());
      for_each_type(AllBounds(), [&]<class Bounds>(Bounds bounds) {
        CAPTURE(Bounds::name);
        if constexpr (Bounds::conservative) CHECK(alpha_within(bounds) == expected);
      });
    });
  }
}

TEST_CASE_TEMPLATE("blend: terms beyond the largest half leave no pixel that is not a number", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  Random random(16);
  SplatSet splats;
  for (int i = 0; i < 300; ++i) {
    // Needles through the image whose centres lie far outside: squared terms of millions.
    const double angle = random.in(0, 3.14159), away = random.in(-3000, 3000);
    splats.add(make_splat(32 + away * std::cos(angle), 32 + away * std::sin(angle), 4000, 0.6, angle, 0.9),
               random.f(1, 2));
  }
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing drawing = draw<Raster>(backend, splats, 64, 64);
    bool finite = true;
    for (const float value : drawing.frame.colour) finite = finite && value >= 0 && value <= 1.001f;
    for (const float value : drawing.frame.alpha) finite = finite && value >= 0 && value <= 1;
    CHECK(finite);
  });
}

TEST_CASE_TEMPLATE("blend: tiles of any side give the same bits", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = random_splats(600, 150, 110, 16);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const Drawing usual = draw<Raster>(backend, splats, 150, 110);
    for (const int side : {32, 64, 256}) {
      CAPTURE(side);
      const Drawing drawn = draw<Raster>(backend, splats, 150, 110, {}, side);
      CHECK(drawn.frame.colour == usual.frame.colour);
      CHECK(drawn.frame.alpha == usual.frame.alpha);
      CHECK(drawn.frame.depth == usual.frame.depth);
      CHECK(drawn.counts.contributing_pairs == usual.counts.contributing_pairs);
      CHECK(drawn.counts.intersections_visited >= usual.counts.intersections_visited);
    }
  });
}

TEST_CASE_TEMPLATE("blend: tiles that do not fit the frame or the raster blocks are refused", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  std::vector<float> alpha(64 * 48);
  View view = view_into({.width = 64, .height = 48, .alpha = {alpha.data(), 256}});
  std::vector<TileRange> ranges(12);
  const auto refused = [&](TileGrid grid, const char* expected) {
    view.grid = grid;
    CHECK_THROWS_WITH_AS(Views(&view, 1), expected, std::invalid_argument);
  };
  const auto of = [](int columns, int rows, int side) {
    return TileGrid{{0, columns}, {0, rows}, side, 0, std::uint32_t(columns)};
  };
  refused(of(8, 6, 8), "tiles: the side is 8, expected a power of two of at least 16 pixels");
  refused(of(3, 2, 24), "tiles: the side is 24, expected a power of two of at least 16 pixels");
  refused(of(3, 3, 16), "tiles: the number of columns is 3, expected 4");
  refused(of(4, 2, 16), "tiles: the number of rows is 2, expected 3");
  CHECK_THROWS_WITH_AS(Views(&view, 0), "frame: the number of views is 0, expected 1 to 65536",
                       std::invalid_argument);
  view.frame.width = 0;
  refused(of(4, 3, 16), "frame: 0 x 48 pixels, expected 1 to 65536 a side");
  view.frame.width = 64;

  const auto rasterize_lists = [&] {
    rasterize(backend, PerPixel(), RasterJob{{}, {}, {{}, {ranges.data(), ranges.size()}}, {&view, 1}});
  };
  view.grid = of(2, 2, 32);
  CHECK_THROWS_WITH_AS(
      rasterize_lists(),
      "rasterize: the number of lists is 12, expected a list for each of the frame's 4 tiles",
      std::invalid_argument);
  view.grid = of(4, 3, 16);
  rasterize_lists();
}
