// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <swiftgs/frame/backend.hpp>
#include <swiftgs/memory/growing_buffer.hpp>
#include <swiftgs/memory/host_scene.hpp>
#include <swiftgs/tools/processor.hpp>

namespace swiftgs {

/// Backend of one thread and the standard library. Read it first; copy it to write your own. Its loops round
/// in the mode that the calling thread has set, and flush denormal numbers where that thread does.
class Serial {
 public:
  static constexpr std::string_view name = "serial";
  template <class T>
  using Buffer = GrowingBuffer<T>;
  using SceneOn = HostScene;
  using TimePoint = std::chrono::steady_clock::time_point;

  static constexpr bool reaches_host_memory = true;

  Serial() = default;
  explicit Serial(const MemoryHook& memory) : memory_(memory) { validate(memory); }
  const MemoryHook& memory_hook() const { return memory_; }

  static bool usable() { return true; }
  std::string device_name() const { return processor_name(); }

  SceneOn upload(Scene scene, HarmonicsKept kept = HarmonicsKept::smallest) const {
    return SceneOn(*this, std::move(scene), kept);
  }
  SceneOn upload(std::shared_ptr<const Scene> scene, HarmonicsKept kept = HarmonicsKept::smallest) const {
    return SceneOn(*this, std::move(scene), kept);
  }
  SceneOn upload(const SceneArrays& arrays, std::optional<SceneOn>& reuse) const {
    return SceneOn::copy(*this, arrays, reuse);
  }
  void update(SceneOn& scene, std::size_t first, const SceneArrays& arrays) const {
    scene.update(*this, first, arrays);
  }

  template <class T>
  void download(Span<const T> from, T* to) const {
    std::copy(from.begin(), from.end(), to);
  }

  void wait() const {}  // loops are complete when they return

  template <class F>
  void for_each(Count n, const F& f) const {
    for (std::size_t i = 0; i < n.get(); ++i) f(i);
  }

  std::uint64_t exclusive_scan(Span<std::uint32_t> counts) const {
    std::uint64_t sum = 0;
    for (std::uint32_t& count : counts) sum += std::exchange(count, std::uint32_t(sum));
    return sum;
  }

  /// Least-significant-digit radix sort, a byte a pass.
  template <class Key>
  void sort_pairs(Pairs<Serial, Key>& pairs, Count count, int bits) const {
    const std::size_t n = count.get();
    for (int shift = 0; shift < bits; shift += 8) {
      // Count the digits, turn counts into first positions, and move every pair to its own.
      const Key mask = Key((1u << (bits - shift < 8 ? bits - shift : 8)) - 1);
      std::array<std::size_t, 256> position{};
      const Key* keys = pairs.keys.data();
      const std::uint32_t* values = pairs.values.data();
      for (std::size_t i = 0; i < n; ++i) ++position[std::size_t(keys[i] >> shift & mask)];
      std::size_t sum = 0;
      for (std::size_t& p : position) sum += std::exchange(p, sum);
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t to = position[std::size_t(keys[i] >> shift & mask)]++;
        pairs.spare_keys.data()[to] = keys[i];
        pairs.spare_values.data()[to] = values[i];
      }
      std::swap(pairs.keys, pairs.spare_keys);
      std::swap(pairs.values, pairs.spare_values);
    }
  }

  TimePoint now() const { return std::chrono::steady_clock::now(); }
  std::optional<double> milliseconds(TimePoint from, TimePoint to) const {
    return std::chrono::duration<double, std::milli>(to - from).count();
  }

 private:
  MemoryHook memory_ = hook_of<CacheLineMemory>();
};

inline Serial make_backend(std::type_identity<Serial>, const BackendOptions& options) {
  return options.memory ? Serial(*options.memory) : Serial();
}

static_assert(FunctorBackend<Serial>);

}  // namespace swiftgs
