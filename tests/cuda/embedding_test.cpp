// SPDX-License-Identifier: Apache-2.0

// The device's renderers inside another program: its stream, its memory, its arrays, its threads.
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "cuda/drawings.hpp"
#include "cuda/graph.hpp"
#include "cuda/stream_pool.hpp"
#include "policies/any_renderer.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

using Usual = Renderer<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>;

RenderSettings with_planes() {
  RenderSettings settings;
  settings.outputs = {true, true};
  return settings;
}

/// Renders `frames` frames of several views into memory of its own on a stream of its own.
/// Returns the colours of the last frame of each view.
std::vector<std::vector<float>> render_many(const SceneView& scene, int frames) {
  const Stream stream;
  Usual renderer{Cuda(stream.get())};
  std::vector<DeviceFrame> images;
  for (int view = 0; view < 3; ++view) images.emplace_back(160 + 40 * view, 120 - 20 * view);
  stream.wait();
  for (int frame = 0; frame < frames; ++frame)
    for (DeviceFrame& image : images)
      renderer.render_into(scene, forward_camera(image.width, image.height), {}, image.view());
  std::vector<std::vector<float>> out;
  for (const DeviceFrame& image : images) out.push_back(image.pixels(renderer.backend(), image.colour, 12));
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

namespace {

/// Draws a caller's own arrays, some of whose Gaussians hold numbers that are not finite, and the same scene
/// without those Gaussians.
template <class Raster>
void check_not_finite(const Scene& wild, const Scene& tame) {
  CAPTURE(Raster::name);
  const Camera camera = forward_camera(160, 120);
  const auto draw = [&](const Scene& scene) {
    const Stream stream;
    Renderer<Cuda, EarlySort, Raster, Ellipse> renderer{Cuda(stream.get())};
    const DeviceArrays arrays(scene);
    DeviceFrame image(160, 120);
    stream.wait();
    renderer.render_into(arrays.view(), camera, {}, image.view());
    return image.pixels(renderer.backend(), image.colour, 12);
  };
  CHECK(draw(wild) == draw(tame));
}

}  // namespace

TEST_CASE("cuda embedding: Gaussians with a number that is not finite are not drawn") {
  if (without_device()) return;
  const Scene all = random_scene(600, 2, 5);
  Scene wild = all, tame = all;
  const float bad[] = {NAN, INFINITY, -INFINITY};
  for (std::size_t i = 0; i < wild.size(); i += 3) {
    const float value = bad[i / 3 % 3];
    tame.opacities[i] = 0;
    switch (i / 9 % 6) {
      case 0:
        wild.means[i].y = value;
        break;
      case 1:
        wild.scales[i].x = value;
        break;
      case 2:
        wild.rotations[i].z = value;
        break;
      case 3:
        wild.opacities[i] = value;
        break;
      case 4:
        wild.sh0[i].z = value;
        break;
      default:
        wild.sh_rest[24 * i + 17] = value;
    }
  }
  check_not_finite<PerPixel>(wild, tame);
  check_not_finite<AxisShared<HalfSplit>>(wild, tame);
  check_not_finite<AxisSharedThreshold<HalfSplit>>(wild, tame);
  check_not_finite<AxisSharedThreshold<FloatSplit>>(wild, tame);
  check_not_finite<AxisShared<FloatCholesky>>(wild, tame);
  check_not_finite<AxisSharedThreshold<FloatCholesky>>(wild, tame);
  CHECK_THROWS_WITH_AS((void)Cuda().upload(wild),
                       "scene: means of Gaussian 0 is nan, expected finite numbers", std::invalid_argument);
}

TEST_CASE("cuda embedding: frames are drawn from the caller's arrays into its memory on its stream") {
  if (without_device()) return;
  const Scene scene = random_scene(4000, 2, 1);
  const Camera camera = forward_camera(150, 90);
  Usual own;
  const Frame expected = own.render(own.backend().upload(scene), camera, with_planes());

  const DeviceArrays arrays(scene);
  const Stream stream;
  Usual renderer{Cuda(stream.get())};
  DeviceFrame image(150, 90, PixelFormat::rgb_float, 36);
  renderer.render_into(arrays.view(), camera, with_planes(), image.view());
  stream.wait();
  CHECK(same_bits(image.pixels(Cuda(), image.colour, 12), expected.colour));
  CHECK(same_bits(image.pixels(Cuda(), image.alpha, 4), expected.alpha));
  CHECK(same_bits(image.pixels(Cuda(), image.depth, 4), expected.depth));
  CHECK(image.kept_to_its_rows(Cuda(), image.colour, 12));
}

TEST_CASE("cuda embedding: a frame waits for what its stream was given before and not for other streams") {
  if (without_device()) return;
  const Scene scene = random_scene(4000, 0, 2);
  const Camera camera = forward_camera(150, 90);
  const DeviceArrays arrays(scene);
  const Stream stream;
  Usual renderer{Cuda(stream.get())};
  DeviceFrame expected(150, 90), image(150, 90);
  renderer.render_into(arrays.view(), camera, {}, expected.view());
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
  check_cuda(cudaMemcpyAsync(means.data(), arrays.means.data(), means.size() * sizeof(vec3),
                             cudaMemcpyDeviceToDevice, stream.get()),
             "cudaMemcpyAsync");
  renderer.render_into(late, camera, {}, image.view());
  CHECK(same_bits(image.pixels(renderer.backend(), image.colour, 12),
                  expected.pixels(renderer.backend(), expected.colour, 12)));
}

TEST_CASE("cuda embedding: an upload follows its stream and waits for no other") {
  if (without_device()) return;
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

TEST_CASE_TEMPLATE("cuda embedding: a frame is drawn while its host polls a stream that is not ready", Sort,
                   StandardSort, EarlySort, AdaptiveSort) {
  if (without_device()) return;
  const Scene scene = random_scene(4000, 1, 9);
  const Camera camera = forward_camera(150, 90);
  RenderSettings settings = with_planes();
  settings.count = settings.time = true;
  const Stream stream, polled;
  Renderer<Cuda, Sort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer{Cuda(stream.get())};
  const auto uploaded = renderer.backend().upload(scene);
  const Frame expected = renderer.render(uploaded, camera, settings);

  // The answer stays behind as the last error of this thread. A renderer that is new allocates as well.
  Renderer<Cuda, Sort, AxisSharedThreshold<FloatCholesky>, Ellipse> other{Cuda(stream.get())};
  for (auto* each : {&renderer, &other}) {
    CHECK(poll_busy(polled) == cudaErrorNotReady);
    Frame frame;
    REQUIRE_NOTHROW(each->render(uploaded, camera, settings, frame));
    CHECK(same_bits(frame.colour, expected.colour));
    CHECK(same_bits(frame.alpha, expected.alpha));
    CHECK(same_bits(frame.depth, expected.depth));
    CHECK(std::isfinite(each->times().total));
    CHECK(each->statistics().instances == renderer.statistics().instances);
    CHECK(each->statistics().raster.contributing_pairs == renderer.statistics().raster.contributing_pairs);
  }
}

TEST_CASE("cuda embedding: two renderers on two streams in two threads draw what each draws alone") {
  if (without_device()) return;
  const DeviceArrays first(random_scene(9000, 1, 3)), second(random_scene(7000, 3, 4));
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

TEST_CASE("cuda embedding: frames of one renderer between frames of another are their own") {
  if (without_device()) return;
  Usual first, second;
  const auto a = first.backend().upload(random_scene(3000, 0, 5)),
             b = second.backend().upload(random_scene(500, 1, 6));
  const Frame alone_a = first.render(a, forward_camera(90, 60)),
              alone_b = second.render(b, forward_camera(40, 70));
  for (int i = 0; i < 5; ++i) {
    CHECK(same_bits(first.render(a, forward_camera(90, 60)).colour, alone_a.colour));
    CHECK(same_bits(second.render(b, forward_camera(40, 70)).colour, alone_b.colour));
  }
}

TEST_CASE_TEMPLATE("cuda embedding: a steady frame allocates nothing", Sort, StandardSort, EarlySort,
                   AdaptiveSort) {
  if (without_device()) return;
  const Stream stream;
  Renderer<Cuda, Sort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer{Cuda(stream.get())};
  const auto scene = renderer.backend().upload(random_scene(20'000, 2, 7));
  RenderSettings settings = with_planes();
  settings.count = true;
  DeviceFrame large(400, 300), small(120, 200);
  const auto render = [&](int frames) {
    for (int i = 0; i < frames; ++i)
      for (DeviceFrame* image : {&large, &small})
        renderer.render_into(scene.view(), forward_camera(image->width, image->height), settings,
                             image->view());
  };
  render(60);  // until all points in time have been made
  const std::size_t warm = free_memory();
  render(100);
  CHECK(free_memory() == warm);
}

TEST_CASE("cuda embedding: a renderer stays usable after what it refuses") {
  if (without_device()) return;
  Usual renderer;
  const Scene scene = random_scene(500, 2, 8);
  const DeviceArrays arrays(scene);
  const Camera camera = forward_camera(40, 30);
  const Frame expected = renderer.render(renderer.backend().upload(scene), camera);
  DeviceFrame image(40, 30);
  FrameView narrow = image.view();
  narrow.colour.pitch = -476;
  SceneView uneven = arrays.view();
  uneven.opacities.size = 9;
  CHECK_THROWS_AS(renderer.render_into(arrays.view(), camera, {}, narrow), std::invalid_argument);
  CHECK_THROWS_AS(renderer.render_into(uneven, camera, {}, image.view()), std::invalid_argument);
  CHECK(same_bits(renderer.render(renderer.backend().upload(scene), camera).colour, expected.colour));
}

TEST_CASE("cuda embedding: a renderer by name works on the stream and in the memory that its options name") {
  if (without_device()) return;
  const auto scene = std::make_shared<const Scene>(random_scene(2000, 1, 8));
  Usual typed;
  const DeviceScene uploaded = typed.backend().upload(scene);
  const Stream stream;
  StreamPool pool(stream.get());
  {
    const auto any = make_renderer(Usual::name, {.stream = stream.get(), .memory = pool.hook()});
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
