// SPDX-License-Identifier: Apache-2.0

// Frames of several views on a device: the order of its raster blocks, its coarser tiles, its footprints.
#include "policies/views.hpp"

#include <cstdint>
#include <vector>

#include "cuda/device.hpp"
#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Calls f(together, alone) with two renderers of each rasterizer.
template <class F>
void for_each_raster_renderer(const F& f) {
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    Renderer<Cuda, EarlySort, Raster, Ellipse> together, alone;
    f(together, alone);
  });
}

}  // namespace

TEST_CASE(
    "cuda views: an image whose raster blocks are put in an order has the bits that it has among too many "
    "for it") {
  if (without_device()) return;
  for_each_raster_renderer([&](auto& together, auto& alone) {
    const DeviceScene scene = together.backend().upload(random_scene(3000, 1, 9));
    // On devices of up to 300 multiprocessors one view has raster blocks enough for an order, and on those of
    // up to 190 five have too many.
    const std::vector<AskedView> views(5, AskedView{forward_camera(1000, 700)});
    check_views(together, alone, scene.view(), views);
    check_views(together, alone, scene.view(), {views[0], views[1]});
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
      check_views(together, alone, scene.view(), views);
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
        PlacedViews placed(together.backend(), views);
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
