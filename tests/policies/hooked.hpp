// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Renderers whose memory comes from a hook, and the frames that they draw. The hook of a device is a pool
/// that works in the order of its stream: memory that is released too early is overwritten.

#include <cmath>
#include <type_traits>
#include <vector>

#include "policies/backends.hpp"
#include "policies/counted_memory.hpp"
#include "policies/views.hpp"
#if defined(SWIFTGS_TEST_CUDA)
#include "cuda/stream_pool.hpp"
#endif

namespace swiftgs::test {

template <class B>
B make(const MemoryHook& memory, int threads = 2) {
  if constexpr (std::is_same_v<B, Cpu>)
    return Cpu(threads, memory);
  else
    return B(memory);
}

/// A hook that counts, and backends that take memory from it.
template <class B>
struct Hooked : CountedMemory {
  B backend(int threads = 2) { return make<B>(hook(), threads); }
};
#if defined(SWIFTGS_TEST_CUDA)
template <>
inline Cuda make<Cuda>(const MemoryHook& memory, int) {
  return Cuda(nullptr, memory);
}

struct WithStream {
  Stream stream;
};
template <>
struct Hooked<Cuda> : WithStream, StreamPool {
  Hooked() : StreamPool(stream.get()) {}
  Cuda backend(int = 2) { return Cuda(stream.get(), hook()); }
};
#endif

#if defined(SWIFTGS_TEST_VULKAN)
/// Memory of the device, by its own hook.
template <>
struct Hooked<Vulkan> : CountedBlocks {
  MemoryHook hook() { return {&Hooked::allocate, &Hooked::release, this}; }
  Vulkan backend(int = 2) { return Vulkan(VulkanDevice::own(), hook()); }

 private:
  static void* allocate(void* context, std::size_t bytes) {
    auto& self = *static_cast<Hooked*>(context);
    if (self.refuses(bytes)) return nullptr;
    void* const memory = VulkanMemory::allocate(bytes);
    self.add(memory, bytes);
    return memory;
  }
  static void release(void* context, void* memory, std::size_t bytes) {
    static_cast<Hooked*>(context)->remove(memory, bytes);
    VulkanMemory::release(memory);
  }
};
template <>
inline Vulkan make<Vulkan>(const MemoryHook& memory, int) {
  return Vulkan(VulkanDevice::own(), memory);
}
#endif

/// Stereo pairs that come nearer: the first show less than the later ones.
inline std::vector<AskedView> asked_of(int frame, int views, double scale = 1) {
  std::vector<AskedView> asked;
  for (int v = 0; v < views; ++v) {
    Camera camera = forward_camera(int(scale * (128 + 16 * v)), int(scale * 96),
                                   scale * (60.0 + 40 * std::cos(0.13 * frame)));
    camera.cx += 2.0 * v + 0.3 * frame;
    asked.push_back({camera, Conventions::gsplat(), vec3(0.25f)});
  }
  return asked;
}

/// A backend with a sort.
template <class B, class Sort>
struct Case {
  using Backend = B;
  using SortPolicy = Sort;
};
#define SWIFTGS_SORTS_ON(B) Case<B, StandardSort>, Case<B, EarlySort>, Case<B, AdaptiveSort>
#if defined(SWIFTGS_TEST_VULKAN)
#define SWIFTGS_SORTS_ON_HOSTS
#define SWIFTGS_SORTS_ON_BACKENDS Case<Vulkan, EarlySort>
#else
#define SWIFTGS_SORTS_ON_HOSTS SWIFTGS_SORTS_ON(Serial), SWIFTGS_SORTS_ON(Cpu)
#if defined(SWIFTGS_TEST_CUDA)
#define SWIFTGS_SORTS_ON_BACKENDS SWIFTGS_SORTS_ON_HOSTS, SWIFTGS_SORTS_ON(Cuda)
#else
#define SWIFTGS_SORTS_ON_BACKENDS SWIFTGS_SORTS_ON_HOSTS
#endif
#endif

}  // namespace swiftgs::test
