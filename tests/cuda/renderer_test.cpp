// SPDX-License-Identifier: Apache-2.0

// Whole frames from the device: the order of its raster blocks and its coarser tiles.
#include <string_view>
#include <utility>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>

#include "cuda/device.hpp"
#include "policies/views.hpp"

namespace swiftgs::test {
namespace {
constexpr std::string_view backends[] = {"cuda"};
bool unavailable() { return without_device(); }
}  // namespace
}  // namespace swiftgs::test

#define SWIFTGS_PARITY "cuda renderer"
#include "parity/parity_cases.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Calls f(together, alone) with two renderers of each rasterizer.
template <class F>
void for_each_raster_renderer(const F& f) {
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    Usual<Cuda, EarlySort, Raster> together, alone;
    f(together, alone);
  });
}

/// Side of the tiles of large images with few splats.
template <class Sort, class Raster, class Bounds>
int side_of_large(const Renderer<Cuda, Sort, Raster, Bounds>&) {
  return may_gain_by_coarse_tiles<Cuda, Raster> ? coarse_tile_side : default_tile_side;
}
// Rasterizers that evaluate each listed splat at every pixel keep fine tiles.
static_assert(!may_gain_by_coarse_tiles<Cuda, PerPixel> &&
              !may_gain_by_coarse_tiles<Cuda, AxisShared<HalfSplit>> &&
              !may_gain_by_coarse_tiles<Cuda, AxisSharedThreshold<HalfSplit>>);

}  // namespace

SWIFTGS_DEVICE_CASE("cuda renderer: a large image with few splats has the same bits by coarser tiles") {
  Usual<Cuda> renderer;
  const auto scene = renderer.backend().upload(random_scene(4000, 0, 3));
  const auto tiles_of = [&](auto& by, const Camera& camera, const auto& of) {
    const Frame frame = by.render(of, camera);
    CHECK(by.lists().tiles == by.tiles().size());
    return std::pair{frame, by.tiles()};
  };
  const Camera large = forward_camera(1600, 1000);
  const auto [first, fine] = tiles_of(renderer, large, scene);
  const auto [second, coarse] = tiles_of(renderer, large, scene);
  CHECK(fine == FrameTiles{100, 63, 16});
  CHECK(coarse == FrameTiles{50, 32, 32});
  CHECK(same_bits(first.colour, second.colour));

  // Not after a frame of another size, nor in a small image, nor where bounds cut splats at tiles.
  const Camera small = forward_camera(320, 200);
  for (int i = 0; i < 2; ++i) CHECK(tiles_of(renderer, small, scene).second == FrameTiles{20, 13, 16});
  CHECK(tiles_of(renderer, large, scene).second == fine);
  Usual<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, ThreeSigmaSquare> cutting;
  const auto again = cutting.backend().upload(random_scene(4000, 0, 3));
  for (int i = 0; i < 2; ++i) CHECK(tiles_of(cutting, large, again).second == fine);
}

SWIFTGS_DEVICE_CASE(
    "cuda renderer: an image whose raster blocks are put in an order has the bits that it has among too many "
    "for it") {
  for_each_raster_renderer([&](auto& together, auto& alone) {
    const DeviceScene scene = together.backend().upload(random_scene(3000, 1, 9));
    // On devices of up to 300 multiprocessors one view has raster blocks enough for an order, and on those of
    // up to 190 five have too many.
    const std::vector<AskedView> views(5, AskedView{forward_camera(1000, 700)});
    check_views(together, alone, scene.view(), views);
    check_views(together, alone, scene.view(), {views[0], views[1]});
  });
}

SWIFTGS_DEVICE_CASE("cuda renderer: large images have the bits of finer tiles, alone and among others") {
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
      const std::vector<PlanesMemory> before = draw_together(together, scene.view(), views);
      CHECK(differing(draw_together(together, scene.view(), views), before) == 0);
      return together.tiles().side;
    };
    CHECK(side_beside_part({16, 32}) == 16);
    CHECK(side_after({small}) == 16);
    CHECK(side_beside_part({32, 64}) == large_side);
  });
}
