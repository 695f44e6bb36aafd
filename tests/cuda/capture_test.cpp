// SPDX-License-Identifier: Apache-2.0

// Streams that are being captured into a CUDA graph: what cannot be captured refuses before it calls CUDA, so
// that the capture stays valid and the renderer works on.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/edit/pruning.hpp>

#include "cuda/graph.hpp"
#include "policies/contribution_sums.hpp"
#include "policies/rasterizers.hpp"
#include "support/one_view.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Checks that `f` throws a `DeviceError` that begins with `call` and says that the stream is being captured.
template <class F>
void refused(const char* call, const F& f) {
  try {
    f();
  } catch (const DeviceError& error) {
    const std::string message = error.what();
    CAPTURE(message);
    CHECK(message.starts_with(std::string(call) + ": "));
    CHECK(message.find("is being captured into a CUDA graph") != std::string::npos);
    return;
  }
  FAIL_CHECK(call << " was not refused");
}

constexpr cudaStreamCaptureMode modes[] = {cudaStreamCaptureModeGlobal, cudaStreamCaptureModeThreadLocal,
                                           cudaStreamCaptureModeRelaxed};

}  // namespace

SWIFTGS_DEVICE_CASE("cuda capture: no function of the backend that cannot be captured touches the capture") {
  const Stream stream;
  Cuda cuda(stream.get());
  const Scene scene = random_scene(500, 1, 1);
  DeviceBuffer<std::uint32_t> words = to_device(std::vector<std::uint32_t>(100, 1));
  const DeviceBuffer<FrameCounts> counts = to_device(std::vector<FrameCounts>{{3, 4}});
  DeviceBuffer<FrameTotals> totals;
  totals.reset(1);
  const Cuda::TimePoint first = cuda.now(), second = cuda.now();
  const ArraysOn<Cuda> arrays(cuda, scene);
  std::optional<DeviceScene> kept(cuda.upload(arrays.all));
  stream.wait();
  for (const cudaStreamCaptureMode mode : modes) {
    const auto work = [&] {
      std::uint32_t word = 0;
      refused("upload", [&] { (void)cuda.upload(scene); });
      refused("upload", [&] { (void)cuda.upload(std::make_shared<const Scene>(scene)); });
      refused("upload", [&] { (void)cuda.upload(arrays.all, kept); });
      refused("download", [&] { cuda.download(Span<const std::uint32_t>{words.data(), 1}, &word); });
      refused("wait", [&] { cuda.wait(); });
      refused("exclusive_scan", [&] { (void)cuda.exclusive_scan(words.span()); });
      refused("now", [&] { (void)cuda.now(); });
      refused("milliseconds", [&] { (void)cuda.milliseconds(first, second); });
      refused("settle", [&] { cuda.settle({counts.data()}, {}, totals.data()); });
      refused("await_report", [&] { (void)cuda.await_report(); });
    };
    CHECK(Graph(stream, work, mode).nodes() == 0);
    CHECK(kept.has_value());
  }
  cuda.settle({counts.data()}, {}, totals.data());
  CHECK(cuda.await_report().intersections == 4);
  CHECK(cuda.exclusive_scan(words.span()) == 100);
  CHECK(cuda.milliseconds(first, second));
  CHECK(cudaPeekAtLastError() == cudaSuccess);
}

SWIFTGS_DEVICE_CASE("cuda capture: stages refuse what a host would wait for and what began before") {
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
  const auto work = [&] {
    refused("join", [&] { (void)begun.finish(); });
    refused("bin", [&] { bin(cuda, frame.plan(), Ellipse{}, splats, footprints); });
  };
  for (const cudaStreamCaptureMode mode : modes) CHECK(Graph(stream, work, mode).nodes() == 0);
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

SWIFTGS_DEVICE_CASES("cuda capture: a renderer refuses frames and draws on", Sort, StandardSort, EarlySort,
                     AdaptiveSort) {
  const Stream stream;
  Usual<Cuda, Sort> renderer{Cuda(stream.get())};
  const Camera camera = forward_camera(150, 90), larger = forward_camera(400, 300);
  const DeviceScene scene = renderer.backend().upload(random_scene(4000, 2, 3));
  RenderSettings counting, timing;
  counting.count = timing.time = true;
  const Frame expected = renderer.render(scene, camera, timing);
  PlanesOn<Cuda> image(renderer.backend(), 400, 300, {true, true});
  stream.wait();
  for (const cudaStreamCaptureMode mode : modes)
    for (const Camera& view : {camera, larger}) {  // buffers would have to grow
      const auto work = [&] {
        FrameView planes = image.view();
        planes.width = view.width, planes.height = view.height;
        refused("a frame", [&] { renderer.render_into(scene.view(), view, {}, planes); });
        refused("a frame", [&] { renderer.render_into(scene.view(), view, counting, planes); });
        refused("a frame", [&] { (void)renderer.render_resident(scene.view(), view, {}); });
        refused("a frame", [&] { (void)renderer.render(scene, view); });
        refused("a frame", [&] { (void)renderer.pick(0, 0); });
        refused("milliseconds", [&] { (void)renderer.times(); });
      };
      CHECK(Graph(stream, work, mode).nodes() == 0);
    }
  CHECK(same_bits(renderer.render(scene, camera).colour, expected.colour));
  CHECK(renderer.render(scene, larger, counting).pixels() == 400 * 300);
  CHECK(renderer.statistics().raster.contributing_pairs > 0);
}

SWIFTGS_DEVICE_CASE("cuda capture: contributions refuse views and add up as before afterwards") {
  const auto scene = std::make_shared<const Scene>(random_scene(2000, 0, 4));
  const Camera camera = forward_camera(90, 60);
  const Sums expected = sums_of<Cuda>(*scene, {camera, camera}, Conventions::gsplat());
  const Stream stream;
  Contributions<Cuda> contributions(scene, Cuda(stream.get()));
  contributions.add(camera, Conventions::gsplat());
  const DeviceScene uploaded = Cuda().upload(*scene);
  const std::vector<PlacedScene> placed{{uploaded.view()}, {uploaded.view()}};
  const Graph graph(stream, [&] {
    refused("a frame", [&] { contributions.add(camera, Conventions::gsplat()); });
    refused("a frame", [&] { contributions.add(forward_camera(900, 600), Conventions::gsplat()); });
    refused("download", [&] { (void)contributions.sums(); });
    refused("upload", [&] { Contributions<Cuda> other(scene, Cuda(stream.get())); });
    refused("a frame", [&] { Contributions<Cuda> other(placed, Cuda(stream.get())); });
  });
  CHECK(graph.nodes() == 0);
  contributions.add(camera, Conventions::gsplat());
  CHECK(contributions.sums() == expected);
}

SWIFTGS_DEVICE_CASE("cuda capture: the default stream is not used while one that waits for it is captured") {
  const Stream waiting(cudaStreamDefault);
  Usual<Cuda> renderer;
  const DeviceScene scene = renderer.backend().upload(random_scene(500, 0, 5));
  const Camera camera = forward_camera(60, 40);
  const Frame expected = renderer.render(scene, camera);
  const Graph graph(waiting, [&] {
    refused("a frame", [&] { (void)renderer.render(scene, camera); });
    refused("wait", [&] { renderer.backend().wait(); });
  });
  CHECK(graph.nodes() == 0);
  CHECK(same_bits(renderer.render(scene, camera).colour, expected.colour));
}

SWIFTGS_DEVICE_CASE("cuda capture: a rasterizer is captured and draws the same picture at each replay") {
  const Stream stream;
  Cuda cuda(stream.get());
  DrawSettings settings;
  settings.count = false;  // to count, the host waits
  Picture<Cuda> picture(cuda, random_splats(500, 100, 70, 6), 100, 70, settings);
  PlanesOn<Cuda> expected(cuda, 100, 70, {true, true}), image(cuda, 100, 70, {true, true}, -1);
  const auto raster = raster_stage<Cuda, AxisSharedThreshold<FloatCholesky>>();
  picture.draw(raster, expected.view());
  stream.wait();
  const Graph graph(stream, [&] {
    cuda.clear(image.view().colour.data, 3 * sizeof(float) * 100 * 70);
    picture.draw(raster, image.view());
  });
  CHECK(graph.nodes() == 3);  // the picture, the kernel and that of long lists
  for (int i = 0; i < 3; ++i) graph.run();
  CHECK(image.on_host(cuda).colour == expected.on_host(cuda).colour);
}
