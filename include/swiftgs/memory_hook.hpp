// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include <swiftgs/message.hpp>

namespace swiftgs {

/// Functions that give a backend its memory. Pass one to the backend's constructor.
///
/// A renderer calls them from the thread that calls the renderer. What `context` points to outlives the
/// backend, its renderers and the scenes that it uploaded.
struct MemoryHook {
  /// Memory of `bytes` bytes, aligned to 64 bytes on a host and to 256 on a device. Without memory it
  /// throws or returns null: an exception reaches the caller of the renderer, null becomes `std::bad_alloc`.
  /// The renderer stays usable.
  void* (*allocate)(void* context, std::size_t bytes) = nullptr;
  /// Takes back what `allocate` returned for as many bytes. Does not throw.
  void (*release)(void* context, void* memory, std::size_t bytes) = nullptr;
  void* context = nullptr;
};

/// Throws `InvalidArgument` if a function is missing.
inline void validate(const MemoryHook& hook) {
  if (!hook.allocate || !hook.release)
    detail::refuse("memory hook: no function to ", hook.allocate ? "release" : "allocate",
                   ", expected both functions");
}

/// The functions of `Memory`, which has no state.
template <class Memory>
constexpr MemoryHook hook_of() {
  return {[](void*, std::size_t bytes) -> void* { return Memory::allocate(bytes); },
          [](void*, void* memory, std::size_t) { Memory::release(memory); }, nullptr};
}

}  // namespace swiftgs
