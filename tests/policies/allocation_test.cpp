// SPDX-License-Identifier: Apache-2.0

// What the library takes from the system: the functions that it takes memory by are those of this file, which
// count. What oneTBB keeps for its tasks it takes from malloc, and is not seen.
#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>
#include <optional>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/memory/scene_arrays.hpp>

#include "policies/arrays_on.hpp"
#include "policies/counted_memory.hpp"
#include "policies/rasterizers.hpp"
#include "support/skip.hpp"

#if defined(__linux__)
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>
#ifndef MADV_COLLAPSE
#define MADV_COLLAPSE 25
#endif
#endif

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

std::atomic<std::size_t> allocations{0};  // of all memory
[[maybe_unused]] int moves = 0;           ///< arrays that the system was asked to move to large pages at once

void* allocate(std::size_t alignment, std::size_t size) {
  ++allocations;
  void* memory = nullptr;
  if (posix_memalign(&memory, alignment, size ? size : 1) != 0) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return allocate(alignof(std::max_align_t), size); }
// `CacheLineMemory` and `LargePageMemory` end here. Only they align to exactly 64 bytes.
void* operator new(std::size_t size, std::align_val_t alignment) {
  if (std::size_t(alignment) == 64) ++own_allocations;
  return allocate(std::size_t(alignment), size);
}
// Not inlined: GCC would warn that `std::free` does not fit `new`.
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
#if !defined(__SANITIZE_ADDRESS__)  // which has its own
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++allocations, ++own_allocations;
  void* memory = nullptr;
  return posix_memalign(&memory, alignment, size) == 0 ? memory : nullptr;
}
#endif
#if defined(__linux__)
extern "C" int madvise(void* memory, size_t bytes, int advice) noexcept {
  moves += advice == MADV_COLLAPSE;
  return int(syscall(SYS_madvise, memory, bytes, advice));
}
#endif

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

TEST_CASE("an update allocates nothing where no caller has the scene") {
  const auto steady = [](const auto& backend) {
    const auto shared = std::make_shared<const Scene>(order_spatially(make_builtin_scene(2000)));
    const std::vector<vec3> means(1000, vec3(0.5f, 1, 2));
    const std::vector<float> logits(1000, 0.5f);
    const SceneArrays arrays{
        .count = 1000, .means = {&means[0].x}, .opacities = {logits.data()}, .logit_opacities = true};
    auto own = backend.upload(*shared), copied = backend.upload(shared);
    const auto update_both = [&](std::size_t times) {
      for (std::size_t i = 0; i < times; ++i)
        backend.update(own, 7 * i, arrays), backend.update(copied, 7 * i, arrays);
    };
    REQUIRE_FALSE(own.view().chunks.empty());
    const std::size_t before = allocations;
    update_both(20);
    const std::size_t warm = allocations;
    update_both(20);
    const std::size_t after = allocations;
    CHECK(after == warm);
    CHECK(warm >= before + 6);  // the arrays of the caller's scene
  };
  steady(Serial());
  steady(Cpu(2));
}

TEST_CASE("cpu: an upload moves arrays to large pages only if asked to") {
#if defined(__linux__)
  const Cpu cpu;
  const auto scene = std::make_shared<const Scene>(make_builtin_scene(400'000));
  const ArraysOn<Cpu> arrays(cpu, *scene);
  std::optional<Cpu::SceneOn> copy;
  moves = 0;
  (void)cpu.upload(scene);
  copy.emplace(cpu.upload(arrays.all, copy));
  copy.emplace(cpu.upload(arrays.all, copy));
  CHECK(moves == 0);
  (void)cpu.upload(scene, HarmonicsKept::smallest, LargePages::now);
  CHECK(moves == 5);  // the opacities fill no page
#else
  skip("large pages are advised on Linux alone");
#endif
}
