// SPDX-License-Identifier: Apache-2.0

// Loops, bounds and rasterizers that the library does not know.

#include <swiftgs/cuda.cuh>
#include <swiftgs/renderer.hpp>

#include "cuda/device.hpp"
#include "policies/views.hpp"
#include "support/one_view.hpp"

namespace swiftgs::test {

/// Counts each visit; an index that is out of range counts at the end.
struct Visit {
  std::uint32_t* visits;
  std::size_t n;
  SWIFTGS_HD void operator()(std::size_t i) const { ++visits[i < n ? i : n]; }
};

/// Bounds of other tiles in the kernel that emits large splats than where tiles are counted.
struct Fickle {
  static constexpr std::string_view name = "fickle";
  static constexpr bool conservative = false;
  int counted = 0, emitted = 0;  ///< columns of a row

  struct Tiles {
    TileRect rect;
    int counted, emitted;

    SWIFTGS_HD TileRun row(int) const {
#if defined(__CUDA_ARCH__)
      if (gridDim.x == kernels::emit_large_blocks) return {1, 1 + emitted};
#endif
      return {1, 1 + counted};
    }
  };
  SWIFTGS_HD Tiles tiles(const SplatShape&, TileGrid grid) const {
    return {{grid.columns, grid.rows}, counted, emitted};
  }
};

/// A rasterizer of the caller with an overload of its own and no scalar form: how many splats are listed for
/// a pixel's tile.
struct ListLengths {
  static constexpr std::string_view name = "list-lengths";
};
struct WriteLength {
  RasterJob job;
  View view;
  SWIFTGS_HD void operator()(std::size_t pixel) const {
    const std::size_t width = std::size_t(view.frame.width), x = pixel % width, y = pixel / width;
    const TileRange range = job.lists.ranges[view.grid.tile_at(int(x), int(y))];
    BlendedPixel length;
    length.colour = vec3(float(range.end - range.begin));
    store_pixel(view.frame, x, y, length, view.background);
  }
};
void rasterize(Cuda& cuda, ListLengths, const RasterJob& job) {
  raster_blocks_of(job);
  const View& view = job.views[0];
  cuda.for_each(std::size_t(view.frame.width) * std::size_t(view.frame.height), WriteLength{job, view});
}
static_assert(RastersOn<ListLengths, Cuda> && !RastersOn<ListLengths, Serial>);

/// The same with a scalar form, to which a device prefers the overload.
struct ListLengthsOrAlphas {
  static constexpr std::string_view name = "list-lengths-or-alphas";
  using Kernel = PerPixel::Kernel;
};
void rasterize(Cuda& cuda, ListLengthsOrAlphas, const RasterJob& job) { rasterize(cuda, ListLengths(), job); }
static_assert(RastersOn<ListLengthsOrAlphas, Cuda> && RastersOn<ListLengthsOrAlphas, Serial>);

}  // namespace swiftgs::test

using namespace swiftgs;
using namespace swiftgs::test;

SWIFTGS_DEVICE_CASE("cuda: for_each visits each index exactly once") {
  const Cuda cuda;
  for (const std::size_t n : {0, 1, 2, 255, 256, 257, 100'000, 1'000'001}) {
    CAPTURE(n);
    DeviceBuffer<std::uint32_t> visits = to_device(std::vector<std::uint32_t>(n + 1));
    cuda.for_each(n, Visit{visits.data(), n});
    std::vector<std::uint32_t> expected(n, 1);
    expected.push_back(0);
    CHECK(same_bits(to_host(cuda, std::as_const(visits).span()), expected));
  }
}

SWIFTGS_DEVICE_CASE("cuda: every sort takes bounds of the caller") {
  Cuda cuda;
  Serial serial;
  const SplatSet splats = random_splats(3000, 600, 400, 8);
  const SplatsOn<Cuda> uploaded(cuda, splats);
  const HostLists expected =
      host_lists(serial, build_lists<StandardSort, EvenRows>(serial, splats.job(600, 400)));
  REQUIRE(!expected.ids.empty());
  for_each_type(AllSorts(), [&]<class Sort>(Sort) {
    CHECK(host_lists(cuda, build_lists<Sort, EvenRows>(cuda, uploaded.job(600, 400))) == expected);
  });
}

SWIFTGS_DEVICE_CASES("cuda: a large splat has as many intersections as were counted and no list has it twice",
                     Sort, StandardSort, EarlySort) {
  Cuda cuda;
  for (const int splats : {1, 40})
    for (const int counted : {1, 5, 30})
      for (const int emitted : {0, 1, 5, 31}) {
        CAPTURE(splats);
        CAPTURE(counted);
        CAPTURE(emitted);
        SplatSet set;
        for (int i = 0; i < splats; ++i) set.add(make_splat(250, 200, 90, 90, 0, 0.5), float(1 + i % 5));
        const SplatsOn<Cuda> uploaded(cuda, set);
        const SortInput job = uploaded.job(512, 400);
        REQUIRE(job.grid.columns.size() == 32);
        const Fickle bounds{counted, emitted};
        typename Sort::template Scratch<Cuda> scratch;
        TileLists<Cuda> lists;
        const Binned<Cuda, Fickle> binned(cuda, job, bounds);
        Sort().build(cuda, binned.job(), bounds, scratch, lists);
        const HostLists found = host_lists(cuda, lists);
        const auto each = std::size_t(counted * job.grid.rows.size());
        REQUIRE(found.ids.size() == std::size_t(splats) * each);
        CHECK(lists_each(to_vectors(found.view()), std::size_t(splats), each));
      }
}

SWIFTGS_DEVICE_CASE("cuda: projection takes bounds of the caller") {
  Cuda cuda;
  const Scene scene = random_scene(2000, 0, 9);
  const DeviceScene uploaded = cuda.upload(scene);
  const OneView frame(forward_camera(300, 200), Conventions::gsplat(), uploaded.view());
  ProjectScratch<Cuda> scratch;
  Splats<Cuda> splats;
  Footprints<Cuda> footprints;
  project(cuda, frame.plan(), EvenRows{}, scratch, splats, footprints);
  bin(cuda, frame.plan(), EvenRows{}, splats, footprints);
  const SplatSet set = to_host(cuda, splats.view());
  REQUIRE(set.shapes.size() > 100);
  std::uint64_t tiles = 0;
  for (const SplatShape& shape : set.shapes)
    tiles += find_footprint(EvenRows{}, shape, frame.view.grid).count;
  CHECK(footprints.intersections.most == tiles);
}

SWIFTGS_DEVICE_CASES("cuda: bounds of the caller list several views as they list each alone", Sort,
                     StandardSort, EarlySort) {
  Renderer<Cuda, Sort, PerPixel, EvenRows> together, alone;
  const DeviceScene scene = together.backend().upload(random_scene(20'000, 0, 11));
  check_lists(together, alone, scene.view());
}

SWIFTGS_DEVICE_CASES("cuda: a renderer takes the overload of a rasterizer of the caller", Raster, ListLengths,
                     ListLengthsOrAlphas) {
  Renderer<Cuda, EarlySort, Raster, Ellipse> renderer;
  const Camera camera = forward_camera(70, 50);
  const Frame frame = renderer.render(renderer.backend().upload(random_scene(400, 1, 10)), camera);
  const std::vector<TileRange> ranges = to_host(renderer.backend(), renderer.lists().view().ranges);
  REQUIRE(ranges.size() == 5 * 4);
  REQUIRE(renderer.lists().intersections > 100);
  int apart = 0;
  for (std::size_t pixel = 0; pixel < frame.pixels(); ++pixel) {
    const TileRange& range = ranges[pixel / 70 / 16 * 5 + pixel % 70 / 16];
    apart += frame.colour[3 * pixel] != float(range.end - range.begin);
  }
  CHECK(apart == 0);
}
