// SPDX-License-Identifier: Apache-2.0

// Streams that are being captured into a CUDA graph: what cannot be captured refuses before it calls CUDA, so
// that the capture stays valid and the renderer works on.
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <swiftgs/any_contributions.hpp>
#include <swiftgs/any_renderer.hpp>

#include "cuda/drawings.hpp"
#include "policies/contribution_sums.hpp"
#include "support/one_view.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

using Usual = Renderer<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>;

struct DestroyGraph {
  void operator()(cudaGraph_t graph) const { cudaGraphDestroy(graph); }
};
using OwnedGraph = std::unique_ptr<std::remove_pointer_t<cudaGraph_t>, DestroyGraph>;

/// What `f` gives to `stream`, as a graph. Throws if the capture did not stay valid.
template <class F>
OwnedGraph capture(cudaStream_t stream, cudaStreamCaptureMode mode, const F& f) {
  check_cuda(cudaStreamBeginCapture(stream, mode), "cudaStreamBeginCapture");
  f();
  cudaGraph_t graph = nullptr;
  check_cuda(cudaStreamEndCapture(stream, &graph), "cudaStreamEndCapture");
  return OwnedGraph(graph);
}

/// Launches `graph` so often, and waits.
void replay(const OwnedGraph& graph, const Stream& stream, int times) {
  cudaGraphExec_t made = nullptr;
  check_cuda(cudaGraphInstantiate(&made, graph.get(), 0), "cudaGraphInstantiate");
  for (int i = 0; i < times; ++i) check_cuda(cudaGraphLaunch(made, stream.get()), "cudaGraphLaunch");
  stream.wait();
  check_cuda(cudaGraphExecDestroy(made), "cudaGraphExecDestroy");
}

std::size_t nodes_of(const OwnedGraph& graph) {
  std::size_t count = 0;
  check_cuda(cudaGraphGetNodes(graph.get(), nullptr, &count), "cudaGraphGetNodes");
  return count;
}

/// Whether `f` throws a `DeviceError` that begins with `call` and says that the stream is being captured.
template <class F>
bool refused(const char* call, const F& f) {
  try {
    f();
  } catch (const DeviceError& error) {
    const std::string message = error.what();
    INFO(message);
    const bool good = message.rfind(std::string(call) + ": ", 0) == 0 &&
                      message.find("is being captured into a CUDA graph") != std::string::npos;
    CHECK(good);
    return good;
  }
  FAIL_CHECK(call << " was not refused");
  return false;
}

constexpr cudaStreamCaptureMode modes[] = {cudaStreamCaptureModeGlobal, cudaStreamCaptureModeThreadLocal,
                                           cudaStreamCaptureModeRelaxed};

}  // namespace

TEST_CASE("cuda capture: no function of the backend that cannot be captured touches the capture") {
  if (without_device()) return;
  const Stream stream;
  Cuda cuda(stream.get());
  const Scene scene = random_scene(500, 1, 1);
  DeviceBuffer<std::uint32_t> words = to_device(std::vector<std::uint32_t>(100, 1));
  const DeviceBuffer<FrameCounts> counts = to_device(std::vector<FrameCounts>{{3, 4}});
  DeviceBuffer<FrameTotals> totals;
  totals.reset(1);
  const Cuda::TimePoint first = cuda.now(), second = cuda.now();
  const DeviceArrays on_device(scene);
  const auto array = [](const auto& of) { return FloatArray{reinterpret_cast<const float*>(of.data())}; };
  const SceneArrays arrays{.count = scene.size(),
                           .means = array(on_device.means),
                           .scales = array(on_device.scales),
                           .rotations = array(on_device.rotations),
                           .opacities = array(on_device.opacities),
                           .sh0 = array(on_device.sh0),
                           .sh_rest = array(on_device.sh_rest),
                           .sh_degree = 1};
  std::optional<DeviceScene> kept(cuda.upload(arrays));
  stream.wait();
  for (const cudaStreamCaptureMode mode : modes) {
    const OwnedGraph graph = capture(stream.get(), mode, [&] {
      std::uint32_t word = 0;
      refused("upload", [&] { (void)cuda.upload(scene); });
      refused("upload", [&] { (void)cuda.upload(std::make_shared<const Scene>(scene)); });
      refused("upload", [&] { (void)cuda.upload(arrays, kept); });
      refused("download", [&] { cuda.download(Span<const std::uint32_t>{words.data(), 1}, &word); });
      refused("wait", [&] { cuda.wait(); });
      refused("exclusive_scan", [&] { (void)cuda.exclusive_scan(words.span()); });
      refused("now", [&] { (void)cuda.now(); });
      refused("milliseconds", [&] { (void)cuda.milliseconds(first, second); });
      refused("settle", [&] { cuda.settle({counts.data()}, {}, totals.data()); });
      refused("await_report", [&] { (void)cuda.await_report(); });
    });
    CHECK(nodes_of(graph) == 0);
    CHECK(kept.has_value());
  }
  cuda.settle({counts.data()}, {}, totals.data());
  CHECK(cuda.await_report().intersections == 4);
  CHECK(cuda.exclusive_scan(words.span()) == 100);
  CHECK(cuda.milliseconds(first, second));
  CHECK(cudaPeekAtLastError() == cudaSuccess);
}

TEST_CASE("cuda capture: what a host would wait for, and what began before, is refused by the stages") {
  if (without_device()) return;
  const Stream stream;
  Cuda cuda(stream.get());
  const DeviceScene scene = cuda.upload(random_scene(3000, 1, 2));
  const Camera camera = forward_camera(200, 150);
  const OneView frame(camera, Conventions::gsplat(), scene.view());
  ProjectScratch<Cuda> scratch;
  Splats<Cuda> splats;
  Footprints<Cuda> footprints;
  Colours<Cuda> colours;

  // Colours are under way, and numbers of the projection still to be read, when the capture begins.
  project(cuda, frame.plan(), Ellipse{}, scratch, splats, footprints);
  Shading<Cuda> begun = shade(cuda, frame.plan(), splats, colours);
  for (const cudaStreamCaptureMode mode : modes)
    CHECK(nodes_of(capture(stream.get(), mode, [&] {
            refused("join", [&] { (void)begun.finish(); });
            refused("bin", [&] { bin(cuda, frame.plan(), Ellipse{}, splats, footprints); });
          })) == 0);
  CHECK(begun.finish().each.data == colours.each.data());
  bin(cuda, frame.plan(), Ellipse{}, splats, footprints);
  EarlySort::Scratch<Cuda> memory;
  TileLists<Cuda> lists;
  EarlySort().build(cuda, SortJob{splats.view(), footprints.view(), {}}, Ellipse{}, memory, lists);
  Serial serial;
  const SplatSet set = to_host(cuda, splats.view());
  CHECK(host_lists(cuda, lists) ==
        host_lists(serial, build_lists<StandardSort, Ellipse>(serial, set.job(200, 150))));
}

TEST_CASE_TEMPLATE("cuda capture: a renderer refuses frames and draws as before afterwards", Sort,
                   StandardSort, EarlySort, AdaptiveSort) {
  if (without_device()) return;
  const Stream stream;
  Renderer<Cuda, Sort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer{Cuda(stream.get())};
  const Camera camera = forward_camera(150, 90), larger = forward_camera(400, 300);
  const DeviceScene scene = renderer.backend().upload(random_scene(4000, 2, 3));
  RenderSettings counting, timing;
  counting.count = timing.time = true;
  const Frame expected = renderer.render(scene, camera, timing);
  DeviceFrame image(400, 300);
  stream.wait();
  for (const cudaStreamCaptureMode mode : modes)
    for (const Camera& view : {camera, larger}) {  // buffers would have to grow
      const OwnedGraph graph = capture(stream.get(), mode, [&] {
        FrameView planes = image.view();
        planes.width = view.width, planes.height = view.height;
        refused("a frame", [&] { renderer.render_into(scene.view(), view, {}, planes); });
        refused("a frame", [&] { renderer.render_into(scene.view(), view, counting, planes); });
        refused("a frame", [&] { (void)renderer.render_resident(scene.view(), view, {}); });
        refused("a frame", [&] { (void)renderer.render(scene, view); });
        refused("milliseconds", [&] { (void)renderer.times(); });
      });
      CHECK(nodes_of(graph) == 0);
    }
  CHECK(same_bits(renderer.render(scene, camera).colour, expected.colour));
  CHECK(renderer.render(scene, larger, counting).pixels() == 400 * 300);
  CHECK(renderer.statistics().raster.contributing_pairs > 0);
}

TEST_CASE("cuda capture: contributions refuse views and add up as before afterwards") {
  if (without_device()) return;
  const auto scene = std::make_shared<const Scene>(random_scene(2000, 0, 4));
  const Camera camera = forward_camera(90, 60);
  const Sums expected = sums_of<Cuda>(*scene, {camera, camera}, Conventions::gsplat());
  const Stream stream;
  Contributions<Cuda> contributions(scene, Cuda(stream.get()));
  contributions.add(camera, Conventions::gsplat());
  const OwnedGraph graph = capture(stream.get(), cudaStreamCaptureModeGlobal, [&] {
    refused("a frame", [&] { contributions.add(camera, Conventions::gsplat()); });
    refused("a frame", [&] { contributions.add(forward_camera(900, 600), Conventions::gsplat()); });
    refused("download", [&] { (void)contributions.sums(); });
    refused("upload", [&] { Contributions<Cuda> other(scene, Cuda(stream.get())); });
  });
  CHECK(nodes_of(graph) == 0);
  contributions.add(camera, Conventions::gsplat());
  CHECK(contributions.sums() == expected);
}

TEST_CASE("cuda capture: the default stream is not used while a stream that waits for it is captured") {
  if (without_device()) return;
  cudaStream_t made = nullptr;
  check_cuda(cudaStreamCreate(&made), "cudaStreamCreate");
  Usual renderer;
  const DeviceScene scene = renderer.backend().upload(random_scene(500, 0, 5));
  const Camera camera = forward_camera(60, 40);
  const Frame expected = renderer.render(scene, camera);
  const OwnedGraph graph = capture(made, cudaStreamCaptureModeGlobal, [&] {
    refused("a frame", [&] { (void)renderer.render(scene, camera); });
    refused("wait", [&] { renderer.backend().wait(); });
  });
  CHECK(nodes_of(graph) == 0);
  CHECK(same_bits(renderer.render(scene, camera).colour, expected.colour));
  check_cuda(cudaStreamDestroy(made), "cudaStreamDestroy");
}

TEST_CASE("cuda capture: a rasterizer is captured and draws the same picture at each replay") {
  if (without_device()) return;
  const Stream stream;
  Cuda cuda(stream.get());
  const Picture picture(random_splats(500, 100, 70, 6), 100, 70);
  DevicePicture device(picture);
  DeviceFrame expected(100, 70), image(100, 70);
  rasterize(cuda, AxisSharedThreshold<FloatCholesky>{}, device.job(expected.view(), true));
  stream.wait();
  const OwnedGraph graph = capture(stream.get(), cudaStreamCaptureModeGlobal, [&] {
    cuda.clear(image.colour.data(), image.colour.size());
    rasterize(cuda, AxisSharedThreshold<FloatCholesky>{}, device.job(image.view(), true));
  });
  CHECK(nodes_of(graph) == 4);  // the picture, its counts, the kernel and that of long lists
  replay(graph, stream, 3);
  CHECK(image.pixels(cuda, image.colour, 12) == expected.pixels(cuda, expected.colour, 12));
}
