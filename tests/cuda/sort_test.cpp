// SPDX-License-Identifier: Apache-2.0

// Tile lists from the device against the serial backend's from the same splats: bit for bit.
#include <swiftgs/builtin_scene.hpp>

#include "cuda/device.hpp"
#include "support/one_view.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// The three sorts on one backend, with memory that lives from frame to frame.
template <class B>
struct Sorts {
  StandardSort standard;
  EarlySort early;
  AdaptiveSort adaptive{1};
  StandardSort::Scratch<B> standard_scratch;
  EarlySort::Scratch<B> early_scratch;
  AdaptiveSort::Scratch<B> adaptive_scratch;
  TileLists<B> lists;

  template <class Bounds, class F>
  void for_each(B& backend, const SortJob& job, const Bounds& bounds, const F& f) {
    const auto run = [&](auto& sort, auto& scratch) {
      sort.build(backend, job, bounds, scratch, lists);
      f(sort.name, host_lists(backend, lists));
    };
    run(standard, standard_scratch), run(early, early_scratch), run(adaptive, adaptive_scratch);
  }
};

/// Whether all sorts on the device, within all bounds, build the lists of the serial backend. Returns the
/// intersections.
std::size_t check_lists(Cuda& cuda, Sorts<Cuda>& sorts, const SplatSet& splats, int width, int height) {
  const DeviceSplats uploaded(splats);
  std::size_t intersections = 0;
  for_each_type(AllBounds(), [&]<class Bounds>(Bounds bounds) {
    CAPTURE(Bounds::name);
    Serial serial;
    const HostLists expected =
        host_lists(serial, build_lists<StandardSort, Bounds>(serial, splats.job(width, height)));
    intersections = expected.ids.size();
    const Binned<Cuda, Bounds> binned(cuda, uploaded.job(width, height), bounds);
    sorts.for_each(cuda, binned.job(), bounds, [&](std::string_view name, const HostLists& lists) {
      CAPTURE(name);
      CHECK(lists == expected);
    });
  });
  return intersections;
}
std::size_t check_lists(const SplatSet& splats, int width, int height) {
  Cuda cuda;
  Sorts<Cuda> sorts;
  return check_lists(cuda, sorts, splats, width, height);
}

/// A splat that covers an image of any size.
SplatShape giant() { return make_splat(30'000, 30'000, 1e6, 1e6, 0, 1); }

}  // namespace

TEST_CASE("cuda sort: every sort within every bounds builds the lists of the serial backend") {
  if (without_device()) return;
  for (const std::size_t n : {0, 1, 2, 31, 32, 33, 255, 256, 257, 20'000}) {
    CAPTURE(n);
    check_lists(random_splats(n, 700, 500, n + 1), 700, 500);
  }
  check_lists(random_splats(300, 1, 1, 2), 1, 1);
  check_lists(random_splats(300, 33, 17, 3), 33, 17);
}

TEST_CASE("cuda sort: lists from footprints that projection found are the serial backend's") {
  if (without_device()) return;
  Cuda cuda;
  Serial serial;
  Sorts<Cuda> sorts;
  ProjectScratch<Cuda> scratch;
  Splats<Cuda> splats;
  for (const std::size_t n : {0, 100, 30'000, 1000}) {
    CAPTURE(n);
    const DeviceScene scene = cuda.upload(random_scene(n, 0, n + 1));
    const Camera camera = forward_camera(700, 500);
    const OneView frame(camera, Conventions::gsplat(), scene.view());
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds bounds) {
      CAPTURE(Bounds::name);
      Footprints<Cuda> footprints;
      project(cuda, frame.plan(), bounds, scratch, splats, footprints);
      bin(cuda, frame.plan(), bounds, splats, footprints);
      const SplatSet set = to_host(cuda, splats.view());
      const HostLists expected =
          host_lists(serial, build_lists<StandardSort, Bounds>(serial, set.job(700, 500)));
      const FrameKey key{scene.view().identity, n, 700, 500};
      sorts.for_each(cuda, SortJob{splats.view(), footprints.view(), key}, bounds,
                     [&](std::string_view name, const HostLists& lists) {
                       CAPTURE(name);
                       CHECK(lists == expected);
                     });
    });
  }
}

TEST_CASE("cuda sort: footprints are found again where projection found those of another grid or bounds") {
  if (without_device()) return;
  Cuda cuda;
  const DeviceScene scene = cuda.upload(random_scene(3000, 0, 11));
  ProjectScratch<Cuda> scratch;
  Splats<Cuda> splats;
  Footprints<Cuda> boxes;
  Footprints<Cuda> ellipses;
  const OneView frame(forward_camera(700, 500), Conventions::gsplat(), scene.view());
  const View turned = view_without_camera(500, 700);
  project(cuda, frame.plan(), OpacityBox{}, scratch, splats, boxes);
  bin(cuda, frame.plan(), Ellipse{}, splats, ellipses);
  const SplatSet set = to_host(cuda, splats.view());
  const auto found_by = [&](const auto& bounds, const Footprints<Cuda>& footprints, const View& of) {
    std::uint64_t tiles = 0;
    for (const SplatShape& shape : set.shapes) tiles += find_footprint(bounds, shape, of.grid).count;
    return footprints.intersections.most == tiles && footprints.count == set.shapes.size() &&
           footprints.views.tiles == tiles_of_frame(of) && footprints.views[0].grid == of.grid;
  };
  REQUIRE(set.shapes.size() > 100);
  CHECK(found_by(Ellipse{}, ellipses, frame.view));
  bin(cuda, frame.plan(), OpacityBox{}, splats, boxes);
  CHECK(found_by(OpacityBox{}, boxes, frame.view));
  bin(cuda, plan_without_scene({&turned, 1}), OpacityBox{}, splats, boxes);
  CHECK(found_by(OpacityBox{}, boxes, turned));

  // Footprints that were found within other bounds are found again where they lie.
  project(cuda, frame.plan(), OpacityBox{}, scratch, splats, boxes);
  bin(cuda, frame.plan(), Ellipse{}, splats, boxes);
  CHECK(found_by(Ellipse{}, boxes, frame.view));

  // Footprints that are left over from a projection are not those of other splats.
  project(cuda, frame.plan(), OpacityBox{}, scratch, splats, boxes);
  Splats<Cuda> own;
  CopySplats<Cuda>::copy(DeviceSplats(set).view(), own);
  bin(cuda, frame.plan(), OpacityBox{}, own, boxes);
  CHECK(found_by(OpacityBox{}, boxes, frame.view));
}

TEST_CASE("cuda sort: giants among dots are listed where they lie") {
  if (without_device()) return;
  for (const int at : {0, 1, 31, 32, 500, 999}) {
    CAPTURE(at);
    SplatSet splats = random_splats(1000, 1000, 700, 4);
    splats.shapes[std::size_t(at)] = giant();
    CHECK(check_lists(splats, 1000, 700) > 63 * 44);
  }
  SplatSet giants;
  for (int i = 0; i < 100; ++i) giants.add(giant(), 1.0f + float(i % 3));
  CHECK(check_lists(giants, 1000, 700) == 100 * 63 * 44);
}

TEST_CASE("cuda sort: splats of every number of tiles a side are listed where they lie") {
  if (without_device()) return;
  SplatSet splats;
  Random random(5);
  for (int i = 0; i < 2000; ++i)
    splats.add(make_splat(random.in(-100, 1100), random.in(-100, 800), random.scale(1, 80),
                          random.scale(1, 80), random.in(0, 3.14159), random.scale(1.0 / 250, 1)),
               random.f(1, 2));
  CHECK(check_lists(splats, 1000, 700) > 10'000);
}

TEST_CASE("cuda sort: equal depths keep index order") {
  if (without_device()) return;
  SplatSet splats;
  for (int i = 0; i < 5000; ++i) splats.add(make_splat(8, 8, 1, 1, 0, 0.9), i % 2 == 0 ? 2.0f : 1.0f);
  CHECK(check_lists(splats, 16, 16) == 5000);
  CHECK(check_lists(splats, 40, 40) >= 5000);
}

TEST_CASE("cuda sort: depths are ordered over the whole range of positive floats") {
  if (without_device()) return;
  SplatSet splats;
  for (const float depth : {3e38f, 1e-45f, 1e10f, 1.0000001f, 1.0f, 1e-38f, 0.01f, 2e-38f})
    splats.add(make_splat(8, 8, 1, 1, 0, 0.9), depth);
  CHECK(check_lists(splats, 16, 16) == 8);
}

TEST_CASE("cuda sort: more than 65536 tiles are told apart") {
  if (without_device()) return;
  SplatSet splats = random_splats(300, 4300, 4300, 6);
  splats.add(giant(), 1.5f), splats.add(giant(), 0.5f);
  CHECK(check_lists(splats, 4300, 4300) > 2 * 269 * 269);
  CHECK(check_lists(random_splats(300, max_image_side, 64, 7), max_image_side, 64) > 300);
  CHECK(check_lists(random_splats(300, 64, max_image_side, 8), 64, max_image_side) > 300);
}

TEST_CASE("cuda sort: views of different sizes may follow each other") {
  if (without_device()) return;
  Cuda cuda;
  Sorts<Cuda> sorts;
  struct View {
    std::size_t splats;
    int width, height;
  };
  for (const View& view : {View{300, 100, 80},
                           {3000, 1300, 900},
                           {3000, 1300, 900},
                           {10, 16, 16},
                           {0, 300, 200},
                           {20'000, 640, 480},
                           {2000, 1920, 1080},
                           {300, 1, 1}}) {
    CAPTURE(view.width);
    const SplatSet splats = random_splats(view.splats, view.width, view.height, view.splats + 1);
    for (int frame = 0; frame < 3; ++frame) check_lists(cuda, sorts, splats, view.width, view.height);
  }
}

TEST_CASE("cuda sort: more intersections than lists can index are a capacity error after which all works") {
  if (without_device()) return;
  Cuda cuda;
  Sorts<Cuda> sorts;
  const SplatSet usual = random_splats(1000, 300, 200, 9);
  check_lists(cuda, sorts, usual, 300, 200);
  SplatSet flood;
  for (int i = 0; i < 129; ++i) flood.add(make_splat(0, 0, 1e6, 1e6, 0, 1), 1);
  const DeviceSplats uploaded(flood);
  const SortInput job = uploaded.job(max_image_side, max_image_side);
  for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
    const auto refuse = [&](auto& sort, auto& scratch) {
      CHECK_THROWS_AS(build_again<Bounds>(cuda, sort, job, scratch, sorts.lists), CapacityError);
    };
    refuse(sorts.standard, sorts.standard_scratch), refuse(sorts.early, sorts.early_scratch);
    refuse(sorts.adaptive, sorts.adaptive_scratch);
  });
  check_lists(cuda, sorts, usual, 300, 200);
}

TEST_CASE("cuda sort: an adaptive sort decides after some frames and without waiting for them") {
  if (without_device()) return;
  Cuda cuda;
  const DeviceSplats splats(random_splats(20'000, 640, 480, 10));
  AdaptiveSort sort(3);
  AdaptiveSort::Scratch<Cuda> scratch;
  TileLists<Cuda> lists;
  int frames = 0;
  for (; !sort.calibration() && frames < 200; ++frames) {
    build_again<Ellipse>(cuda, sort, splats.job(640, 480), scratch, lists);
    if (frames >= 100) check_cuda(cudaStreamSynchronize(cuda.stream()), "cudaStreamSynchronize");
  }
  REQUIRE(sort.calibration());
  CHECK(sort.calibration()->standard_ms > 0);
  CHECK(sort.calibration()->early_ms > 0);
}
