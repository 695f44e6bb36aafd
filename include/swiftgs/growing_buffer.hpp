// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>
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

/// Uninitialised memory that grows and never shrinks, so that a steady frame allocates nothing. `Memory`
/// allocates it, by default on the host. Vector code may read and write 64 bytes beyond its end.
template <class T, class Memory = CacheLineMemory>
class GrowingBuffer {
  static_assert(std::is_trivially_copyable_v<T>, "GrowingBuffer holds plain data only");

 public:
  GrowingBuffer() = default;
  GrowingBuffer(GrowingBuffer&& other) noexcept
      : memory_(std::move(other.memory_)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  GrowingBuffer& operator=(GrowingBuffer&& other) noexcept {
    memory_ = std::move(other.memory_);
    size_ = std::exchange(other.size_, 0), capacity_ = std::exchange(other.capacity_, 0);
    return *this;
  }

  /// Makes room for `count` elements; if the buffer grows, for an eighth more. Its contents are undefined
  /// afterwards.
  void reset(std::size_t count) {
    if (count > capacity_) allocate(count + count / 8);
    size_ = count;
  }

  /// As `reset`, but keeps the contents, as many as there is room for. For memory that a host reaches.
  void resize(std::size_t count) {
    if (count > capacity_) {
      GrowingBuffer larger;
      larger.reset(count);
      if (size_ != 0) std::memcpy(larger.data(), data(), size_ * sizeof(T));
      *this = std::move(larger);
    }
    size_ = count;
  }

  /// Makes room for exactly `count` elements, for data that will not grow.
  void reset_exactly(std::size_t count) {
    if (count > capacity_) allocate(count);
    size_ = count;
  }

  T* data() { return memory_.get(); }
  const T* data() const { return memory_.get(); }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  std::size_t bytes() const { return capacity_ ? capacity_ * sizeof(T) + padding : 0; }
  Span<T> span() { return {data(), size_}; }
  Span<const T> span() const { return {data(), size_}; }

 private:
  static constexpr std::size_t padding = 64;

  void allocate(std::size_t room) {
    // Empty while the allocation may throw. The old memory is freed first, because its contents are not kept.
    memory_.reset();
    capacity_ = size_ = 0;
    memory_.reset(static_cast<T*>(Memory::allocate(room * sizeof(T) + padding)));
    capacity_ = room;
  }

  struct Free {
    void operator()(T* memory) const { Memory::release(memory); }
  };
  std::unique_ptr<T, Free> memory_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace swiftgs
