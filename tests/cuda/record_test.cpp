// SPDX-License-Identifier: Apache-2.0

// Frames that are recorded into a CUDA graph and run again: the same bits as frames that the host renders.
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include <swiftgs/builtin_scene.hpp>

#include "cuda/device.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

template <class Sort, class Raster, class Bounds = Ellipse>
using OnDevice = Renderer<Cuda, Sort, Raster, Bounds>;
using Usual = OnDevice<EarlySort, AxisSharedThreshold<FloatCholesky>>;

/// What `f` gives to a stream, ready to run.
class Graph {
 public:
  template <class F>
  Graph(const Stream& stream, const F& f) : stream_(stream) {
    check_cuda(cudaStreamBeginCapture(stream.get(), cudaStreamCaptureModeGlobal), "cudaStreamBeginCapture");
    f();
    cudaGraph_t graph = nullptr;
    check_cuda(cudaStreamEndCapture(stream.get(), &graph), "cudaStreamEndCapture");
    check_cuda(cudaGraphInstantiate(&made_, graph, 0), "cudaGraphInstantiate");
    check_cuda(cudaGraphDestroy(graph), "cudaGraphDestroy");
  }
  ~Graph() { cudaGraphExecDestroy(made_); }
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;

  void run() const { check_cuda(cudaGraphLaunch(made_, stream_.get()), "cudaGraphLaunch"); }

 private:
  const Stream& stream_;
  cudaGraphExec_t made_ = nullptr;
};

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

FrameReport report_in(const Cuda& cuda, const DeviceBuffer<FrameReport>& from) {
  return to_host(cuda, from.span())[0];
}

std::size_t differing(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
  return count;
}

/// Runs one recorded frame again and again with other views. Returns the words that differ from those of
/// frames that the host renders, and the frames whose report does.
template <class R>
std::size_t differing_replays(int replays) {
  const Stream stream;
  R rendering{Cuda(stream.get())}, recording{Cuda(stream.get())};
  Cuda& cuda = recording.backend();
  const auto scene = cuda.upload(make_builtin_scene(4000));
  Pair rendered, recorded;
  DeviceBuffer<FrameReport> report;
  report.reset(1);
  recording.reserve(scene.view(), span(recorded.views(0)), {8000, 200'000});
  const Graph graph(stream, [&] { recording.record(scene.view(), report.data()); });

  std::size_t wrong = 0;
  for (int k = 0; k < replays; ++k) {
    recorded.poison();
    recording.set_views(span(recorded.views(k)));
    graph.run();
    const FrameReport found = report_in(cuda, report);
    rendering.render_into(scene.view(), span(rendered.views(k)));
    wrong += differing(recorded.words(cuda), rendered.words(cuda));
    const Statistics statistics = rendering.statistics();
    wrong += found.overflowed != 0 || found.visible != statistics.visible ||
             found.instances != statistics.instances;
  }
  return wrong;
}

}  // namespace

TEST_CASE(
    "cuda record: a graph that runs a thousand times with other cameras has the bits of rendered frames") {
  if (without_device()) return;
  CHECK(differing_replays<Usual>(1000) == 0);
}

TEST_CASE_TEMPLATE("cuda record: every sort and every rasterizer can be captured", R, Usual,
                   OnDevice<StandardSort, AxisSharedThreshold<FloatCholesky>>,
                   OnDevice<AdaptiveSort, AxisSharedThreshold<FloatCholesky>>, OnDevice<EarlySort, PerPixel>,
                   OnDevice<StandardSort, AxisShared<HalfSplit>, Obb>,
                   OnDevice<EarlySort, AxisSharedThreshold<HalfSplit>, OpacityBox>,
                   OnDevice<AdaptiveSort, AxisShared<FloatSplit>, ThreeSigmaSquare>,
                   OnDevice<EarlySort, AxisSharedThreshold<FloatSplit>>,
                   OnDevice<EarlySort, AxisShared<FloatCholesky>>) {
  if (without_device()) return;
  CHECK(differing_replays<R>(30) == 0);
}

TEST_CASE("cuda record: the adaptive sort records what it has decided") {
  if (without_device()) return;
  using Adaptive = OnDevice<AdaptiveSort, AxisSharedThreshold<FloatCholesky>>;
  const Stream stream;
  Pair images;
  const auto keys_of = [&](double standard_ms, double early_ms) {
    Adaptive renderer{Cuda(stream.get())};
    const auto scene = renderer.backend().upload(make_builtin_scene(2000));
    const std::vector<View> views = images.views(0);
    renderer.sort().use(
        {SortCalibration{2000, Pair::width, Pair::height + Pair::other_height, standard_ms, early_ms}});
    renderer.reserve(scene.view(), span(views));
    DeviceBuffer<FrameReport> report;
    report.reset(1);
    check_cuda(cudaStreamBeginCapture(stream.get(), cudaStreamCaptureModeGlobal), "cudaStreamBeginCapture");
    renderer.record(scene.view(), report.data());
    cudaGraph_t graph = nullptr;
    check_cuda(cudaStreamEndCapture(stream.get(), &graph), "cudaStreamEndCapture");
    std::size_t nodes = 0;
    check_cuda(cudaGraphGetNodes(graph, nullptr, &nodes), "cudaGraphGetNodes");
    check_cuda(cudaGraphDestroy(graph), "cudaGraphDestroy");
    return nodes;
  };
  CHECK(keys_of(1, 2) != keys_of(2, 1));  // the early sort has one sort more
}

TEST_CASE("cuda record: a frame without room draws nothing, tells what it needs and recovers") {
  if (without_device()) return;
  const Stream stream;
  Usual renderer{Cuda(stream.get())}, other{Cuda(stream.get())};
  Cuda& cuda = renderer.backend();
  const auto scene = cuda.upload(make_builtin_scene(4000));
  Pair images, expected;
  other.render_into(scene.view(), span(expected.views(2)));
  const std::size_t visible = other.statistics().visible, instances = other.statistics().instances;
  const std::vector<std::uint32_t> untouched = images.words(cuda);
  DeviceBuffer<FrameReport> report;
  report.reset(1);

  for (const Capacity& capacity :
       {Capacity{visible - 1, instances}, Capacity{visible, instances - 1}, Capacity{1, 1}}) {
    renderer.reserve(scene.view(), span(images.views(2)), capacity);
    CHECK(images.words(cuda) == untouched);
    const Graph graph(stream, [&] { renderer.record(scene.view(), report.data()); });
    for (int k = 0; k < 3; ++k) graph.run();
    const FrameReport found = report_in(cuda, report);
    CHECK(found.overflowed == 1);
    CHECK(found.visible == visible);
    CHECK(found.instances == instances);
    CHECK(images.words(cuda) == untouched);
  }
  renderer.reserve(scene.view(), span(images.views(2)), {visible, instances});
  const Graph graph(stream, [&] { renderer.record(scene.view(), report.data()); });
  graph.run();
  CHECK(report_in(cuda, report).overflowed == 0);
  CHECK(images.words(cuda) == expected.words(cuda));
}

TEST_CASE("cuda record: an overflow between two frames of a graph leaves both as they are") {
  if (without_device()) return;
  const Stream stream;
  Usual renderer{Cuda(stream.get())}, other{Cuda(stream.get())};
  Cuda& cuda = renderer.backend();
  const auto scene = cuda.upload(make_builtin_scene(4000));
  Pair images, expected;
  std::size_t least = 0, most = 0;
  int small = 0, large = 0;
  for (int k = 0; k < 24; ++k) {
    other.render_into(scene.view(), span(expected.views(k)));
    const std::size_t here = other.statistics().instances;
    if (least == 0 || here < least) least = here, small = k;
    if (here > most) most = here, large = k;
  }
  REQUIRE(least < most);
  DeviceBuffer<FrameReport> report;
  report.reset(1);
  renderer.reserve(scene.view(), span(images.views(small)), {8000, least});
  const Graph graph(stream, [&] { renderer.record(scene.view(), report.data()); });
  for (int round = 0; round < 20; ++round)
    for (const int k : {small, large}) {
      images.poison();
      renderer.set_views(span(images.views(k)));
      graph.run();
      CHECK(report_in(cuda, report).overflowed == (k == large ? 1u : 0u));
      other.render_into(scene.view(), span(expected.views(k)));
      const bool same = images.words(cuda) == expected.words(cuda);
      CHECK(same == (k == small));
    }
}

TEST_CASE("cuda record: two graphs run at once on two streams") {
  if (without_device()) return;
  struct Part {
    Stream stream;
    Usual renderer{Cuda(stream.get())};
    DeviceScene scene = renderer.backend().upload(make_builtin_scene(4000));
    Pair images;
    DeviceBuffer<FrameReport> report;
    std::unique_ptr<Graph> graph;
  } parts[2];
  for (Part& part : parts) {
    part.report.reset(1);
    part.renderer.reserve(part.scene.view(), span(part.images.views(0)), {8000, 200'000});
    part.graph = std::make_unique<Graph>(
        part.stream, [&] { part.renderer.record(part.scene.view(), part.report.data()); });
  }
  Usual other;
  Pair expected;
  for (int k = 0; k < 50; ++k) {
    for (int p = 0; p < 2; ++p) {
      parts[p].renderer.set_views(span(parts[p].images.views(k + 11 * p)));
      for (int again = 0; again < 3; ++again) parts[p].graph->run();
    }
    for (int p = 0; p < 2; ++p) {
      other.render_into(parts[p].scene.view(), span(expected.views(k + 11 * p)));
      CHECK(parts[p].images.words(parts[p].renderer.backend()) == expected.words(other.backend()));
    }
  }
}

TEST_CASE("cuda record: frames that are recorded without a capture are drawn, and allocate nothing") {
  if (without_device()) return;
  const Stream stream;
  Usual renderer{Cuda(stream.get())}, other{Cuda(stream.get())};
  Cuda& cuda = renderer.backend();
  const auto scene = cuda.upload(make_builtin_scene(4000));
  Pair images, expected;
  DeviceBuffer<FrameReport> report;
  report.reset(1);
  renderer.reserve(scene.view(), span(images.views(0)), {8000, 200'000});
  for (int k = 0; k < 24; ++k) other.render_into(scene.view(), span(expected.views(k)));
  const std::size_t held = renderer.memory().total(), warm = free_memory();
  for (int k = 0; k < 24; ++k) {
    renderer.set_views(span(images.views(k)));
    renderer.record(scene.view(), report.data());
    other.render_into(scene.view(), span(expected.views(k)));
    CHECK(images.words(cuda) == expected.words(cuda));
  }
  CHECK(renderer.memory().total() == held);
  CHECK(free_memory() == warm);
}

TEST_CASE("cuda record: an empty scene is drawn as its background") {
  if (without_device()) return;
  const Stream stream;
  Usual renderer{Cuda(stream.get())}, other{Cuda(stream.get())};
  Cuda& cuda = renderer.backend();
  const auto scene = cuda.upload(Scene());
  Pair images, expected;
  DeviceBuffer<FrameReport> report;
  report.reset(1);
  renderer.reserve(scene.view(), span(images.views(1)), {10, 10});
  const Graph graph(stream, [&] { renderer.record(scene.view(), report.data()); });
  graph.run();
  CHECK(report_in(cuda, report).overflowed == 0);
  other.render_into(scene.view(), span(expected.views(1)));
  CHECK(images.words(cuda) == expected.words(cuda));
}

TEST_CASE("cuda record: what was not reserved is refused") {
  if (without_device()) return;
  Usual renderer;
  const auto scene = renderer.backend().upload(make_builtin_scene(1000));
  const auto larger = renderer.backend().upload(make_builtin_scene(1001));
  Pair images;
  DeviceBuffer<FrameReport> report;
  report.reset(1);
  CHECK_THROWS_WITH_AS(renderer.record(scene.view(), report.data()), "render: expected reserve before record",
                       std::invalid_argument);
  std::vector<View> views = images.views(0);
  renderer.reserve(scene.view(), span(views));
  CHECK_THROWS_AS(renderer.record(larger.view(), report.data()), CapacityError);
  CHECK_THROWS_AS(renderer.record(scene.view(), nullptr), std::invalid_argument);
  CHECK_THROWS_WITH_AS(renderer.set_views({views.data(), 1}),
                       "set_views: the number of views is 1, expected 2 as reserved", std::invalid_argument);
  views[1].frame.colour.data = nullptr;
  CHECK_THROWS_WITH_AS(
      renderer.set_views(span(views)),
      "set_views: the size or the planes of view 1 changed, expected those that were reserved",
      std::invalid_argument);
}
