// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <cstdlib>
#include <new>

#include <doctest/doctest.h>

#include "policies/rasterizers.hpp"

namespace {

// Allocations of this program through operator new and aligned_alloc: all of ours. What oneTBB keeps for its
// tasks it takes from malloc, and is not seen.
std::atomic<std::size_t> allocations{0};

void* allocate(std::size_t alignment, std::size_t size) {
  ++allocations;
  void* memory = nullptr;
  if (posix_memalign(&memory, alignment, size ? size : 1) != 0) throw std::bad_alloc();
  return memory;
}

}  // namespace

// Every way in which the library takes memory passes through here.
void* operator new(std::size_t size) { return allocate(alignof(std::max_align_t), size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(std::size_t(alignment), size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
#if !defined(__SANITIZE_ADDRESS__)  // which has its own
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++allocations;
  void* memory = nullptr;
  return posix_memalign(&memory, alignment, size) == 0 ? memory : nullptr;
}
#endif

using namespace swiftgs;
using namespace swiftgs::test;

TEST_CASE_TEMPLATE("a steady frame allocates nothing", Sort, StandardSort, EarlySort, AdaptiveSort) {
  const auto steady = [](auto renderer) {
    const auto scene = renderer.backend().upload(random_scene(1000, 2, 1));
    RenderSettings settings;
    settings.outputs = {true, true}, settings.count = true;
    const Camera camera = forward_camera(100, 80);
    Frame frame;
    const std::size_t before = allocations;
    for (int i = 0; i < 12; ++i) renderer.render(scene, camera, settings, frame);
    const std::size_t warm = allocations;
    for (int i = 0; i < 5; ++i) renderer.render(scene, camera, settings, frame);
    // A smaller frame needs no more.
    renderer.render_into(scene.view(), scaled(camera, 0.5), settings,
                         {.width = 50, .height = 40, .colour = {frame.colour.data(), 600}});
    const std::size_t after = allocations;
    CHECK(after == warm);
    CHECK(warm > before + 8);  // the counter counts
  };
  steady(Renderer<Serial, Sort, AxisSharedThreshold<FloatCholesky>, Ellipse>());
  steady(Renderer<Serial, Sort, PerPixel, ThreeSigmaSquare>());
  steady(Renderer<Cpu, Sort, AxisSharedThreshold<FloatCholesky>, Ellipse>(Cpu(2)));
  steady(Renderer<Cpu, Sort, AxisShared<HalfSplit>, OpacityBox>(Cpu(1)));
}
