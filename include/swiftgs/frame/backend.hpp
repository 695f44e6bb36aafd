// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/frame/span.hpp>

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

/// As `<cuda_runtime_api.h>` declares it: this header needs no toolkit.
struct CUstream_st;

namespace swiftgs {

namespace detail {
/// f(buffer) for every buffer of `part`: a buffer itself, or a struct whose static member `buffers` lists
/// buffers and such structs. A struct without that member passes for a buffer.
template <class Part, class F>
void for_each_buffer(Part& part, const F& f) {
  if constexpr (requires { Part::buffers(part); })
    std::apply([&](auto&... parts) { (for_each_buffer(parts, f), ...); }, Part::buffers(part));
  else
    f(part);
}

template <class Part>
constexpr bool has_bytes() {
  if constexpr (requires(const Part& part) { Part::buffers(part); })
    return []<class... Parts>(std::type_identity<std::tuple<const Parts&...>>) {
      return (has_bytes<Parts>() && ...);
    }(std::type_identity<decltype(Part::buffers(std::declval<const Part&>()))>());
  else
    return requires(const Part& part) {
      { part.bytes() } -> std::convertible_to<std::size_t>;
    };
}
}  // namespace detail

/// A buffer, a struct that lists its `buffers`, or a struct with a member `bytes`.
template <class Part>
concept HasBytes = detail::has_bytes<Part>();

/// Memory of all `parts`.
/// @units{bytes}
template <HasBytes... Parts>
std::size_t bytes_of(const Parts&... parts) {
  std::size_t bytes = 0;
  (detail::for_each_buffer(parts, [&](const auto& buffer) { bytes += buffer.bytes(); }), ...);
  return bytes;
}

/// Has the buffers of all `parts` take memory from `hook`. Structs that do not list their `buffers` keep to
/// the backend's own memory.
template <class... Parts>
void use_memory(const MemoryHook& hook, Parts&... parts) {
  const auto use = [&](auto& buffer) {
    if constexpr (requires { buffer.use(hook); }) buffer.use(hook);
  };
  (detail::for_each_buffer(parts, use), ...);
}

/// As above, with the hook of backend `b`, if backends of its type have one.
template <class B, class... Parts>
void use_memory_of(const B& b, Parts&... parts) {
  if constexpr (requires { b.memory_hook(); }) use_memory(b.memory_hook(), parts...);
}

/// Makes all `parts` new and empty: their memory is given back, and the next taken from the hook of `b`.
template <class B, class... Parts>
void trim_parts(const B& b, Parts&... parts) {
  ((parts = Parts()), ...);
  use_memory_of(b, parts...);
}

/// Keys with their values, and spare buffers that a sort exchanges with them.
template <class B, class Key>
struct Pairs {
  typename B::template Buffer<Key> keys, spare_keys;
  typename B::template Buffer<std::uint32_t> values, spare_values;

  void reset(std::size_t count) {
    keys.reset(count), spare_keys.reset(count);
    values.reset(count), spare_values.reset(count);
  }
  void reset_exactly(std::size_t count) {
    keys.reset_exactly(count), spare_keys.reset_exactly(count);
    values.reset_exactly(count), spare_values.reset_exactly(count);
  }
  static auto buffers(auto& self) {
    return std::tie(self.keys, self.spare_keys, self.values, self.spare_values);
  }
};

/// Throws if `b` cannot be given work now, before any memory is taken for it. Backends overload this.
template <class B>
void check_ready(const B&) {}

/// Takes the memory that `b` itself needs to sort up to `pairs` pairs, whatever their keys.
template <class B>
void reserve_sort(B& b, std::size_t pairs) {
  if constexpr (requires { b.reserve_sort(pairs); }) b.reserve_sort(pairs);
}

/// Used part of a memory, by all programs, and its size. @units{bytes}
struct MemoryUse {
  std::size_t in_use = 0, total = 0;
};

/// Memory that a renderer keeps for its stages, the scene excluded. @units{bytes}
struct StageMemory {
  std::size_t project = 0;  ///< splats, footprints and colours included
  std::size_t sort = 0;     ///< tile lists included
  std::size_t raster = 0;   ///< attributes, frames and picks that the renderer keeps

  std::size_t total() const { return project + sort + raster; }
};

/// Options of a renderer's backend. A backend ignores options that it does not use.
struct BackendOptions {
  int threads = 0;                     ///< of a host, 0 or more; 0: all
  ::CUstream_st* stream = nullptr;     ///< of a device, as its constructor takes it
  std::optional<MemoryHook> memory{};  ///< none: the backend's own
};

/// Makes a backend. Backends with options overload this, by their type.
template <class B>
B make_backend(std::type_identity<B>, const BackendOptions&) {
  return B();
}

namespace detail {
struct AnyIndexed {
  SWIFTGS_HD void operator()(std::size_t) const {}
};
}  // namespace detail

/// Policy: where memory lives. A backend is an object; its results do not depend on its
/// number of threads.
/// - `device_name()`: model of the processor or device, with the number of threads if that is a choice.
/// - `Buffer<T>`: memory that grows and that the backend's loops can reach (`GrowingBuffer`).
/// - `SceneOn`: an uploaded scene, with `view()`. Renderers that keep scenes ask for `upload` by themselves.
/// - `reaches_host_memory`: whether its loops can write to the host's own arrays.
/// - `download(from, to)`: copies to the host, after all work submitted so far; complete when it returns.
/// - `memory_use()`: of the backend's own memory; only for a backend that does not reach the host's memory.
/// - `wait()`: returns when all work submitted so far is done.
/// - `memory_hook()`: where renderers take memory from; only for a backend that has a choice.
/// - `trim()`, `reserve_sort(pairs)`: gives back the memory that it keeps for later calls, and takes what
/// sorts of so many pairs need of it; only for a backend that keeps any.
/// - `now()`, `milliseconds(from, to)`: points on the backend's own clock; no value before the backend has
/// reached `to`.
template <class B>
concept BackendPolicy = requires(B b, const typename B::SceneOn& scene, typename B::TimePoint time,
                                 Span<const std::uint32_t> from) {
  { B::name } -> std::convertible_to<std::string_view>;
  { B::usable() } -> std::same_as<bool>;
  { b.device_name() } -> std::same_as<std::string>;
  { B::reaches_host_memory } -> std::convertible_to<bool>;
  { scene.view() } -> std::same_as<SceneView>;
  b.download(from, static_cast<std::uint32_t*>(nullptr));
  b.wait();
  { b.now() } -> std::same_as<typename B::TimePoint>;
  { b.milliseconds(time, time) } -> std::same_as<std::optional<double>>;
};

/// A backend whose loops run functors of C++. All stages have generic forms for it; any other backend has
/// stages of its own, which see the addresses of buffers alone.
/// - `for_each(n, f)`: f(i) for every i in [0, n), in any order. Complete when it returns, or in stream
/// order. `n` is a `Count`, as is that of `sort_pairs`.
/// - `exclusive_scan(counts)`: sums in place, returns the total.
/// - `sort_pairs(pairs, n, bits)`: stable ascending sort by the low `bits` bits; the result is in `keys` and
/// `values`.
template <class B>
concept FunctorBackend = BackendPolicy<B> &&
    requires(B b, Span<std::uint32_t> counts, Pairs<B, std::uint32_t>& narrow,
             Pairs<B, std::uint64_t>& wide) {
  b.for_each(Count(), detail::AnyIndexed{});
  { b.exclusive_scan(counts) } -> std::same_as<std::uint64_t>;
  b.sort_pairs(narrow, Count(), int{});
  b.sort_pairs(wide, Count(), int{});
};

}  // namespace swiftgs
