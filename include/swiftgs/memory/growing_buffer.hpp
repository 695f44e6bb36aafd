// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>

#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/span.hpp>

namespace swiftgs {

/// Memory from `operator new`, aligned to a cache line.
struct CacheLineMemory {
  static void* allocate(std::size_t bytes) { return ::operator new (bytes, std::align_val_t{64}); }
  static void release(void* memory) { ::operator delete (memory, std::align_val_t{64}); }
};

/// Uninitialised memory that grows, and shrinks by `trim` alone, so that a steady frame allocates nothing. It
/// comes from `Memory` unless a hook was given. Vector code may read and write 64 bytes beyond its end.
template <class T, class Memory = CacheLineMemory>
class GrowingBuffer {
  static_assert(std::is_trivially_copyable_v<T>, "GrowingBuffer holds plain data only");

 public:
  GrowingBuffer() = default;
  explicit GrowingBuffer(const MemoryHook& hook) : hook_(hook) {}
  ~GrowingBuffer() { trim(); }
  /// Takes over memory and hook. A moved-from buffer is empty and keeps its hook.
  GrowingBuffer(GrowingBuffer&& other) noexcept
      : hook_(other.hook_),
        memory_(std::exchange(other.memory_, nullptr)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  GrowingBuffer& operator=(GrowingBuffer&& other) noexcept {
    if (this == &other) return *this;
    trim();
    hook_ = other.hook_;
    memory_ = std::exchange(other.memory_, nullptr);
    size_ = std::exchange(other.size_, 0), capacity_ = std::exchange(other.capacity_, 0);
    return *this;
  }

  /// Gives its memory back and takes memory from `hook` from now on.
  void use(const MemoryHook& hook) {
    trim();
    hook_ = hook;
  }

  /// Gives its memory back.
  void trim() {
    if (memory_) hook_.release(hook_.context, memory_, bytes());
    memory_ = nullptr;
    capacity_ = size_ = 0;
  }

  /// Holds `count` elements. If the buffer grows, it takes memory for an eighth more. Its contents are
  /// undefined afterwards.
  void reset(std::size_t count) {
    if (count > capacity_) allocate(count + count / 8);
    size_ = count;
  }

  /// As `reset`, but keeps the contents that fit. For memory that a host reaches.
  void resize(std::size_t count) {
    if (count > capacity_) {
      GrowingBuffer larger(hook_);
      larger.reset(count);
      if (size_ != 0) std::memcpy(larger.data(), data(), size_ * sizeof(T));
      *this = std::move(larger);
    }
    size_ = count;
  }

  /// Holds exactly `count` elements, for data that will not grow.
  void reset_exactly(std::size_t count) {
    if (count > capacity_) allocate(count);
    size_ = count;
  }

  T* data() { return memory_; }
  const T* data() const { return memory_; }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  std::size_t bytes() const { return capacity_ ? capacity_ * sizeof(T) + padding : 0; }
  Span<T> span() { return {data(), size_}; }
  Span<const T> span() const { return {data(), size_}; }

 private:
  static constexpr std::size_t padding = 64;

  void allocate(std::size_t capacity) {
    // Empty while the allocation may throw. The old memory is freed first, because its contents are not kept.
    trim();
    if (capacity > (std::numeric_limits<std::size_t>::max() - padding) / sizeof(T)) throw std::bad_alloc();
    void* const memory = hook_.allocate(hook_.context, capacity * sizeof(T) + padding);
    if (!memory) throw std::bad_alloc();
    memory_ = static_cast<T*>(memory);
    capacity_ = capacity;
  }

  MemoryHook hook_ = hook_of<Memory>();
  T* memory_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace swiftgs
