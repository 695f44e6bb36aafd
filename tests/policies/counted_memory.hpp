// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A memory hook that knows what is in use, and refuses when it is told to.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <new>

#include <doctest/doctest.h>

#include <swiftgs/error.hpp>
#include <swiftgs/memory_hook.hpp>

namespace swiftgs::test {

/// Memory of the host, aligned to 64 bytes and no more, and filled with garbage.
class CountedMemory {
 public:
  enum class Refusal { null, exception };

  CountedMemory() = default;
  CountedMemory(const CountedMemory&) = delete;
  CountedMemory& operator=(const CountedMemory&) = delete;
  ~CountedMemory() { CHECK(in_use() == 0); }

  MemoryHook hook() { return {&CountedMemory::allocate, &CountedMemory::release, this}; }

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

 private:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  static void* allocate(void* context, std::size_t bytes) {
    auto& self = *static_cast<CountedMemory*>(context);
    if (self.allocations_++ == self.refused_) {
      if (self.by_ == Refusal::null) return nullptr;
      throw CapacityError("bytes of a test", bytes, 0);
    }
    auto* const memory = static_cast<unsigned char*>(::operator new (bytes + 64, std::align_val_t{128})) + 64;
    std::memset(memory, 0xa5, bytes);
    self.blocks_[memory] = bytes;
    return memory;
  }
  static void release(void* context, void* memory, std::size_t bytes) {
    auto& self = *static_cast<CountedMemory*>(context);
    ++self.releases_;
    const auto found = self.blocks_.find(memory);
    REQUIRE(found != self.blocks_.end());
    CHECK(found->second == bytes);
    self.blocks_.erase(found);
    ::operator delete (static_cast<unsigned char*>(memory) - 64, std::align_val_t{128});
  }

  std::map<void*, std::size_t> blocks_;
  std::size_t allocations_ = 0, releases_ = 0, refused_ = none;
  Refusal by_ = Refusal::null;
};

}  // namespace swiftgs::test
