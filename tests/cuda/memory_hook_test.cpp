// SPDX-License-Identifier: Apache-2.0

// Where the device memory of `Cuda` comes from, when it is taken and when it is given back. The hook is a
// pool that works in the order of the renderer's stream: memory that is released too early is overwritten.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <vector>

#include <cuda_runtime_api.h>
#include <doctest/doctest.h>

#include <swiftgs/contribution.hpp>
#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>
#include <swiftgs/swiftgs.hpp>

#include "cuda/device.hpp"
#include "cuda/graph.hpp"
#include "cuda/stream_pool.hpp"
#include "policies/random_splats.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

using Usual = AxisSharedThreshold<FloatCholesky>;

/// Images of views on the device.
struct Images {
  DeviceBuffer<float> pixels;  ///< RGB of one view behind the other
  std::vector<View> views;

  explicit Images(const std::vector<Camera>& cameras) {
    std::size_t count = 0;
    for (const Camera& camera : cameras) count += 3 * std::size_t(camera.width) * std::size_t(camera.height);
    pixels.reset(count);
    check_cuda(cudaMemset(pixels.data(), 0xff, count * sizeof(float)), "cudaMemset");
    check_cuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
    float* at = pixels.data();
    for (const Camera& camera : cameras) {
      FrameView frame{.width = camera.width, .height = camera.height};
      frame.colour = {at, std::ptrdiff_t(3 * sizeof(float)) * camera.width};
      at += 3 * std::size_t(camera.width) * std::size_t(camera.height);
      views.push_back(make_view(camera, Conventions::gsplat(), frame, vec3(0.25f)));
    }
  }
  Span<const View> span() const { return {views.data(), views.size()}; }
  /// After all work of the device.
  std::vector<std::uint32_t> bits() const {
    std::vector<std::uint32_t> host(pixels.size());
    check_cuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
    check_cuda(cudaMemcpy(host.data(), pixels.data(), host.size() * sizeof(float), cudaMemcpyDeviceToHost),
               "cudaMemcpy");
    return host;
  }
};

std::vector<Camera> cameras_of(int frame, int views, double scale = 1) {
  std::vector<Camera> cameras;
  for (int v = 0; v < views; ++v) {
    const int width = int(scale * (160 + 16 * v)), height = int(scale * 120);
    Camera camera = forward_camera(width, height, scale * (80 + 50 * std::cos(0.13 * frame)));
    camera.cx += 2.0 * v + 0.3 * frame;
    cameras.push_back(camera);
  }
  return cameras;
}

FrameReport report_in(const DeviceBuffer<FrameReport>& memory) {
  FrameReport report;
  check_cuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
  check_cuda(cudaMemcpy(&report, memory.data(), sizeof report, cudaMemcpyDeviceToHost), "cudaMemcpy");
  return report;
}

std::size_t all_of(const StageMemory& memory) { return memory.project + memory.sort + memory.raster; }

template <class Sort>
using Rendering = Renderer<Cuda, Sort, Usual, Ellipse>;

}  // namespace

TEST_CASE_TEMPLATE("cuda memory hook: growth and destruction keep the order of the stream", Sort,
                   StandardSort, EarlySort, AdaptiveSort) {
  if (without_device()) return;
  const Scene scene = random_scene(40000, 3, 1);
  const Stream stream;
  Rendering<Sort> plain;
  const DeviceScene uploaded = plain.backend().upload(scene);
  constexpr int rounds = 12;
  std::vector<Images> expected, images;
  for (int i = 0; i < rounds; ++i) {
    // Sizes that go up and down, so that memory of one renderer soon becomes that of the next.
    const std::vector<Camera> cameras = cameras_of(i, 1 + i % 3, 1 + 0.4 * (i % 4));
    expected.emplace_back(cameras), images.emplace_back(cameras);
    plain.render_into(uploaded.view(), expected.back().span());
  }
  plain.backend().wait();

  StreamPool pool(stream.get());
  {
    // Nothing here waits for the last kernels of a frame.
    Rendering<Sort> kept(Cuda(stream.get(), pool.hook()));
    for (int i = 0; i < rounds; ++i) {
      kept.render_into(uploaded.view(), images[std::size_t(i)].span());
      Rendering<Sort> gone(Cuda(stream.get(), pool.hook()));
      gone.render_into(uploaded.view(), images[std::size_t(i)].span());
    }
  }
  CHECK(pool.in_use() == 0);
  CHECK(pool.allocations() > 100);
  for (std::size_t i = 0; i < rounds; ++i) CHECK(images[i].bits() == expected[i].bits());
}

TEST_CASE("cuda memory hook: a scene is taken from it and released with its last copy") {
  if (without_device()) return;
  const Scene scene = random_scene(5000, 2, 2);
  const Stream stream;
  StreamPool pool(stream.get());
  Rendering<EarlySort> renderer(Cuda(stream.get(), pool.hook())), plain;
  const DeviceScene ordinary = plain.backend().upload(scene);
  Images images(cameras_of(0, 1)), expected(cameras_of(0, 1));
  plain.render_into(ordinary.view(), expected.span());
  CHECK(pool.in_use() == 0);
  {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    const std::size_t bytes = pool.in_use();
    CHECK(bytes >= 5000 * (56 + 96));
    const DeviceScene copy = uploaded;
    CHECK(pool.in_use() == bytes);
    renderer.render_into(copy.view(), images.span());
  }  // while the frame may still be under way
  CHECK(pool.in_use() >= all_of(renderer.memory()));
  CHECK(all_of(renderer.memory()) > 0);
  CHECK(images.bits() == expected.bits());
  renderer.trim();
  CHECK(pool.in_use() == 0);
}

TEST_CASE("cuda record: a graph is captured and launched with memory of a pool") {
  if (without_device()) return;
  const Stream stream;
  StreamPool pool(stream.get());
  Rendering<EarlySort> renderer(Cuda(stream.get(), pool.hook())), other;
  const DeviceScene scene = other.backend().upload(random_scene(20000, 1, 6));
  Images images(cameras_of(0, 2));
  DeviceBuffer<FrameReport> report;
  report.reset(1);
  renderer.reserve(scene.view(), images.span(), {40000, 3'400'000});
  renderer.record(scene.view(), report.data());
  stream.wait();
  const std::size_t calls = pool.calls();
  const Graph graph(stream, [&] { renderer.record(scene.view(), report.data()); });
  for (const int frame : {0, 7, 24}) {
    Images views(cameras_of(frame, 2)), wanted(cameras_of(frame, 2));
    for (std::size_t v = 0; v < 2; ++v) views.views[v].frame = images.views[v].frame;
    renderer.set_views(views.span());
    graph.run();
    other.render_into(scene.view(), wanted.span());
    CHECK(images.bits() == wanted.bits());
    CHECK(report_in(report).overflowed == 0);
  }
  CHECK(pool.calls() == calls);
}
