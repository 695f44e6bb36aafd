// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A memory hook that knows what is in use, and refuses when it is told to.

#include <atomic>
#include <cstddef>
#include <cstring>
#include <limits>
#include <map>
#include <new>
#include <stdexcept>

#include <doctest/doctest.h>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/memory/growing_buffer.hpp>

namespace swiftgs::test {

/// Allocations of the memory that backends of hosts have of their own. allocation_test.cpp counts them.
inline std::atomic<std::size_t> own_allocations{0};

/// Blocks that a hook has given out, and which allocation it refuses.
class CountedBlocks {
 public:
  enum class Refusal { null, exception };

  CountedBlocks() = default;
  CountedBlocks(const CountedBlocks&) = delete;
  CountedBlocks& operator=(const CountedBlocks&) = delete;
  ~CountedBlocks() { CHECK(in_use() == 0); }

  std::size_t allocations() const { return allocations_; }
  std::size_t calls() const { return allocations_ + releases_; }
  /// @units{bytes}
  std::size_t in_use() const {
    std::size_t bytes = 0;
    for (const auto& [memory, size] : blocks_) bytes += size;
    return bytes;
  }

  /// Refuses the allocation after `count` more; 0: the next.
  void refuse_after(std::size_t count, Refusal by) { refused_ = allocations_ + count, by_ = by; }
  void refuse_none() { refused_ = none; }

 protected:
  /// Counts an allocation. Whether it must return null; throws if it is refused so.
  bool refuses(std::size_t bytes) {
    if (allocations_++ != refused_) return false;
    if (by_ == Refusal::exception) throw CapacityError("bytes of a test", bytes, 0);
    return true;
  }
  void add(void* memory, std::size_t bytes) { blocks_[memory] = bytes; }
  void remove(void* memory, std::size_t bytes) {
    ++releases_;
    const auto found = blocks_.find(memory);
    REQUIRE(found != blocks_.end());
    CHECK(found->second == bytes);
    blocks_.erase(found);
  }

 private:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  std::map<void*, std::size_t> blocks_;
  std::size_t allocations_ = 0, releases_ = 0, refused_ = none;
  Refusal by_ = Refusal::null;
};

/// Memory of the host, aligned to 64 bytes and no more, and filled with garbage.
class CountedMemory : public CountedBlocks {
 public:
  MemoryHook hook() { return {&CountedMemory::allocate, &CountedMemory::release, this}; }

 private:
  static void* allocate(void* context, std::size_t bytes) {
    auto& self = *static_cast<CountedMemory*>(context);
    if (self.refuses(bytes)) return nullptr;
    auto* const memory = static_cast<unsigned char*>(::operator new (bytes + 64, std::align_val_t{128})) + 64;
    std::memset(memory, 0xa5, bytes);
    self.add(memory, bytes);
    return memory;
  }
  static void release(void* context, void* memory, std::size_t bytes) {
    static_cast<CountedMemory*>(context)->remove(memory, bytes);
    ::operator delete (static_cast<unsigned char*>(memory) - 64, std::align_val_t{128});
  }
};

/// Checks that `make(hook)` refuses hooks without both functions, and names the one that is missing.
template <class Make>
void check_missing_functions(const Make& make) {
  const MemoryHook whole = hook_of<CacheLineMemory>();
  CHECK_THROWS_WITH_AS(make(MemoryHook{}), "memory hook: no function to allocate, expected both functions",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(make(MemoryHook{.allocate = nullptr, .release = whole.release}),
                       "memory hook: no function to allocate, expected both functions",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(make(MemoryHook{.allocate = whole.allocate, .release = nullptr}),
                       "memory hook: no function to release, expected both functions", std::invalid_argument);
}

}  // namespace swiftgs::test
