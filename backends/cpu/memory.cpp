// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#ifndef MADV_COLLAPSE
#define MADV_COLLAPSE 25  // Linux 6.1; C libraries know it later
#endif
#endif

#include <swiftgs/cpu/stages.hpp>

namespace swiftgs {
namespace {

constexpr std::size_t page = std::size_t(2) << 20;

/// Asks for whole large pages of [memory, memory + bytes). Advice only: where it is refused, everything works
/// all the same.
void advise_large_pages(const void* memory, std::size_t bytes, LargePages pages) {
#if defined(__linux__)
  const std::uintptr_t begin = (reinterpret_cast<std::uintptr_t>(memory) + page - 1) / page * page;
  const std::uintptr_t end = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / page * page;
  if (begin >= end) return;
  (void)madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
  if (pages == LargePages::now) (void)madvise(reinterpret_cast<void*>(begin), end - begin, MADV_COLLAPSE);
#else
  (void)memory, (void)bytes, (void)pages;
#endif
}

HostScene in_large_pages(HostScene scene, LargePages pages) {
  const auto advise = [&](const char*, std::size_t, const auto& array) {
    if constexpr (requires { array.labels; })
      if (array.labels) return;  // a palette is small
    advise_large_pages(array.data, array.size * array.stride, pages);
  };
  for_each_array(advise, scene.view());
  return scene;
}

}  // namespace

void* LargePageMemory::allocate(std::size_t bytes) {
  const std::size_t alignment = bytes < page ? 64 : page;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, rounded);
  if (!memory) throw std::bad_alloc();
#if defined(__linux__)
  if (alignment == page) (void)madvise(memory, rounded, MADV_HUGEPAGE);
#endif
  return memory;
}

void LargePageMemory::release(void* memory) { std::free(memory); }

Cpu::SceneOn Cpu::upload(std::shared_ptr<const Scene> scene, HarmonicsKept kept, LargePages pages) const {
  return in_large_pages(SceneOn(*this, std::move(scene), kept), pages);
}

Cpu::SceneOn Cpu::upload(Scene scene, HarmonicsKept kept, LargePages pages) const {
  return in_large_pages(SceneOn(*this, std::move(scene), kept), pages);
}

Cpu::SceneOn Cpu::upload(const SceneArrays& arrays, std::optional<SceneOn>& reuse) const {
  return in_large_pages(SceneOn::copy(*this, arrays, reuse), LargePages::later);
}

void Cpu::update(SceneOn& scene, std::size_t first, const SceneArrays& arrays) const {
  const vec3* const before = scene.view().means.data;
  scene.update(*this, first, arrays);
  if (scene.view().means.data != before) in_large_pages(scene, LargePages::later);
}

}  // namespace swiftgs
