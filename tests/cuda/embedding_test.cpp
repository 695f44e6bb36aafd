// SPDX-License-Identifier: Apache-2.0

// The device's renderers inside another program: its stream, its memory, its arrays, its threads.
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include "cuda/graph.hpp"
#include "cuda/stream_pool.hpp"
#include "policies/any_renderer.hpp"
#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Draws as much of the scene as `image` is large.
void draw(BoundRenderer<Cuda>& renderer, const SceneView& scene, PlanesOn<Cuda>& image,
          const RenderSettings& settings = {}) {
  const FrameView frame = image.view();
  renderer.render_into(scene, forward_camera(frame.width, frame.height), settings, frame);
}

/// Renders `frames` frames of several views into memory of its own on a stream of its own.
/// Returns the colours of the last frame of each view.
std::vector<std::vector<float>> render_many(const SceneView& scene, int frames) {
  const Stream stream;
  Usual<Cuda> renderer{Cuda(stream.get())};
  std::vector<PlanesOn<Cuda>> images;
  for (int view = 0; view < 3; ++view)
    images.emplace_back(renderer.backend(), 160 + 40 * view, 120 - 20 * view, Outputs{true, true});
  for (int frame = 0; frame < frames; ++frame)
    for (PlanesOn<Cuda>& image : images) draw(renderer, scene, image);
  std::vector<std::vector<float>> out;
  for (PlanesOn<Cuda>& image : images) out.push_back(image.on_host(renderer.backend()).colour);
  return out;
}

/// What a stream answers that has work to do and is asked whether it is ready.
cudaError_t poll_busy(const Stream& stream) {
  std::atomic<bool> asked = false;
  const auto wait = [](void* flag) { static_cast<std::atomic<bool>*>(flag)->wait(false); };
  check_cuda(cudaLaunchHostFunc(stream.get(), wait, &asked), "cudaLaunchHostFunc");
  const cudaError_t answer = cudaStreamQuery(stream.get());
  asked = true;
  asked.notify_one();
  stream.wait();
  return answer;
}

}  // namespace

SWIFTGS_DEVICE_CASE("cuda embedding: a frame waits for earlier work of its stream and for no other stream") {
  const Scene scene = random_scene(4000, 0, 2);
  const ArraysOn<Cuda> arrays(Cuda(), scene);
  const Stream stream;
  Usual<Cuda> renderer{Cuda(stream.get())};
  PlanesOn<Cuda> expected(renderer.backend(), 150, 90, {}), image(renderer.backend(), 150, 90, {});
  draw(renderer, arrays.view(), expected);
  stream.wait();

  // Means come late, in the order of the stream.
  DeviceBuffer<vec3> means;
  means.reset(scene.size());
  DeviceBuffer<unsigned char> busy;
  busy.reset(std::size_t(256) << 20);
  SceneView late = arrays.view();
  late.means = std::as_const(means).span();
  for (int i = 0; i < 20; ++i) renderer.backend().clear(busy.data(), busy.size());
  renderer.backend().clear(means.data(), means.size() * sizeof(vec3));
  copy_on_device(arrays.means.data(), means.data(), means.size() * sizeof(vec3), stream.get());
  draw(renderer, late, image);
  CHECK(same_planes(image.on_host(renderer.backend()), expected.on_host(renderer.backend())));
}

SWIFTGS_DEVICE_CASE("cuda embedding: an upload follows its stream and waits for no other") {
  const Scene scene = random_scene(4000, 1, 10);
  const Stream stream;
  Cuda cuda(stream.get());
  const std::vector<vec3> expected = to_host(cuda, cuda.upload(scene).view().means);

  // The default stream has work for a second, unless it is let go. An upload is done long before.
  struct Gate {
    std::atomic<bool> open = false, passed = false;
  } gate;
  const auto hold = [](void* of) {
    Gate& held = *static_cast<Gate*>(of);
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(1);
    while (!held.open && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    held.passed = true;
  };
  check_cuda(cudaLaunchHostFunc(nullptr, hold, &gate), "cudaLaunchHostFunc");
  const DeviceScene early = cuda.upload(scene);
  CHECK_FALSE(gate.passed);
  gate.open = true;
  check_cuda(cudaStreamSynchronize(nullptr), "cudaStreamSynchronize");
  CHECK(same_bits(to_host(cuda, early.view().means), expected));

  // What the stream was given before is done when an upload returns.
  DeviceBuffer<unsigned char> busy;
  busy.reset(std::size_t(256) << 20);
  for (int i = 0; i < 40; ++i) cuda.clear(busy.data(), busy.size());
  const DeviceScene late = cuda.upload(scene);
  CHECK(cudaStreamQuery(stream.get()) == cudaSuccess);
  CHECK(same_bits(to_host(Cuda(), late.view().means), expected));
}

SWIFTGS_DEVICE_CASES("cuda embedding: a frame is drawn after its host polled a busy stream", Sort,
                     StandardSort, EarlySort, AdaptiveSort) {
  const Scene scene = random_scene(4000, 1, 9);
  const Camera camera = forward_camera(150, 90);
  RenderSettings settings = settings_of({true, true});
  settings.count = settings.time = true;
  const Stream stream, polled;
  Usual<Cuda, Sort> renderer{Cuda(stream.get())};
  const auto uploaded = renderer.backend().upload(scene);
  const Frame expected = renderer.render(uploaded, camera, settings);

  // The answer stays behind as the last error of this thread. A renderer that is new allocates as well.
  Usual<Cuda, Sort> other{Cuda(stream.get())};
  for (auto* each : {&renderer, &other}) {
    CHECK(poll_busy(polled) == cudaErrorNotReady);
    Frame frame;
    REQUIRE_NOTHROW(each->render(uploaded, camera, settings, frame));
    CHECK(same_planes(frame, expected));
    CHECK(std::isfinite(each->times().total));
    CHECK(each->statistics().intersections == renderer.statistics().intersections);
    CHECK(each->statistics().raster.contributing_pairs == renderer.statistics().raster.contributing_pairs);
  }
}

SWIFTGS_DEVICE_CASE(
    "cuda embedding: renderers on streams and threads of their own draw what each draws alone") {
  const ArraysOn<Cuda> first(Cuda(), random_scene(9000, 1, 3)), second(Cuda(), random_scene(7000, 3, 4));
  constexpr int frames = 60;
  const auto alone_first = render_many(first.view(), 1), alone_second = render_many(second.view(), 1);
  REQUIRE_FALSE(same_bits(alone_first[0], alone_second[0]));
  for (int round = 0; round < 3; ++round) {
    std::vector<std::vector<float>> with_first, with_second;
    std::thread other([&] { with_second = render_many(second.view(), frames); });
    with_first = render_many(first.view(), frames);
    other.join();
    for (std::size_t view = 0; view < 3; ++view) {
      CHECK(same_bits(with_first[view], alone_first[view]));
      CHECK(same_bits(with_second[view], alone_second[view]));
    }
  }
}

SWIFTGS_DEVICE_CASE("cuda embedding: a renderer by name uses the stream and the memory of its options") {
  const auto scene = std::make_shared<const Scene>(random_scene(2000, 1, 8));
  Usual<Cuda> typed;
  const DeviceScene uploaded = typed.backend().upload(scene);
  const Stream stream;
  StreamPool pool(stream.get());
  {
    const auto any = make_renderer(Usual<Cuda>::name, {.stream = stream.get(), .memory = pool.hook()});
    any->set_scene(scene);
    const std::size_t of_scene = pool.in_use();
    CHECK(of_scene >= 2000 * 14 * sizeof(float));
    check_drawn_frames(*any, typed, uploaded.view());
    CHECK(any->memory().total() > 0);
    CHECK(pool.in_use() >= of_scene + any->memory().total());
    // A capture records work on this stream alone, so the graph draws only if the renderer uses it.
    check_recorded_frames(*any, typed, uploaded.view(), [&](FrameReport* report) {
      const Graph graph(stream, [&] { any->record(report); });
      CHECK(graph.nodes() > 5);
      graph.run();
      stream.wait();
    });
    any->trim();
    CHECK(pool.in_use() == of_scene);
  }
  CHECK(pool.in_use() == 0);
}
