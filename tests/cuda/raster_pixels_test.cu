// SPDX-License-Identifier: Apache-2.0

// The form of rasterizers without kernels of their own: the tests of rasterizers with the scalar kernels of
// the library, and a rasterizer that the library does not know.
#include <swiftgs/cuda.cuh>
#include <swiftgs/metrics.hpp>
#include <swiftgs/renderer.hpp>

#include "cuda/device.hpp"
#include "policies/image_parts.hpp"
#include "policies/views.hpp"

#define SWIFTGS_TEST_RASTER_PIXELS
#include "policies/blending_test.cpp"

namespace swiftgs::test::blending_test {

namespace {

/// A rasterizer of the caller, of which no backend knows more than the scalar form.
struct HalfAsOpaque {
  static constexpr std::string_view name = "half-as-opaque";
  class Kernel {
   public:
    SWIFTGS_HD Kernel(const SplatShape& shape, vec2 first_centre, BlendRules rules)
        : whole_(shape, first_centre, rules) {}
    SWIFTGS_HD void start_row(float y) { whole_.start_row(y); }
    SWIFTGS_HD float alpha(int column) const { return 0.5f * whole_.alpha(column); }

   private:
    PerPixel::Kernel whole_;
  };
};
static_assert(RastersOn<HalfAsOpaque, Serial> && RastersOn<HalfAsOpaque, Cpu> &&
              RastersOn<HalfAsOpaque, Cuda>);

/// Terms of the caller: circles.
struct Round {
  static constexpr std::string_view name = "round";
  struct X {
    float square;
  };
  struct Y {
    float square;
  };
  SWIFTGS_HD Round(const SplatShape& s, vec2) : shape_(s), factor_(s.l0 * s.l2) {}
  SWIFTGS_HD X x_term(float at) const {
    return {factor_ * shape_.right_of_mean(at) * shape_.right_of_mean(at)};
  }
  SWIFTGS_HD Y y_term(float at) const { return {factor_ * shape_.below_mean(at) * shape_.below_mean(at)}; }
  SWIFTGS_HD static float exponent(X x, Y y) { return x.square + y.square; }

 private:
  const SplatShape& shape_;
  float factor_;
};
static_assert(RastersOn<AxisShared<Round>, Serial> && RastersOn<AxisSharedThreshold<Round>, Cpu> &&
              RastersOn<AxisSharedThreshold<Round>, Cuda>);

template <class Raster>
void check_on_all_backends(const SplatSet& splats, int width) {
  CAPTURE(Raster::name);
  Cuda cuda;
  check_against_serial(cuda, BoundRaster<Cuda>::of<Raster>(), splats, width, 60);
  Serial serial;
  Cpu cpu(2);
  const Drawing expected = draw<Raster>(serial, splats, width, 60);
  REQUIRE(expected.counts.contributing_pairs > 1000);
  const Drawing on_cpu = draw<Raster>(cpu, splats, width, 60);
  CHECK(on_cpu.frame.colour == expected.frame.colour);
  CHECK(on_cpu.counts.contributing_pairs == expected.counts.contributing_pairs);
}

}  // namespace

SWIFTGS_DEVICE_CASE("cuda raster pixels: rasterizers and terms of the caller draw what hosts draw") {
  for (const int width : {40, 200}) {
    const SplatSet splats = usual_splats(1000, width, 60, 21);
    check_on_all_backends<HalfAsOpaque>(splats, width);
    check_on_all_backends<AxisShared<Round>>(splats, width);
    check_on_all_backends<AxisSharedThreshold<Round>>(splats, width);
  }
}

SWIFTGS_DEVICE_CASE(
    "cuda raster pixels: a rasterizer of the caller draws several views as it draws each alone") {
  Renderer<Cuda, EarlySort, HalfAsOpaque, Ellipse> together, alone;
  const DeviceScene scene = together.backend().upload(random_scene(400, 1, 25));
  check_lists_of_views(together, alone, scene.view());
  check_bands(together, scene.view());
  check_many_rows(together, scene);
}

SWIFTGS_DEVICE_CASE("cuda raster pixels: a rasterizer of the caller draws every plane") {
  const Scene scene = with_features(random_scene(2000, 1, 22), 20);
  const Camera camera = forward_camera(170, 90);
  for (const auto depth_at : {Conventions::DepthAt::centre, Conventions::DepthAt::ray}) {
    RenderSettings settings;
    settings.outputs = all_planes(20);
    settings.conventions.depth_at = depth_at;
    const auto draw = [&]<class B>(B backend) {
      Renderer<B, EarlySort, HalfAsOpaque, Ellipse> renderer(std::move(backend));
      return renderer.render(renderer.backend().upload(scene), camera, settings);
    };
    const Frame serial = draw(Serial()), drawn = draw(Cuda());
    const auto part_differing = [&](const auto& a, const auto& b) {
      std::size_t differing = 0;
      for (std::size_t i = 0; i < a.size(); ++i)
        differing += !(std::abs(double(a[i]) - double(b[i])) <= 1e-4 * std::abs(double(b[i])));
      return double(differing) / double(a.size());
    };
    for_each_plane(
        [&]<class T>(std::size_t, const std::vector<T>& a, const std::vector<T>& b, const PlaneRow& row) {
          CAPTURE(row.name);
          if constexpr (std::is_same_v<T, float>)
            if (row.accumulator == Accumulator::sum) CHECK(psnr(a, b) > 60);
          if (row.accumulator != Accumulator::sum) CHECK(part_differing(a, b) < 0.001);
        },
        drawn, serial, plane_table);
  }
}

SWIFTGS_DEVICE_CASE("cuda raster pixels: counts are the host's where no threshold is near") {
  // Each leaves a fifth, so that the sixth that shows ends every pixel. Two are colourless.
  SplatSet splats;
  for (int i = 0; i < 20; ++i) splats.add(make_splat(10, 5, 3000, 3000, 0, 0.8), float(1 + i));
  splats.colours[0] = splats.colours[3] = SplatColour{};
  Cuda cuda;
  const RasterCounts counts = draw<HalfAsOpaque>(cuda, splats, 20, 9).counts,
                     whole = draw<Tested<PerPixel>>(cuda, splats, 20, 9).counts;
  CHECK(whole.intersections_visited == 2 * 6);
  CHECK(whole.rows_visited == 2 * 6 * 9);
  CHECK(whole.contributing_pairs == 5 * 20 * 9);
  CHECK(whole.pixels_stopped == 20 * 9);
  Serial serial;
  const RasterCounts expected = draw<HalfAsOpaque>(serial, splats, 20, 9).counts;
  CHECK(counts.intersections_visited == expected.intersections_visited);
  CHECK(counts.rows_visited == expected.rows_visited);
  CHECK(counts.contributing_pairs == expected.contributing_pairs);
  CHECK(counts.pixels_stopped == expected.pixels_stopped);
}

SWIFTGS_DEVICE_CASE("cuda raster pixels: a splat behind the caller's surface ends the pixel") {
  const SplatSet splats = usual_splats(2000, 90, 50, 23);
  DrawSettings settings;
  Random random(24);
  for (int i = 0; i < 90 * 50; ++i) settings.occluder.push_back(random.f(0, 30));
  Serial serial;
  const Drawing expected = draw<HalfAsOpaque>(serial, splats, 90, 50, settings);
  REQUIRE(expected.counts.pixels_stopped > 1000);
  Cuda cuda;
  const Frame frame = draw<HalfAsOpaque>(cuda, splats, 90, 50, settings).frame;
  CHECK(difference(frame.colour, expected.frame.colour, 2e-5).part_above <= 0.001);
  CHECK(difference(frame.alpha, expected.frame.alpha, 2e-5).part_above <= 0.001);
}

SWIFTGS_DEVICE_CASE("cuda raster: raster blocks come in the order of their lists, the longest first") {
  Cuda cuda;
  const auto multiprocessors = std::uint32_t(cuda.multiprocessors());
  for (const int side : {16, 32, 64}) {
    CAPTURE(side);
    const auto of_tile = std::uint32_t(side / raster_block_side);
    const FrameTiles tiles{4, 5 * multiprocessors / (of_tile * of_tile) + 1, side};
    const RasterBlocks blocks(tiles);
    std::vector<TileRange> lists(tiles.size());
    Random random{std::uint64_t(side)};
    for (TileRange& list : lists) {
      const auto begin = std::uint32_t(random.bits() % 1000),
                 length = std::uint32_t(random.scale(1, 1e5)) - 1;
      list = length % 7 == 5 ? TileRange::undrawn() : TileRange{begin, begin + length};
    }
    const DeviceBuffer<TileRange> ranges = to_device(lists);
    const std::uint32_t* const order = kernels::order_raster_blocks(cuda, {{}, ranges.span()}, blocks);
    REQUIRE(order);
    const std::vector<std::uint32_t> words = to_host(cuda, Span<const std::uint32_t>{order, blocks.size()});
    std::vector<bool> seen(blocks.size());
    // Every 16th is in order: each block orders a share.
    constexpr std::size_t shares = 16;
    std::vector<double> least_before(shares, 1e9);
    bool each_once = true, descending = true;
    for (std::size_t i = 0; i < words.size(); ++i) {
      const std::uint32_t word = words[i];
      const std::uint32_t column = word & 0xffff, row = word >> 16;
      each_once =
          each_once && column < blocks.columns && row < blocks.rows && !seen[row * blocks.columns + column];
      if (!each_once) break;
      seen[row * blocks.columns + column] = true;
      const TileRange list = lists[row / of_tile * tiles.columns + column / of_tile];
      const double length = list.drawn() ? list.end - list.begin : 0;
      double& least = least_before[i % shares];
      descending = descending && length <= 1.25 * least;
      least = std::min(least, length);
    }
    CHECK(each_once);
    CHECK(descending);
  }
  // Neither as many as begin at once, nor more than eight times as many.
  for (const std::uint32_t count : {9 * multiprocessors, 72 * multiprocessors + 1}) {
    const DeviceBuffer<TileRange> ranges = to_device(std::vector<TileRange>(count));
    CHECK(kernels::order_raster_blocks(cuda, {{}, ranges.span()}, RasterBlocks({1, count})) == nullptr);
  }
  for (const std::uint32_t count : {9 * multiprocessors + 1, 72 * multiprocessors}) {
    const DeviceBuffer<TileRange> ranges = to_device(std::vector<TileRange>(count));
    CHECK(kernels::order_raster_blocks(cuda, {{}, ranges.span()}, RasterBlocks({1, count})) != nullptr);
  }
}

}  // namespace swiftgs::test::blending_test
