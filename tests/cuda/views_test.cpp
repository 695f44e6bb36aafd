// SPDX-License-Identifier: Apache-2.0

// Frames of several views and of parts of an image, on a device.
#include "cuda/views.hpp"

#include <cstdint>
#include <vector>

#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

using Usual = Renderer<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>;

/// Calls f(together, alone) with two renderers of each rasterizer.
template <class F>
void for_each_raster_renderer(const F& f) {
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    Renderer<Cuda, EarlySort, Raster, Ellipse> together, alone;
    f(together, alone);
  });
}

/// Calls f(together, alone) with two renderers of each sort within each bounds.
template <class F>
void for_each_lists_renderer(const F& f) {
  for_each_type(AllSorts(), [&]<class Sort>(Sort) {
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
      CAPTURE(Sort::name);
      CAPTURE(Bounds::name);
      Renderer<Cuda, Sort, AxisSharedThreshold<FloatCholesky>, Bounds> together, alone;
      f(together, alone);
    });
  });
}

}  // namespace

TEST_CASE("cuda views: a frame of several has the bits of each view alone with every rasterizer") {
  if (without_device()) return;
  const Scene scene = random_scene(400, 2, 1);
  for_each_raster_renderer([&](auto& together, auto& alone) {
    const DeviceScene uploaded = together.backend().upload(scene);
    check_lists_of_views<OnDevice>(together, alone, uploaded.view());
  });
}

TEST_CASE("cuda views: a frame of several has the bits of each view alone with every sort and bounds") {
  if (without_device()) return;
  const Scene scene = random_scene(20'000, 1, 2);
  for_each_lists_renderer([&](auto& together, auto& alone) {
    const DeviceScene uploaded = together.backend().upload(scene);
    check_lists_of_views<OnDevice>(together, alone, uploaded.view());
  });
}

TEST_CASE("cuda views: every list of a view is that of the view alone with each sort and bounds") {
  if (without_device()) return;
  for (const std::size_t gaussians : {2000, 50'000}) {
    const Scene scene = random_scene(gaussians, 0, 3);
    for_each_lists_renderer([&](auto& together, auto& alone) {
      const DeviceScene uploaded = together.backend().upload(scene);
      check_lists(together, alone, uploaded.view());
    });
  }
}

TEST_CASE("cuda views: the parts of an image have the bits of the image") {
  if (without_device()) return;
  const Scene scene = random_scene(400, 1, 4);
  for_each_raster_renderer([&](auto& renderer, auto&) {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    check_bands<OnDevice>(renderer, uploaded.view());
  });
  for_each_lists_renderer([&](auto& renderer, auto&) {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    check_bands<OnDevice>(renderer, uploaded.view());
  });
}

TEST_CASE("cuda views: parts show the pixels that rounding keeps beyond the box of a splat") {
  if (without_device()) return;
  const AskedView asked{bordered_camera()};
  const std::vector<Part> parts = cut(48, 48, {0, 16}, {0, 16});
  for_each_raster_renderer([&](auto& renderer, auto&) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const DeviceScene scene = renderer.backend().upload(bordered_scene(2000, seed));
      check_parts<OnDevice>(renderer, scene.view(), asked, parts);
    }
  });
}

TEST_CASE("cuda views: one wide view among fifty small ones has the bits of each alone") {
  if (without_device()) return;
  Usual together, alone;
  const DeviceScene scene = together.backend().upload(random_scene(300, 1, 5));
  check_views<OnDevice>(together, alone, scene.view(), one_wide_among_small());
}

TEST_CASE("cuda views: three hundred tiny views have the bits of each alone") {
  if (without_device()) return;
  for_each_raster_renderer([&](auto& together, auto& alone) {
    const DeviceScene scene = together.backend().upload(random_scene(100, 1, 6));
    check_views<OnDevice>(together, alone, scene.view(), tiny_views());
  });
}

TEST_CASE("cuda views: thirty-three thousand tiny views have the bits of each alone") {
  if (without_device()) return;
  for_each_raster_renderer([&](auto& renderer, auto&) {
    const DeviceScene scene = renderer.backend().upload(random_scene(10, 1, 7));
    check_many_rows(renderer, scene);
  });
}

TEST_CASE(
    "cuda views: an image whose raster blocks are put in an order has the bits that it has among too many "
    "for it") {
  if (without_device()) return;
  for_each_raster_renderer([&](auto& together, auto& alone) {
    const DeviceScene scene = together.backend().upload(random_scene(3000, 1, 9));
    // On devices of up to 300 multiprocessors one view has raster blocks enough for an order, and on those of
    // up to 190 five have too many.
    const std::vector<AskedView> views(5, AskedView{forward_camera(1000, 700)});
    check_views<OnDevice>(together, alone, scene.view(), views);
    check_views<OnDevice>(together, alone, scene.view(), {views[0], views[1]});
  });
}

/// Side of the tiles of large images with few splats.
template <class Sort, class Raster, class Bounds>
int side_of_large(const Renderer<Cuda, Sort, Raster, Bounds>&) {
  return may_gain_by_coarse_tiles<Cuda, Raster> ? coarse_tile_side : default_tile_side;
}

TEST_CASE("cuda views: large images have the bits of finer tiles, alone and among others") {
  if (without_device()) return;
  for_each_raster_renderer([&](auto& together, auto& alone) {
    const DeviceScene scene = together.backend().upload(random_scene(2000, 1, 10));
    const AskedView large{forward_camera(1601, 1003)}, small{turned_camera(100, 75, 0.1, 0.05)};
    const auto side_after = [&](const std::vector<AskedView>& views) {
      check_views<OnDevice>(together, alone, scene.view(), views);
      return together.tiles().side;
    };
    const int large_side = side_of_large(together);
    CHECK(side_after({large}) == large_side);
    CHECK(side_after({small, large}) == large_side);

    // The first frame has finer tiles, and so has the second where a part begins within a coarser one.
    const auto side_beside_part = [&](FirstPixel first) {
      AskedView part{forward_camera(200, 150)};
      part.first = first, part.width = 70, part.height = 50;
      const std::vector<AskedView> views{large, part};
      std::vector<PlanesMemory> drawn[2];
      for (std::vector<PlanesMemory>& memories : drawn) {
        PlacedViews<OnDevice> placed(views);
        together.render_into(scene.view(), placed.span());
        memories = placed.finish(together.backend());
      }
      CHECK(differing(drawn[1], drawn[0]) == 0);
      return together.tiles().side;
    };
    CHECK(side_beside_part({16, 32}) == 16);
    CHECK(side_after({small}) == 16);
    CHECK(side_beside_part({32, 64}) == large_side);
  });
}

TEST_CASE("cuda views: several views of an empty scene are their backgrounds") {
  if (without_device()) return;
  Usual together, alone;
  const DeviceScene scene = together.backend().upload(Scene());
  check_views<OnDevice>(together, alone, scene.view(), different_views());
}

TEST_CASE("cuda views: a frame that is refused leaves the renderer usable") {
  if (without_device()) return;
  Usual together, alone;
  const DeviceScene scene = together.backend().upload(random_scene(100, 1, 8));
  CHECK_THROWS_AS(together.render_into(scene.view(), Span<const View>{}), std::invalid_argument);
  const Camera huge = forward_camera(max_image_side, max_image_side);
  const std::vector<View> views(129,
                                make_view(huge, Conventions(), {.width = huge.width, .height = huge.height}));
  CHECK_THROWS_AS(together.render_into(scene.view(), Span<const View>{views.data(), views.size()}),
                  CapacityError);
  check_views<OnDevice>(together, alone, scene.view(), different_views());
}

TEST_CASE(
    "cuda views: footprints of several views are found again where projection found those of other bounds") {
  if (without_device()) return;
  Cuda cuda;
  const DeviceScene scene = cuda.upload(random_scene(3000, 0, 9));
  std::vector<View> asked;
  for (const AskedView& view : different_views())
    asked.push_back(
        make_view(view.camera, view.conventions, {.width = view.camera.width, .height = view.camera.height}));
  ViewStorage<Cuda> storage;
  const Views views = store_views(cuda, Span<const View>{asked.data(), asked.size()}, storage);
  const FramePlan plan(views, scene.view());
  ProjectScratch<Cuda> scratch;
  Splats<Cuda> splats;
  Footprints<Cuda> boxes;
  Footprints<Cuda> ellipses;
  project(cuda, plan, OpacityBox{}, scratch, splats, boxes);
  bin(cuda, plan, Ellipse{}, splats, ellipses);
  const SplatsView found = splats.view();
  REQUIRE(found.size() > 500);
  const std::vector<SplatShape> shapes = to_host(cuda, found.shapes);
  const std::vector<std::uint16_t> of_view =
      to_host(cuda, Span<const std::uint16_t>{found.of_view, found.size()});
  const std::vector<Footprint> footprints = to_host(cuda, ellipses.view().each);
  REQUIRE(footprints.size() == shapes.size());
  std::uint64_t intersections = 0;
  std::size_t different = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Footprint expected = find_footprint(Ellipse{}, shapes[i], views[of_view[i]].grid);
    intersections += expected.count;
    different += footprints[i].count != expected.count || footprints[i].mask != expected.mask ||
                 (expected.count != 0 && footprints[i].first != expected.first);
  }
  CHECK(different == 0);
  CHECK(ellipses.intersections.most == intersections);
}
