// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <swiftgs/cpu.hpp>

namespace swiftgs {
namespace {
constexpr std::size_t page = std::size_t(2) << 20;
}

void* LargePageMemory::allocate(std::size_t bytes) {
  const std::size_t alignment = bytes < page ? 64 : page;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, rounded);
  if (!memory) throw std::bad_alloc();
#if defined(__linux__)
  // Advice only: without it the memory works all the same.
  if (alignment == page) (void)madvise(memory, rounded, MADV_HUGEPAGE);
#endif
  return memory;
}

void LargePageMemory::release(void* memory) { std::free(memory); }

}  // namespace swiftgs
