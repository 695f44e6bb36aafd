// SPDX-License-Identifier: Apache-2.0

// Ten thousand frames and hundreds of renderers: what is taken is given back, and what cannot be had does no
// harm.
#include "cuda/drawings.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

using Usual = Renderer<Cuda, AdaptiveSort, AxisSharedThreshold<FloatCholesky>, Ellipse>;

}  // namespace

TEST_CASE("cuda endurance: ten thousand frames keep their bits and take no memory") {
  if (without_device()) return;
  Usual renderer;
  const auto scene = renderer.backend().upload(random_scene(300, 0, 1));
  const Camera cameras[] = {forward_camera(64, 48), forward_camera(48, 80), forward_camera(33, 17)};
  std::vector<DeviceFrame> images;
  for (const Camera& camera : cameras) images.emplace_back(camera.width, camera.height);
  const auto render = [&](int frames) {
    for (int i = 0; i < frames; ++i)
      renderer.render_into(scene.view(), cameras[i % 3], {}, images[std::size_t(i % 3)].view());
  };
  const auto colours = [&] {
    std::vector<std::vector<float>> out;
    for (const DeviceFrame& image : images) out.push_back(image.pixels(renderer.backend(), image.colour, 12));
    return out;
  };
  render(300);
  const auto first = colours();
  const std::size_t warm = free_memory();
  render(10'000);
  CHECK(free_memory() == warm);
  CHECK((colours() == first));
}

TEST_CASE("cuda endurance: renderers and scenes give back what they took") {
  if (without_device()) return;
  const Scene scene = random_scene(20'000, 3, 2);
  const auto one = [&] {
    const Stream stream;
    Usual renderer{Cuda(stream.get())};
    Frame frame;
    renderer.render(renderer.backend().upload(scene), forward_camera(100, 80), {}, frame);
  };
  for (int i = 0; i < 10; ++i) one();
  const std::size_t warm = free_memory();
  for (int i = 0; i < 200; ++i) one();
  CHECK(free_memory() == warm);
}

TEST_CASE("cuda endurance: memory that cannot be had is a capacity error and the device works on") {
  if (without_device()) return;
  const Cuda cuda;
  constexpr std::size_t pebibyte = std::size_t(1) << 50;
  CHECK_THROWS_AS(DeviceMemory::allocate(pebibyte), CapacityError);
  CHECK(cudaGetLastError() == cudaSuccess);
  DeviceBuffer<float> buffer;
  buffer.reset(10);
  CHECK_THROWS_AS(buffer.reset(pebibyte / sizeof(float)), CapacityError);
  CHECK(buffer.size() == 0);
  CHECK(buffer.data() == nullptr);
  buffer.reset(10);
  CHECK(buffer.data() != nullptr);
  const DeviceBuffer<float> filled = to_device(std::vector<float>{1, 2, 3});
  CHECK(to_host(cuda, filled.span()) == std::vector<float>{1, 2, 3});
  try {
    DeviceMemory::allocate(pebibyte);
  } catch (const CapacityError& error) {
    CHECK(error.needed() == pebibyte);
    CHECK(error.limit() > 0);
    CHECK(error.limit() < pebibyte);
    CHECK(std::string(error.what()).find("bytes of device memory") != std::string::npos);
  }
}
