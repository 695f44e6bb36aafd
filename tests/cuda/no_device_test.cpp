// SPDX-License-Identifier: Apache-2.0

// A build with CUDA on a machine that has no device: everything says so and nothing else changes.
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/cuda.hpp>
#include <swiftgs/edit/pruning.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/random_splats.hpp"
#include "support/skip.hpp"

using namespace swiftgs;
using swiftgs::test::forward_camera;
using swiftgs::test::random_scene;

namespace {

bool with_device() {
  if (!Cuda::usable()) return false;
  test::skip("there is a CUDA device");
  return true;
}

/// What `f` throws as a DeviceError.
template <class F>
std::string device_error(const F& f) {
  try {
    f();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "no error";
}

/// Whether `message` is one line of the call and a text after it.
bool names(const std::string& message, const std::string& call) {
  return message.rfind(call + ": ", 0) == 0 && message.size() > call.size() + 2 &&
         message.find('\n') == std::string::npos;
}

}  // namespace

TEST_CASE("no device: the table lists every cuda renderer as not usable, and it is refused by its name") {
  if (with_device()) return;
  std::size_t refused = 0;
  for (const RendererEntry& entry : renderers()) {
    CAPTURE(entry.name);
    if (!entry.on_device) CHECK(entry.usable);
    if (!entry.name.starts_with("cuda/")) continue;
    CHECK(!entry.usable);
    ++refused;
    CHECK_THROWS_WITH_AS(make_renderer(entry.name),
                         ("renderer '" + entry.name + "' cannot run on this machine").c_str(),
                         std::runtime_error);
  }
  CHECK(refused > 0);
}

TEST_CASE("no device: every use of the backend throws the call that failed and why") {
  if (with_device()) return;
  CHECK_FALSE(Cuda::usable());
  Cuda cuda;
  CHECK(cuda.stream() == nullptr);
  CHECK(names(device_error([&] { cuda.upload(random_scene(10, 1, 1)); }), "cudaMalloc"));
  CHECK(names(device_error([&] { cuda.upload(Scene()); }), "cudaStreamSynchronize"));
  CHECK(names(device_error([&] { cuda.now(); }), "cudaEventCreate"));
  CHECK(names(device_error([&] { DeviceMemory::allocate(16); }), "cudaMalloc"));
  std::uint32_t word = 1;
  CHECK(names(device_error([&] { cuda.clear(&word, 4); }), "cudaMemsetAsync"));
  const auto download = [&](std::size_t count) {
    std::vector<std::uint32_t> words(count);
    cuda.download(Span<const std::uint32_t>{words.data(), count}, words.data());
  };
  CHECK(names(device_error([&] { download(1); }), "cudaMallocHost"));
  CHECK(names(device_error([&] { download(100'000); }), "cudaMemcpyAsync to the host"));
  CHECK(device_error([&] { cuda.exclusive_scan({&word, 1}); }) != "no error");
  CHECK(word == 1);
}

TEST_CASE("no device: a renderer throws as often as it is asked and goes away quietly") {
  if (with_device()) return;
  Renderer<Cuda, EarlySort, PerPixel, Ellipse> renderer;
  const Scene scene = random_scene(10, 0, 2);
  for (int i = 0; i < 3; ++i)
    CHECK_THROWS_AS(renderer.render_into(view(scene), forward_camera(8, 8), {}, {.width = 8, .height = 8}),
                    DeviceError);
  const Renderer<Cuda, EarlySort, PerPixel, Ellipse> moved = std::move(renderer);
  CHECK(moved.lists().intersections == 0);
}

TEST_CASE("no device: what does nothing needs none") {
  if (with_device()) return;
  Cuda cuda;
  CHECK(cuda.exclusive_scan({}) == 0);
  cuda.download(Span<const std::uint32_t>{}, static_cast<std::uint32_t*>(nullptr));
  cuda.clear(nullptr, 0);
  Pairs<Cuda, std::uint32_t> none;
  cuda.sort_pairs(none, 0, 32);
  CHECK_FALSE(cuda.milliseconds({}, {}));
  DeviceBuffer<float> buffer;
  buffer.reset(0);
  CHECK(buffer.data() == nullptr);
  Cuda other(std::move(cuda));
  cuda = std::move(other);
}

TEST_CASE("no device: weights of Gaussians are found by another backend") {
  if (with_device()) return;
  CHECK(contribution_backend("").backend != "cuda");
  CHECK_THROWS_WITH_AS(contribution_backend("cuda"), "backend 'cuda' cannot run on this machine",
                       std::runtime_error);
  const auto scene = std::make_shared<const Scene>(random_scene(10, 0, 2));
  CHECK_THROWS_AS(Contributions<Cuda>{scene}, DeviceError);
}
