// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

#include <swiftgs/span.hpp>

namespace swiftgs {

/// Memory from `operator new`, aligned to a cache line.
struct CacheLineMemory {
  static void* allocate(std::size_t bytes) { return ::operator new (bytes, std::align_val_t{64}); }
  static void release(void* memory) { ::operator delete (memory, std::align_val_t{64}); }
};

/// Uninitialised host memory that grows and never shrinks, so that a steady frame allocates nothing.
/// Aligned to a cache line; a vector register of 64 bytes may be read or written beyond its end.
template <class T, class Memory = CacheLineMemory>
class HostBuffer {
  static_assert(std::is_trivially_copyable_v<T>, "HostBuffer holds plain data only");

 public:
  /// Makes room for `count` elements. What was in the buffer is undefined afterwards.
  void reset(std::size_t count) {
    if (count > capacity_) {
      // Empty while the allocation may throw; what is there is freed first, as it need not be kept.
      memory_.reset();
      capacity_ = size_ = 0;
      const std::size_t room = count + count / 8;
      memory_.reset(static_cast<T*>(Memory::allocate(room * sizeof(T) + padding)));
      capacity_ = room;
    }
    size_ = count;
  }

  T* data() { return memory_.get(); }
  const T* data() const { return memory_.get(); }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  Span<T> span() { return {data(), size_}; }
  Span<const T> span() const { return {data(), size_}; }

 private:
  static constexpr std::size_t padding = 64;
  struct Free {
    void operator()(T* memory) const { Memory::release(memory); }
  };
  std::unique_ptr<T, Free> memory_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace swiftgs
