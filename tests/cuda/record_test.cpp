// SPDX-License-Identifier: Apache-2.0

// Frames that are recorded into a CUDA graph and run again: the same bits as frames that the host renders.
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>

#include "cuda/device.hpp"
#include "cuda/graph.hpp"
#include "policies/hooked.hpp"
#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

constexpr int width = 150, height = 100;

/// One view as floats with depth, and one of another size as bytes, or the first alone. From `k` to `k`
/// cameras, conventions and backgrounds change.
std::vector<AskedView> frame_of(int k, std::size_t views = 2) {
  static const std::vector<Camera> large = builtin_cameras(24, width, height),
                                   small = builtin_cameras(24, 77, 61);
  AskedView a{large[std::size_t(k) % 24], k % 5 == 4 ? Conventions::inria() : Conventions::gsplat(),
              vec3(0.1f * float(k % 7), 0.5f, 1)};
  AskedView b{small[std::size_t(3 * k + 5) % 24], Conventions::gsplat(), vec3(float(k % 2)),
              PixelFormat::rgba_8};
  a.alpha = b.alpha = b.depth = false;
  return views == 1 ? std::vector{a} : std::vector{a, b};
}

/// A renderer whose frames are recorded and one that renders the same views, on one stream.
template <class R = Usual<Cuda>>
struct Recording {
  Stream stream;
  R renderer{Cuda(stream.get())}, other{Cuda(stream.get())};
  Cuda& cuda = renderer.backend();
  DeviceScene scene;
  std::optional<PlacedViews<Cuda>> reserved;
  Report<Cuda> report;

  explicit Recording(const Scene& of = make_builtin_scene(4000)) : scene(cuda.upload(of)) {}

  /// The recorded frame as a graph.
  Graph capture(const std::vector<AskedView>& asked, const Capacity& capacity = {8000, 200'000}) {
    reserved.emplace(cuda, asked);
    renderer.reserve(scene.view(), reserved->span(), capacity);
    return Graph(stream, [&] { renderer.record(scene.view(), report.data()); });
  }
  /// Runs the graph with these views in new memory.
  void run(const Graph& graph, const PlacedViews<Cuda>& views) {
    renderer.set_views(views.span());
    graph.run();
  }
  /// The views that differ from those that the other one renders.
  std::size_t wrong(PlacedViews<Cuda>& drawn, const std::vector<AskedView>& asked) {
    return differing(drawn.finish(cuda), draw_together(other, scene.view(), asked));
  }
  std::size_t wrong_in_run(const Graph& graph, const std::vector<AskedView>& asked) {
    PlacedViews<Cuda> views(cuda, asked);
    run(graph, views);
    return wrong(views, asked);
  }
  /// Whether the last report is of the frame that the other one rendered last.
  bool reported() const {
    const FrameReport found = report.get(cuda);
    const Statistics taken = other.statistics();
    return found.overflowed == 0 && found.visible == taken.visible &&
           found.intersections == taken.intersections;
  }
};

/// Records a frame of asked(0) and runs it with the views of asked(k) for each k. Returns the views that
/// differ from those of frames that the host renders, and the frames whose report does.
template <class R, class Asked>
std::size_t wrong_in_replays(Recording<R>& r, int replays, const Asked& asked, const Capacity& capacity) {
  const Graph graph = r.capture(asked(0), capacity);
  std::size_t wrong = 0;
  for (int k = 0; k < replays; ++k) {
    wrong += r.wrong_in_run(graph, asked(k));
    wrong += !r.reported();
  }
  return wrong;
}
template <class R = Usual<Cuda>>
std::size_t wrong_in_replays(int replays, std::size_t views) {
  Recording<R> r;
  return wrong_in_replays(r, replays, [=](int k) { return frame_of(k, views); }, {8000, 200'000});
}

/// A view of the built-in scene from place `k` of 24, without alpha and depth.
AskedView view_from(int k, int wide, int high) {
  AskedView view{builtin_cameras(24, wide, high)[std::size_t(k) % 24]};
  view.alpha = view.depth = false;
  return view;
}

}  // namespace

SWIFTGS_DEVICE_CASE("cuda record: a graph puts the raster blocks of each frame in an order") {
  // Raster blocks enough for an order on devices of up to 200 multiprocessors.
  Recording<> r;
  const auto asked = [](int k) { return std::vector{view_from(8 * k, 800, 600)}; };
  CHECK(wrong_in_replays(r, 4, asked, {8000, 400'000}) == 0);
}

SWIFTGS_DEVICE_CASE("cuda record: a graph looks for the chunks that other cameras show") {
  // More blocks than a projection without a list has.
  const Scene scene = make_builtin_scene(20 * chunk_size * std::size_t(Cuda().multiprocessors()));
  for (const std::size_t views : {1, 2}) {
    CAPTURE(views);
    Recording<> r(order_spatially(scene));
    SceneView without = r.scene.view();
    REQUIRE_FALSE(without.chunks.empty());
    without.chunks = {};
    // Reserved for a scene without chunks, which needs no list of them.
    const PlacedViews reserved(r.cuda, frame_of(0, views));
    r.renderer.reserve(without, reserved.span(), {2 * scene.size(), 20 * scene.size()});
    const Graph graph(r.stream, [&] { r.renderer.record(r.scene.view(), r.report.data()); });
    for (int k = 0; k < 30; ++k) {
      PlacedViews drawn(r.cuda, frame_of(k, views));
      r.run(graph, drawn);
      CHECK(differing(drawn.finish(r.cuda), draw_together(r.other, without, frame_of(k, views))) == 0);
      CHECK(r.reported());
    }
  }
}

SWIFTGS_DEVICE_CASE("cuda record: a thousand replays with other cameras have the bits of rendered frames") {
  CHECK(wrong_in_replays(1000, 2) == 0);
  CHECK(wrong_in_replays(300, 1) == 0);
}

SWIFTGS_DEVICE_CASE("cuda record: a graph draws lenses, then pinholes, then lenses again") {
  const auto asked = [](int k) {
    std::vector<AskedView> views = frame_of(k);
    if (k % 3 == 1) return views;
    views[0].camera.lens.model = k == 0 ? LensModel::fisheye : LensModel(k % 3);
    if (k % 3 == int(LensModel::perspective)) views[0].camera.lens.distortion.radial[0] = 0.1;
    return views;
  };
  Recording<> r;
  CHECK(wrong_in_replays(r, 24, asked, {12000, 300'000}) == 0);
}

SWIFTGS_DEVICE_CASE("cuda record: a graph draws panoramas, whose parts are as many in every run") {
  const auto asked = [](int k) {
    AskedView view{builtin_cameras(24, 256, 128)[std::size_t(k)], Conventions::gsplat(),
                   vec3(0.1f * float(k))};
    view.camera.lens.model = LensModel::equirectangular;
    view.camera.fx = view.camera.fy = 128 / 3.14159265358979;
    return std::vector{view};
  };
  Recording<> r;
  CHECK(wrong_in_replays(r, 24, asked, {32'000, 400'000}) == 0);
}

SWIFTGS_DEVICE_CASE("cuda record: every sort with every bounds can be captured") {
  for_each_type(AllSorts(), [&]<class Sort>(Sort) {
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
      CAPTURE(Sort::name);
      CAPTURE(Bounds::name);
      using R = Renderer<Cuda, Sort, AxisSharedThreshold<FloatCholesky>, Bounds>;
      for (const std::size_t views : {1, 2}) CHECK(wrong_in_replays<R>(20, views) == 0);
    });
  });
}

SWIFTGS_DEVICE_CASE("cuda record: every rasterizer replays formats, planes and places that change") {
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    Recording<Renderer<Cuda, EarlySort, Raster, Ellipse>> r(random_scene(2000, 1, 10));
    check_changing_views(r.renderer, r.other, r.scene.view(), [&](FrameReport* report) {
      const auto graph =
          std::make_shared<Graph>(r.stream, [&] { r.renderer.record(r.scene.view(), report); });
      return [graph] { graph->run(); };
    });
  });
}

SWIFTGS_DEVICE_CASE("cuda record: views set between launches without a wait are drawn by the next one") {
  for (const std::size_t views : {1, 2}) {
    CAPTURE(views);
    Recording<> r;
    const Graph graph = r.capture(frame_of(0, views));
    for (int k = 0; k < 50; ++k) {
      PlacedViews first(r.cuda, frame_of(k, views)), second(r.cuda, frame_of(k + 7, views));
      r.run(graph, first), r.run(graph, second);
      CHECK(r.wrong(first, frame_of(k, views)) == 0);
      CHECK(r.wrong(second, frame_of(k + 7, views)) == 0);
    }
  }
}

SWIFTGS_DEVICE_CASE("cuda record: the adaptive sort records what it has decided") {
  const auto nodes_of = []<class Sort>(std::type_identity<Sort>) {
    return Recording<Usual<Cuda, Sort>>().capture(frame_of(0, 1)).nodes();
  };
  const std::size_t standard = nodes_of(std::type_identity<StandardSort>()),
                    early = nodes_of(std::type_identity<EarlySort>());
  CHECK(standard != early);  // the early sort has one sort more
  Recording<Usual<Cuda, AdaptiveSort>> r;
  for (int frame = 0; frame < 20 && !r.renderer.sort().measured(); ++frame)
    draw_together(r.renderer, r.scene.view(), frame_of(0, 1));
  REQUIRE(r.renderer.sort().measured());
  const bool prefers_early = r.renderer.sort().measured()->prefers_early();
  CHECK(r.capture(frame_of(0, 1)).nodes() == (prefers_early ? early : standard));
}

SWIFTGS_DEVICE_CASE("cuda record: an overflow between two frames of a graph leaves both as they are") {
  Recording<> r;
  std::size_t least = 0, most = 0;
  int small = 0, large = 0;
  for (int k = 0; k < 24; ++k) {
    draw_together(r.other, r.scene.view(), frame_of(k));
    const std::size_t here = r.other.statistics().intersections;
    if (least == 0 || here < least) least = here, small = k;
    if (here > most) most = here, large = k;
  }
  REQUIRE(least < most);
  const Graph graph = r.capture(frame_of(small), {8000, least});
  for (int round = 0; round < 20; ++round)
    for (const int k : {small, large}) {
      CHECK((r.wrong_in_run(graph, frame_of(k)) == 0) == (k == small));
      CHECK(r.report.get(r.cuda).overflowed == (k == large ? 1u : 0u));
    }
}

SWIFTGS_DEVICE_CASE("cuda record: two graphs run at once on two streams") {
  Recording<> parts[2];
  const Graph graphs[2] = {parts[0].capture(frame_of(0)), parts[1].capture(frame_of(0))};
  for (int k = 0; k < 50; ++k) {
    std::deque<PlacedViews<Cuda>> drawn;
    for (int p = 0; p < 2; ++p) drawn.emplace_back(parts[p].cuda, frame_of(k + 11 * p));
    for (int p = 0; p < 2; ++p) {
      parts[p].renderer.set_views(drawn[std::size_t(p)].span());
      for (int again = 0; again < 3; ++again) graphs[p].run();
    }
    for (int p = 0; p < 2; ++p) CHECK(parts[p].wrong(drawn[std::size_t(p)], frame_of(k + 11 * p)) == 0);
  }
}

SWIFTGS_DEVICE_CASE("cuda record: a graph sorts before the event is recorded that its occluder waits for") {
  Recording<> r;
  const std::vector<AskedView> asked = frame_of(2, 1);
  const auto expected = draw_together(r.other, r.scene.view(), asked);
  const std::size_t pixels = std::size_t(asked[0].width) * asked[0].height;
  const std::vector<float> before_all(pixels, 0), behind_all(pixels, 1e30f);
  DeviceBuffer<float> depth = to_device(before_all);
  const DeviceBuffer<float> uncovered = to_device(behind_all);
  PlacedViews images(r.cuda, asked);
  images.views[0].frame.occluder = {depth.data(), std::ptrdiff_t(sizeof(float)) * asked[0].width};
  FrameReport* pinned = nullptr;
  check_cuda(cudaMallocHost(reinterpret_cast<void**>(&pinned), sizeof(FrameReport)), "cudaMallocHost");
  const std::unique_ptr<FrameReport, decltype([](FrameReport* p) { cudaFreeHost(p); })> report(pinned);
  cudaEvent_t made = nullptr;
  check_cuda(cudaEventCreateWithFlags(&made, cudaEventDisableTiming), "cudaEventCreateWithFlags");
  const std::unique_ptr<CUevent_st, decltype([](cudaEvent_t event) { cudaEventDestroy(event); })> drawn(made);
  const Stream drawer;

  r.renderer.reserve(r.scene.view(), images.span(), {8000, 200'000});
  const Graph graph(r.stream, [&] {
    r.renderer.record(r.scene.view(), report.get(), [&] {
      check_cuda(cudaStreamWaitEvent(r.stream.get(), drawn.get(), cudaEventWaitExternal),
                 "cudaStreamWaitEvent");
    });
  });
  std::atomic<bool> may_draw = false;
  const auto wait = [](void* flag) {
    while (!*static_cast<std::atomic<bool>*>(flag)) std::this_thread::yield();
  };
  *report = {};
  check_cuda(cudaLaunchHostFunc(drawer.get(), wait, &may_draw), "cudaLaunchHostFunc");
  copy_on_device(uncovered.data(), depth.data(), pixels * sizeof(float), drawer.get());
  check_cuda(cudaEventRecord(drawn.get(), drawer.get()), "cudaEventRecord");
  graph.run();
  const volatile std::uint64_t& visible = report->visible;
  for (int tries = 0; visible == 0 && tries < 1000; ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  CHECK(visible != 0);
  CHECK(cudaStreamQuery(r.stream.get()) == cudaErrorNotReady);
  may_draw = true;
  r.stream.wait();
  CHECK(differing(images.finish(r.cuda), expected) == 0);
}

SWIFTGS_DEVICE_CASE("cuda record: a graph that runs again shows what its scene was updated to") {
  // Enough chunks for a list of those that show.
  Scene expected = order_spatially(make_builtin_scene(300'000));
  const Scene part = random_scene(20'000, expected.sh_degree, 4);
  Recording<> r(expected);
  const ArraysOn<Cuda> arrays(r.cuda, part);
  REQUIRE_FALSE(r.scene.view().chunks.empty());
  REQUIRE(r.scene.view().sh_degree == part.sh_degree);
  const Graph graph = r.capture(frame_of(0), {600'000, 12'000'000});
  const auto wrong = [&] {
    const DeviceScene fresh = r.cuda.upload(expected);
    PlacedViews<Cuda> views(r.cuda, frame_of(0));
    r.run(graph, views);
    return differing(views.finish(r.cuda), draw_together(r.other, fresh.view(), frame_of(0))) + !r.reported();
  };
  CHECK(wrong() == 0);
  std::size_t first = 1001;
  r.cuda.update(r.scene, first, some_of(arrays.all, means_and_rotations));
  CHECK(wrong() != 0);
  replace(expected, first, part, means_and_rotations);
  CHECK(wrong() == 0);

  // An update may be a graph as well.
  first = 200'003;
  const Graph update(r.stream, [&] { r.cuda.update(r.scene, first, arrays.all); });
  CHECK(wrong() == 0);
  update.run();
  replace(expected, first, part);
  CHECK(wrong() == 0);
}

namespace {

/// A movement that differs from `k` to `k`, about no axis of the world.
Similarity pose_of(int k) {
  const double angle = 0.3 * k;
  return {matrix_of(unit(DQuaternion{std::cos(angle), 0.3 * std::sin(angle), -0.4 * std::sin(angle), 0.2})),
          0.5 + 0.1 * (k % 7), dvec3(0.2 * (k % 5), -0.1 * (k % 9), 0.3)};
}

/// The built-in scene, and smaller ones that move, fade and are cut.
struct Moving {
  DeviceScene still, part;

  std::vector<PlacedScene> at(int k) const {
    const Clip clips[] = {{}, Clip::sphere(vec3(0), 3), Clip::box(vec3(-2), vec3(3, 1, 2))};
    return {{still.view(), k % 4 == 3 ? pose_of(k) : Similarity()},
            {part.view(), pose_of(k), k % 3 == 2 ? 0.4f : 1},
            {part.view(), pose_of(2 * k + 1), 1, clips[k % 3]}};
  }
};

/// A recorded frame of placed scenes as a graph, and what it draws.
struct PlacedRecording : Recording<> {
  Moving moving;
  std::vector<AskedView> asked;

  PlacedRecording(const Scene& still, const Scene& part, std::vector<AskedView> of_views)
      : Recording(Scene()), moving{cuda.upload(still), cuda.upload(part)}, asked(std::move(of_views)) {
    reserved.emplace(cuda, asked);
    const std::size_t most = 2 * still.size() + 4 * part.size();
    renderer.reserve(moving.at(0), reserved->span(), {most, 20 * most});
  }

  /// Whether the last run drew `placed` in all views, and reported that.
  bool drew(const std::vector<PlacedScene>& placed) {
    PlacedViews<Cuda> expected(cuda, asked);
    other.render_into(placed, expected.span());
    return differing(reserved->finish(cuda), expected.finish(cuda)) == 0 && reported();
  }
};

}  // namespace

SWIFTGS_DEVICE_CASE("cuda record: a graph draws placed scenes where they are set between launches") {
  for (const std::size_t views : {1, 2}) {
    CAPTURE(views);
    PlacedRecording r(make_builtin_scene(4000), random_scene(700, 2, 11), frame_of(0, views));
    const Graph graph(r.stream, [&] { r.renderer.record(r.report.data()); });
    graph.run();
    CHECK(r.drew(r.moving.at(0)));
    for (int k = 1; k < 60; ++k) {
      CAPTURE(k);
      // Launches do not wait for one another, and the host's memory is gone at once.
      r.renderer.set_scenes(r.moving.at(k + 7)), graph.run();
      r.renderer.set_scenes(r.moving.at(k)), graph.run();
      CHECK(r.drew(r.moving.at(k)));
    }
    std::vector<PlacedScene> fewer = r.moving.at(3);
    fewer.pop_back();
    CHECK_THROWS_AS(r.renderer.set_scenes(fewer), std::invalid_argument);
    graph.run();
    CHECK(r.drew(r.moving.at(59)));
  }
}

SWIFTGS_DEVICE_CASE("cuda record: a graph draws the poses that its own work writes, where they are valid") {
  // With a list of chunks that show, and without one.
  const std::size_t listed = 20 * chunk_size * std::size_t(Cuda().multiprocessors());
  for (const std::size_t gaussians : {std::size_t(4000), listed}) {
    CAPTURE(gaussians);
    PlacedRecording r(order_spatially(make_builtin_scene(gaussians)), random_scene(700, 2, 11), frame_of(0));
    if (gaussians == listed) REQUIRE_FALSE(r.moving.still.view().chunks.empty());
    DeviceBuffer<Similarity> poses;
    poses.reset(3);
    const Graph graph(r.stream, [&] {
      for (std::size_t i = 0; i < 3; ++i)
        copy_on_device(poses.data() + i, &r.renderer.recorded_scenes()[i].world_from_scene,
                       sizeof(Similarity), r.stream.get());
      r.renderer.record(r.report.data());
    });
    const auto run = [&](const std::vector<PlacedScene>& placed) {
      std::vector<Similarity> now;
      for (const PlacedScene& each : placed) now.push_back(each.world_from_scene);
      CopyToBackend<Cuda>::copy(Span<const Similarity>{now.data(), now.size()}, poses.data());
      graph.run();
    };
    for (int k = 0; k < 6; ++k) {
      CAPTURE(k);
      std::vector<PlacedScene> placed = r.moving.at(0);
      for (std::size_t i = 0; i < 3; ++i) placed[i].world_from_scene = pose_of(3 * k + int(i));
      run(placed);
      CHECK(r.drew(placed));
      CHECK(r.renderer.refused_scenes().empty());

      const std::size_t which = std::size_t(k) % 3;
      std::vector<PlacedScene> bad = placed, without = placed;
      bad[which].world_from_scene.scale *= -1;
      without[which].opacity = 0;
      run(bad);
      CHECK(r.drew(without));
      CHECK(r.renderer.refused_scenes() == std::vector<std::size_t>{which});
    }
    run(r.moving.at(0));
    CHECK(r.drew(r.moving.at(0)));
    CHECK(r.renderer.refused_scenes().empty());
  }
}
