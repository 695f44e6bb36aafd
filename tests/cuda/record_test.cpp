// SPDX-License-Identifier: Apache-2.0

// Frames that are recorded into a CUDA graph and run again: the same bits as frames that the host renders.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit.hpp>

#include "cuda/device.hpp"
#include "cuda/graph.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

template <class Sort, class Raster = AxisSharedThreshold<FloatCholesky>, class Bounds = Ellipse>
using With = Renderer<Cuda, Sort, Raster, Bounds>;
using Usual = With<EarlySort>;

/// Two views in memory of their own: one as floats with depth, one of another size as bytes.
struct Pair {
  DeviceBuffer<float> colour, depth;
  DeviceBuffer<std::uint32_t> bytes;
  static constexpr int width = 150, height = 100, other_width = 77, other_height = 61;

  Pair() {
    colour.reset(3 * width * height), depth.reset(width * height), bytes.reset(other_width * other_height);
    poison();
  }
  void poison() {
    check_cuda(cudaMemset(colour.data(), 0xa5, colour.size() * sizeof(float)), "cudaMemset");
    check_cuda(cudaMemset(depth.data(), 0xa5, depth.size() * sizeof(float)), "cudaMemset");
    check_cuda(cudaMemset(bytes.data(), 0xa5, bytes.size() * 4), "cudaMemset");
    check_cuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
  }

  /// Of frame `k`: cameras, conventions and backgrounds change.
  std::vector<View> views(int k) {
    const std::vector<Camera> large = builtin_cameras(24, width, height);
    const std::vector<Camera> small = builtin_cameras(24, other_width, other_height);
    const FrameView a{.width = width,
                      .height = height,
                      .colour = {colour.data(), 3 * width * std::ptrdiff_t(sizeof(float))},
                      .depth = {depth.data(), width * std::ptrdiff_t(sizeof(float))}};
    const FrameView b{.width = other_width,
                      .height = other_height,
                      .colour = {bytes.data(), other_width * std::ptrdiff_t(4)},
                      .format = PixelFormat::rgba_8};
    const Conventions conventions = k % 5 == 4 ? Conventions::inria() : Conventions::gsplat();
    return {make_view(large[std::size_t(k) % 24], conventions, a, vec3(0.1f * float(k % 7), 0.5f, 1)),
            make_view(small[std::size_t(3 * k + 5) % 24], Conventions::gsplat(), b, vec3(float(k % 2)))};
  }

  /// All bytes of all planes.
  std::vector<std::uint32_t> words(const Cuda& cuda) const {
    std::vector<std::uint32_t> all(colour.size() + depth.size() + bytes.size());
    const auto get = [&](const auto& from, std::size_t at) {
      cuda.download(Span{reinterpret_cast<const std::uint32_t*>(from.data()), from.size()}, all.data() + at);
    };
    get(colour, 0), get(depth, colour.size()), get(bytes, colour.size() + depth.size());
    return all;
  }
};

Span<const View> span(const std::vector<View>& views) { return {views.data(), views.size()}; }

std::size_t differing(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
  return count;
}

/// A renderer whose frames are recorded and one that renders the same views, on one stream.
template <class R = Usual>
struct Recording {
  Stream stream;
  R renderer{Cuda(stream.get())}, other{Cuda(stream.get())};
  Cuda& cuda = renderer.backend();
  DeviceScene scene;
  Pair images, expected;
  DeviceBuffer<FrameReport> memory;  ///< of the report

  explicit Recording(const Scene& of = make_builtin_scene(4000)) : scene(cuda.upload(of)) { memory.reset(1); }

  void reserve(Span<const View> views, const Capacity& capacity = {8000, 200'000}) {
    renderer.reserve(scene.view(), views, capacity);
  }
  void record() { renderer.record(scene.view(), memory.data()); }
  Graph capture() {
    return Graph(stream, [&] { record(); });
  }
  FrameReport report() const { return to_host(cuda, memory.span())[0]; }

  /// The words of `images` that differ from those of frame `k`, whose first views the other one renders.
  std::size_t wrong_words(int k, std::size_t views = 2) {
    other.render_into(scene.view(), {expected.views(k).data(), views});
    return differing(images.words(cuda), expected.words(cuda));
  }
  /// Whether the last report is of the frame that the other one rendered last.
  bool reported() const {
    const FrameReport found = report();
    const Statistics taken = other.statistics();
    return found.overflowed == 0 && found.visible == taken.visible && found.instances == taken.instances;
  }
};

/// Runs one recorded frame again and again with other views. Returns the words that differ from those of
/// frames that the host renders, and the frames whose report does.
template <class R>
std::size_t wrong_in_replays(int replays, std::size_t views) {
  Recording<R> r;
  const auto first = [&](const std::vector<View>& all) { return Span<const View>{all.data(), views}; };
  r.reserve(first(r.images.views(0)));
  const Graph graph = r.capture();
  std::size_t wrong = 0;
  for (int k = 0; k < replays; ++k) {
    r.images.poison();
    r.renderer.set_views(first(r.images.views(k)));
    graph.run();
    wrong += r.wrong_words(k, views) + !r.reported();
  }
  return wrong;
}

}  // namespace

TEST_CASE("cuda record: a graph puts the squares of each frame in an order") {
  if (without_device()) return;
  // Squares enough for an order on devices of up to 200 multiprocessors.
  constexpr int width = 800, height = 600;
  Recording<> r;
  DeviceBuffer<float> image, expected;
  image.reset(3 * width * height), expected.reset(3 * width * height);
  const std::vector<Camera> cameras = builtin_cameras(24, width, height);
  const auto view = [&](int k, DeviceBuffer<float>& to) {
    const FrameView frame{
        .width = width, .height = height, .colour = {to.data(), 3 * width * std::ptrdiff_t(sizeof(float))}};
    return std::vector<View>{make_view(cameras[std::size_t(k)], Conventions::gsplat(), frame, vec3(0.5f))};
  };
  r.reserve(span(view(0, image)), {8000, 400'000});
  const Graph graph = r.capture();
  for (const int k : {0, 7, 15, 0}) {
    CAPTURE(k);
    r.renderer.set_views(span(view(k, image)));
    graph.run();
    r.other.render_into(r.scene.view(), span(view(k, expected)));
    CHECK(r.reported());
    CHECK(to_host(r.cuda, std::as_const(image).span()) == to_host(r.cuda, std::as_const(expected).span()));
  }
}

TEST_CASE("cuda record: a graph looks for the chunks that other cameras show") {
  if (without_device()) return;
  // More blocks than a projection without a list has.
  const Scene scene = make_builtin_scene(20 * chunk_size * std::size_t(Cuda().multiprocessors()));
  for (const std::size_t views : {1, 2}) {
    CAPTURE(views);
    Recording<> r(order_spatially(scene));
    SceneView without = r.scene.view();
    REQUIRE_FALSE(without.chunks.empty());
    without.chunks = {};
    const auto first = [&](const std::vector<View>& all) { return Span<const View>{all.data(), views}; };
    // Reserved for a scene without chunks, which needs no list of them.
    r.renderer.reserve(without, first(r.images.views(0)), {2 * scene.size(), 20 * scene.size()});
    const Graph graph = r.capture();
    for (int k = 0; k < 30; ++k) {
      r.images.poison();
      r.renderer.set_views(first(r.images.views(k)));
      graph.run();
      r.other.render_into(without, first(r.expected.views(k)));
      CHECK(differing(r.images.words(r.cuda), r.expected.words(r.cuda)) == 0);
      CHECK(r.reported());
    }
  }
}

TEST_CASE(
    "cuda record: a graph that runs a thousand times with other cameras has the bits of rendered frames") {
  if (without_device()) return;
  CHECK(wrong_in_replays<Usual>(1000, 2) == 0);
}

TEST_CASE("cuda record: a graph of one view that runs with other cameras has the bits of rendered frames") {
  if (without_device()) return;
  CHECK(wrong_in_replays<Usual>(300, 1) == 0);
}

TEST_CASE("cuda record: every sort with every bounds can be captured") {
  if (without_device()) return;
  for_each_type(AllSorts(), [&]<class Sort>(Sort) {
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
      CAPTURE(Sort::name);
      CAPTURE(Bounds::name);
      using R = With<Sort, AxisSharedThreshold<FloatCholesky>, Bounds>;
      CHECK(wrong_in_replays<R>(20, 1) == 0);
      CHECK(wrong_in_replays<R>(20, 2) == 0);
    });
  });
}

TEST_CASE(
    "cuda record: every rasterizer can be captured and replays formats and planes and places that change") {
  if (without_device()) return;
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    Recording<With<EarlySort, Raster>> r(random_scene(2000, 1, 10));
    check_changing_views(r.renderer, r.other, r.scene.view(), [&](FrameReport* report) {
      const auto graph =
          std::make_shared<Graph>(r.stream, [&] { r.renderer.record(r.scene.view(), report); });
      return [graph] { graph->run(); };
    });
  });
}

TEST_CASE("cuda record: views that are set between launches without a wait are drawn by the next one alone") {
  if (without_device()) return;
  for (const std::size_t views : {1, 2}) {
    CAPTURE(views);
    Recording r;
    Pair second;
    r.reserve({r.images.views(0).data(), views});
    const Graph graph = r.capture();
    const auto launch = [&](Pair& into, int k) {
      r.renderer.set_views({into.views(k).data(), views});
      graph.run();
    };
    for (int k = 0; k < 50; ++k) {
      r.images.poison(), second.poison();
      launch(r.images, k), launch(second, k + 7);
      CHECK(r.wrong_words(k, views) == 0);
      r.other.render_into(r.scene.view(), {r.expected.views(k + 7).data(), views});
      CHECK(second.words(r.cuda) == r.expected.words(r.cuda));
    }
  }
}

TEST_CASE("cuda record: the adaptive sort records what it has decided") {
  if (without_device()) return;
  const auto nodes_of = [](double standard_ms, double early_ms) {
    Recording<With<AdaptiveSort>> r;
    r.renderer.sort().use({SortCalibration{4000, Pair::width, Pair::height, standard_ms, early_ms}});
    r.reserve({r.images.views(0).data(), 1});
    return r.capture().nodes();
  };
  CHECK(nodes_of(1, 2) != nodes_of(2, 1));  // the early sort has one sort more
}

TEST_CASE("cuda record: an overflow between two frames of a graph leaves both as they are") {
  if (without_device()) return;
  Recording r;
  std::size_t least = 0, most = 0;
  int small = 0, large = 0;
  for (int k = 0; k < 24; ++k) {
    r.other.render_into(r.scene.view(), span(r.expected.views(k)));
    const std::size_t here = r.other.statistics().instances;
    if (least == 0 || here < least) least = here, small = k;
    if (here > most) most = here, large = k;
  }
  REQUIRE(least < most);
  r.reserve(span(r.images.views(small)), {8000, least});
  const Graph graph = r.capture();
  for (int round = 0; round < 20; ++round)
    for (const int k : {small, large}) {
      r.images.poison();
      r.renderer.set_views(span(r.images.views(k)));
      graph.run();
      CHECK(r.report().overflowed == (k == large ? 1u : 0u));
      CHECK((r.wrong_words(k) == 0) == (k == small));
    }
}

TEST_CASE("cuda record: two graphs run at once on two streams") {
  if (without_device()) return;
  Recording<> parts[2];
  std::optional<Graph> graphs[2];
  for (int p = 0; p < 2; ++p) {
    parts[p].reserve(span(parts[p].images.views(0)));
    graphs[p].emplace(parts[p].stream, [&] { parts[p].record(); });
  }
  for (int k = 0; k < 50; ++k) {
    for (int p = 0; p < 2; ++p) {
      parts[p].renderer.set_views(span(parts[p].images.views(k + 11 * p)));
      for (int again = 0; again < 3; ++again) graphs[p]->run();
    }
    for (int p = 0; p < 2; ++p) CHECK(parts[p].wrong_words(k + 11 * p) == 0);
  }
}

TEST_CASE("cuda record: an empty scene is drawn as its background") {
  if (without_device()) return;
  Recording r{Scene()};
  r.reserve(span(r.images.views(1)), {10, 10});
  const Graph graph = r.capture();
  graph.run();
  CHECK(r.wrong_words(1) == 0);
  CHECK(r.report().overflowed == 0);
}

TEST_CASE("cuda record: a graph draws the views of before after others were refused") {
  if (without_device()) return;
  Recording r;
  r.reserve(span(r.images.views(0)));
  const Graph graph = r.capture();
  for (int k = 0; k < 5; ++k) {
    r.renderer.set_views(span(r.images.views(k)));
    std::vector<View> bad = r.images.views(k + 1);
    bad[1].grid.rows.end += 1;
    CHECK_THROWS_AS(r.renderer.set_views(span(bad)), std::invalid_argument);
    graph.run();
    CHECK(r.wrong_words(k) == 0);
  }
}
