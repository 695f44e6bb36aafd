// SPDX-License-Identifier: Apache-2.0

// The tiles of several views: their numbers, their raster blocks and their lists; and what is refused.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/project/project.hpp>

#include "policies/image_parts.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::view_tiles_test {

namespace {

/// Views of random sizes, some of which show a part of an image, on tiles of so many pixels a side.
std::vector<View> random_views(Random& random, std::size_t count, int tile_side) {
  std::vector<View> views;
  for (std::size_t i = 0; i < count; ++i) {
    const int width = 1 + int(random.bits() % 200), height = 1 + int(random.bits() % 200);
    View view = view_without_camera(width, height, tile_side);
    const int right = int(random.bits() % 5), down = int(random.bits() % 5);
    view.grid.columns.begin += right, view.grid.columns.end += right;
    view.grid.rows.begin += down, view.grid.rows.end += down;
    views.push_back(view);
  }
  number_tiles(span_of(views));
  return views;
}

/// The message that `make` is refused with, or "accepted".
template <class F>
std::string refusal(const F& make) {
  try {
    make();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("view tiles: each number belongs to one tile of one view or to none") {
  Random random(1);
  for (const std::size_t count : {1, 2, 5, 40})
    for (const int side : {16, 64}) {
      CAPTURE(count);
      CAPTURE(side);
      const std::vector<View> views = random_views(random, count, side);
      const FrameTiles tiles = Views(views.data(), views.size()).tiles;
      CHECK(tiles.side == side);
      std::vector<int> used(tiles.size());
      std::size_t expected = 0, wrong_view = 0, wrong_pixel = 0;
      for (std::size_t v = 0; v < count; ++v) {
        const TileGrid& grid = views[v].grid;
        expected += grid.size();
        for (int row = grid.rows.begin; row < grid.rows.end; ++row)
          for (int column = grid.columns.begin; column < grid.columns.end; ++column) {
            const std::uint32_t number = grid.number(column, row);
            REQUIRE(number < tiles.size());
            ++used[number];
            wrong_view += view_of_tile(views.data(), std::uint32_t(count), number) != v;
            wrong_pixel += grid.tile_at(column * side, row * side) != number;
            wrong_pixel += grid.tile_at(column * side + side - 1, row * side + side - 1) != number;
          }
      }
      std::size_t once = 0, more = 0;
      for (const int times : used) once += times == 1, more += times > 1;
      CHECK(once == expected);
      CHECK(more == 0);
      CHECK(wrong_view == 0);
      CHECK(wrong_pixel == 0);
      CHECK((std::size_t(1) << tiles.key_bits()) >= tiles.size());
    }
}

TEST_CASE("view tiles: each pixel of each view lies in one raster block that has the list of its tile") {
  Random random(2);
  for (const std::size_t count : {1, 2, 5, 40})
    for (const int side : {16, 64}) {
      CAPTURE(count);
      CAPTURE(side);
      const std::vector<View> each = random_views(random, count, side);
      const Views views{each.data(), each.size()};
      const FrameTiles& tiles = views.tiles;
      std::vector<TileRange> ranges(tiles.size());
      for (std::uint32_t tile = 0; tile < ranges.size(); ++tile) ranges[tile] = {tile, tile + 1};
      const RasterJob job{{}, {}, {{}, {ranges.data(), ranges.size()}}, views};
      const RasterBlocks blocks = raster_blocks_of(job);
      std::vector<std::vector<int>> covered;
      for (const View& view : each)
        covered.emplace_back(std::size_t(view.frame.width) * std::size_t(view.frame.height));
      std::size_t wrong_list = 0, wrong_centre = 0;
      for (std::size_t block = 0; block < blocks.size(); ++block) {
        const RasterBlockOfView here(views, blocks, block);
        if (here.empty()) continue;
        const auto v = std::size_t(&here.view - each.data());
        REQUIRE(v < each.size());
        const int left = each[v].grid.columns.begin * side, top = each[v].grid.rows.begin * side;
        wrong_centre += here.first_centre != vec2(float(left + here.x0) + 0.5f, float(top + here.y0) + 0.5f);
        for (int y = here.y0; y < here.y0 + here.rows; ++y)
          for (int x = here.x0; x < here.x0 + here.columns; ++x) {
            ++covered[v].at(std::size_t(y) * std::size_t(each[v].frame.width) + std::size_t(x));
            wrong_list += here.list(job).begin != each[v].grid.number((left + x) / side, (top + y) / side);
          }
      }
      std::size_t not_once = 0;
      for (const std::vector<int>& view : covered)
        for (const int times : view) not_once += times != 1;
      CHECK(not_once == 0);
      CHECK(wrong_list == 0);
      CHECK(wrong_centre == 0);
    }
}

TEST_CASE("view tiles: numbers of another order, other sides and no views are refused in words") {
  std::vector<View> views(3);
  views[0] = view_without_camera(100, 40), views[1] = view_without_camera(30, 50);
  views[2] = view_without_camera(70, 20);
  using Spoilt = std::vector<View>;
  const auto refusal_of = [](const Spoilt& v) { return refusal([&] { Views(v.data(), v.size()); }); };
  const auto with = [&](const auto& spoil) {
    Spoilt spoilt = views;
    number_tiles(span_of(spoilt));
    spoil(spoilt);
    return refusal_of(spoilt);
  };
  CHECK(with([](Spoilt&) {}) == "accepted");
  CHECK(refusal_of({}) == "frame: the number of views is 0, expected 1 to 65536");
  CHECK(refusal_of(Spoilt(65537, views[0])) == "frame: the number of views is 65537, expected 1 to 65536");
  const auto numbered = [](const char* found, const char* expected) {
    return std::string("tiles: those of a view are numbered from ") + found + ", expected " + expected +
           "; number_tiles numbers them";
  };
  CHECK(refusal_of(views) == numbered("0 on in rows of 2", "21 and 7"));
  CHECK(with([](Spoilt& v) { v[1].grid.first = 22; }) == numbered("22 on in rows of 7", "21 and 7"));
  CHECK(with([](Spoilt& v) { v[0].grid.first = 1; }) == numbered("1 on in rows of 7", "0 and 7"));
  CHECK(with([](Spoilt& v) { std::swap(v[1], v[2]); }) == numbered("49 on in rows of 7", "21 and 7"));
  CHECK(with([](Spoilt& v) { v[2].grid.stride = 8; }) == numbered("49 on in rows of 8", "49 and 7"));
  // Rows of two tiles hold none of seven.
  CHECK(with([](Spoilt& v) {
          for (View& view : v) view.grid.stride = 2;
        }) == numbered("0 on in rows of 2", "0 and 2"));
  CHECK(with([](Spoilt& v) { v[2] = view_without_camera(70, 20, 32); }) ==
        "tiles: the side is 32, expected that of the first view, 16");
  CHECK(with([](Spoilt& v) { v[2].frame.height = 33; }) == "tiles: the number of rows is 2, expected 3");
  CHECK(with([](Spoilt& v) { v[1].frame.width = 33; }) == "tiles: the number of columns is 2, expected 3");
  for (const int side : {0, 65537})
    CHECK(with([&](Spoilt& v) { v[1].frame.height = side; }) ==
          "frame: 30 x " + std::to_string(side) + " pixels, expected 1 to 65536 a side");
}

TEST_CASE("view tiles: as many as there may be are accepted and a view more is a capacity error") {
  std::vector<View> views(128, view_without_camera(max_image_side, max_image_side));
  number_tiles(span_of(views));
  const FrameTiles tiles = Views(views.data(), views.size()).tiles;
  CHECK(tiles.size() == max_frame_tiles);
  CHECK(tiles.key_bits() == 31);
  views.push_back(view_without_camera(max_image_side, 16));
  number_tiles(span_of(views));
  CHECK_THROWS_WITH_AS(Views(views.data(), views.size()),
                       "tiles in one frame: 2147487744 needed, the limit is 2147483648", CapacityError);
  // Small views count as much as the widest.
  std::vector<View> narrow(65536, view_without_camera(1, 160));
  narrow[0] = view_without_camera(max_image_side, 16);
  number_tiles(span_of(narrow));
  CHECK_THROWS_AS(Views(narrow.data(), narrow.size()), CapacityError);
}

TEST_CASE("view tiles: a part that does not begin at a tile or lie within the image is refused in words") {
  const Camera camera = forward_camera(100, 75);
  const auto made = [&](FirstPixel first, int width, int height) {
    return refusal(
        [&] { make_view(camera, Conventions(), {.width = width, .height = height}, vec3(0), first); });
  };
  CHECK(made({0, 0}, 100, 75) == "accepted");
  CHECK(made({0, 0}, 1, 1) == "accepted");
  CHECK(made({96, 64}, 4, 11) == "accepted");
  CHECK(made({16, 64}, 84, 3) == "accepted");
  CHECK(made({8, 0}, 16, 16) == "view: the first pixel's x is 8, expected a multiple of 16");
  CHECK(made({-16, 0}, 16, 16) == "view: the first pixel's x is -16, expected a multiple of 16");
  CHECK(made({0, 17}, 16, 16) == "view: the first pixel's y is 17, expected a multiple of 16");
  CHECK(made({0, -1}, 16, 16) == "view: the first pixel's y is -1, expected a multiple of 16");
  CHECK(made({96, 0}, 5, 16) ==
        "view: the frame has 5 pixels along x from 96 on, expected 1 or more within the camera's 100");
  for (const Part& outside : {Part{{0, 0}, 101, 75},
                              {{0, 0}, 100, 76},
                              {{0, 80}, 16, 1},
                              {{0, 2147483632}, 16, 2147483647},
                              {{0, 0}, 0, 16},
                              {{0, 0}, 16, -3}})
    CHECK(made(outside.first, outside.width, outside.height).find("view: the frame has ") == 0);
}

TEST_CASE("view tiles: coarse ones cover the same pixels, where a view begins at one") {
  const Camera camera = forward_camera(300, 200);
  for (const FirstPixel first : {FirstPixel{0, 0}, {32, 64}, {96, 0}, {16, 0}, {0, 48}, {48, 80}})
    for (const int size : {1, 16, 17, 33, 64, 100}) {
      CAPTURE(first.x);
      CAPTURE(first.y);
      CAPTURE(size);
      View view = make_view(camera, Conventions(), {.width = size, .height = size + 5}, vec3(0), first);
      const View fine = view;
      view.grid = coarse(fine);
      if (first.x % coarse_tile_side == 0 && first.y % coarse_tile_side == 0) {
        CHECK(view.grid.side == coarse_tile_side);
        CHECK(view.left() == first.x);
        CHECK(view.top() == first.y);
        Views(&view, 1);
        CHECK(coarse(view) == view.grid);  // no coarser
      } else {
        CHECK(view.grid == fine.grid);
      }
    }
  CHECK(coarse_tiles_gain(0, 1'500'000));
  CHECK_FALSE(coarse_tiles_gain(0, 1'499'999));
  CHECK(coarse_tiles_gain(199'999, 2'000'000));
  CHECK_FALSE(coarse_tiles_gain(200'000, 2'000'000));
}

TEST_CASE_TEMPLATE("view tiles: splats know their view and keep the order of their Gaussians in it", B,
                   SWIFTGS_TEST_HOSTS) {
  Renderer<B, EarlySort, PerPixel, Ellipse> renderer(make_backend<B>());
  const auto scene = renderer.backend().upload(random_scene(20000, 0, 4));
  const std::vector<View> views = views_without_planes(different_views());
  renderer.render_into(scene.view(), span_of(views));
  const SplatsView splats = renderer.splats().view();
  std::vector<std::size_t> of_view(views.size());
  std::vector<std::int64_t> last(views.size(), -1);
  std::size_t out_of_order = 0;
  for (std::size_t i = 0; i < splats.size(); ++i) {
    const std::uint32_t view = splats.view(i);
    REQUIRE(view < views.size());
    ++of_view[view];
    out_of_order += std::int64_t(splats.gaussians[i]) <= last[view];
    last[view] = std::int64_t(splats.gaussians[i]);
  }
  CHECK(out_of_order == 0);
  CHECK(of_view[0] > 1000);
  CHECK(of_view[2] == 0);
  CHECK(of_view[1] == of_view[3]);
  CHECK(of_view[4] > 1000);
  renderer.render_into(scene.view(), Span<const View>{views.data(), 1});
  CHECK(renderer.splats().view().of_view == nullptr);
  CHECK(renderer.statistics().visible == of_view[0]);
}

namespace {

/// Whether a rasterizer of a host visits a row of pixels of `part` for a splat.
bool visits(const SplatShape& shape, const Part& part) {
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; x += raster_block_side)
      if (row_touched(shape, float(part.first.x + x) + 0.5f, float(part.first.y + y) + 0.5f)) return true;
  return false;
}

}  // namespace

TEST_CASE("view tiles: a part of an image has every splat that the image shows there") {
  const Camera camera = bordered_camera();
  const Conventions conventions = Conventions::gsplat();
  const View whole = make_view(camera, conventions, {.width = 48, .height = 48});
  const std::vector<Part> parts = cut(48, 48, {0, 16}, {0, 16});
  std::vector<View> views;
  for (const Part& part : parts)
    views.push_back(
        make_view(camera, conventions, {.width = part.width, .height = part.height}, vec3(0), part.first));
  Random random(5);
  int missing = 0, shown = 0, elsewhere = 0;
  for (int i = 0; i < 500'000; ++i) {
    const Gaussian g = ends_near_a_border(random, whole.camera);
    const ProjectedShape splat = project_shape(whole.camera, g);
    if (!splat.visible) continue;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const bool visible = project_shape(views[p].camera, g).visible;
      shown += visible, elsewhere += !visible;
      missing += !visible && visits(splat.shape, parts[p]);
    }
  }
  CHECK(missing == 0);
  CHECK(shown > 100'000);
  CHECK(elsewhere > 100'000);
}

}  // namespace swiftgs::test::view_tiles_test
