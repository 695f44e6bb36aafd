// SPDX-License-Identifier: Apache-2.0

// Ten thousand frames and hundreds of renderers: what is taken is given back, and what cannot be had does no
// harm.
#include <string>
#include <vector>

#include "cuda/device.hpp"
#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// A scene of `count` Gaussians that are all zero, in 16 bytes for each.
SceneView zeros(const Cuda& cuda, std::size_t count, DeviceBuffer<Quaternion>& memory) {
  memory.reset(count);
  cuda.clear(memory.data(), count * sizeof(Quaternion));
  const auto floats = reinterpret_cast<const float*>(memory.data());
  const auto vectors = reinterpret_cast<const vec3*>(memory.data());
  return {.means = {vectors, count},
          .scales = {vectors, count},
          .rotations = {memory.data(), count},
          .opacities = {floats, count},
          .sh0 = {vectors, count},
          .sh_rest = {}};
}

/// What a renderer that has not enough memory says.
std::string refusal(BoundRenderer<Cuda>& renderer, const SceneView& scene, const Camera& camera) {
  try {
    // No output is asked for, so the frame itself takes no memory.
    renderer.render_into(scene, camera, {}, {.width = camera.width, .height = camera.height});
  } catch (const CapacityError& error) {
    return error.what();
  }
  return "drawn";
}

}  // namespace

SWIFTGS_DEVICE_CASES("cuda endurance: ten thousand frames keep their bits and take no memory", Sort,
                     StandardSort, EarlySort, AdaptiveSort) {
  const Stream stream;
  Usual<Cuda, Sort> renderer{Cuda(stream.get())};
  const auto scene = renderer.backend().upload(random_scene(300, 0, 1));
  const Camera cameras[] = {forward_camera(64, 48), forward_camera(48, 80), forward_camera(33, 17)};
  std::vector<PlanesOn<Cuda>> images;
  for (const Camera& camera : cameras)
    images.emplace_back(renderer.backend(), camera.width, camera.height, Outputs{true, true});
  const auto counted = [](bool count) {
    RenderSettings settings;
    settings.count = count;
    return settings;
  };
  const auto render = [&](int frames) {
    for (int i = 0; i < frames; ++i)
      renderer.render_into(scene.view(), cameras[i % 3], counted(i % 2), images[std::size_t(i % 3)].view());
  };
  const auto colours = [&] {
    std::vector<std::vector<float>> out;
    for (PlanesOn<Cuda>& image : images) out.push_back(image.on_host(renderer.backend()).colour);
    return out;
  };
  render(300);
  const auto first = colours();
  const std::size_t warm = free_memory();
  render(10'000);
  CHECK(free_memory() == warm);
  CHECK((colours() == first));
}

SWIFTGS_DEVICE_CASE("cuda endurance: renderers and scenes give back what they took") {
  const Scene scene = random_scene(20'000, 3, 2);
  const auto one = [&] {
    const Stream stream;
    Usual<Cuda, AdaptiveSort> renderer{Cuda(stream.get())};
    Frame frame;
    renderer.render(renderer.backend().upload(scene), forward_camera(100, 80), {}, frame);
  };
  for (int i = 0; i < 10; ++i) one();
  const std::size_t warm = free_memory();
  for (int i = 0; i < 200; ++i) one();
  CHECK(free_memory() == warm);
}

SWIFTGS_DEVICE_CASE("cuda endurance: memory that cannot be had is a capacity error and the device works on") {
  const Cuda cuda;
  constexpr std::size_t pebibyte = std::size_t(1) << 50;
  try {
    DeviceMemory::allocate(pebibyte);
    FAIL_CHECK("a pebibyte was allocated");
  } catch (const CapacityError& error) {
    CHECK(error.needed() == pebibyte);
    CHECK(error.limit() > 0);
    CHECK(error.limit() < pebibyte);
    CHECK(std::string(error.what()).find("bytes of device memory") != std::string::npos);
  }
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
}

SWIFTGS_DEVICE_CASE("cuda endurance: a renderer that runs out of memory in a frame draws the next one") {
  Usual<Cuda, StandardSort> standard;
  Usual<Cuda> early;
  const Cuda& cuda = early.backend();
  const auto scene = cuda.upload(random_scene(300, 1, 3)), giants = cuda.upload(giants_of(2000));
  const Camera camera = forward_camera(64, 48), huge = forward_camera(4096, 4096);
  DeviceBuffer<Quaternion> memory;
  const SceneView many = zeros(cuda, 24'000'000, memory);
  const std::vector<float> expected = early.render(scene, camera).colour;
  CHECK(same_bits(standard.render(scene, camera).colour, expected));

  // 131 million intersections take 1.5 GB or more. Gaussians that no view shows take no memory, however many
  // they are: as splats, these would take 0.77 GB for their shapes alone.
  constexpr std::size_t left = 700'000'000;
  const std::size_t free = free_memory();
  REQUIRE(free > left);
  DeviceBuffer<unsigned char> ballast;
  ballast.reset_exactly(free - left);
  const auto runs_out = [&](auto& renderer) {
    CHECK(refusal(renderer, giants.view(), huge).find("bytes of device memory") != std::string::npos);
    CHECK(same_bits(renderer.render(scene, camera).colour, expected));
    CHECK(refusal(renderer, many, huge) == "drawn");
    CHECK(same_bits(renderer.render(scene, camera).colour, expected));
  };
  runs_out(standard), runs_out(early);
  ballast = {};
  CHECK(refusal(early, giants.view(), huge) == "drawn");
  CHECK(refusal(early, many, huge) == "drawn");
  CHECK(same_bits(standard.render(scene, camera).colour, expected));
  CHECK(same_bits(early.render(scene, camera).colour, expected));
}
