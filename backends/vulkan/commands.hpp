// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <type_traits>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/vulkan/backend.hpp>

#include "device_state.hpp"
#include "hazards.hpp"

namespace swiftgs {

namespace vulkan {

/// Push constants as shaders lay them out: addresses first, then counts, then words.
class Push {
 public:
  template <class... Values>
  explicit Push(const Values&... values) {
    (append(values), ...);
  }
  const std::byte* data() const { return data_; }
  std::uint32_t size() const { return std::uint32_t(size_); }

 private:
  template <class T>
  void append(T* const& address) {
    append_bytes(&address, sizeof address);
  }
  void append(const Count& count) {
    append(count.exact);
    append(std::uint32_t(count.most));
  }
  void append(const std::uint32_t& word) { append_bytes(&word, sizeof word); }
  void append_bytes(const void* from, std::size_t bytes) {
    static_assert(sizeof(void*) == 8);
    std::memcpy(data_ + size_, from, bytes);
    size_ += bytes;
  }

  std::byte data_[128];
  std::size_t size_ = 0;
};

/// Threads of a workgroup of most kernels.
inline constexpr std::uint32_t usual_threads = 128;

/// A command buffer, and what its commands read beside memory of the device.
struct CommandSlot {
  VkCommandBuffer commands = VK_NULL_HANDLE;
  std::vector<HostBlock> blocks;
  std::size_t block = 0, used = 0;  ///< where the next copy goes
  std::uint64_t done_at = 0;        ///< value of the timeline
};

/// Points of `Vulkan::now` that can be read.
inline constexpr std::uint32_t time_points = 256;

}  // namespace vulkan

struct Vulkan::State {
  State(const VulkanDevice& device, const std::optional<MemoryHook>& memory);
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State();

  VulkanDevice device;
  MemoryHook hook;
  VkCommandPool pool = VK_NULL_HANDLE;
  VkQueryPool times = VK_NULL_HANDLE;
  std::array<vulkan::CommandSlot, 16> slots{};
  std::size_t next_slot = 0;
  vulkan::CommandSlot* recording = nullptr;  ///< of the program: takes all commands
  std::uint64_t last = 0;                    ///< value of the timeline when all is done
  std::uint64_t serial = 0;
  std::array<std::uint64_t, vulkan::time_points> reached_at{};  ///< values of the timeline of time points
  vulkan::HostBlock report;                                     ///< a `FrameReport`
  std::uint64_t reported_at = 0;                                ///< value of the timeline
  vulkan::HostBlock staging;
  VulkanBuffer<std::uint32_t> sums;    ///< of scans
  VulkanBuffer<std::uint32_t> places;  ///< of sorts
};

namespace vulkan {

/// Throws `OrderError` where `call` would have to wait for commands that the program has not submitted.
void refuse_while_recording(const Vulkan::State& b, const char* call);

/// Records commands behind all submitted ones, or into those of the program that `Vulkan::record` was given.
/// Barriers follow from what each dispatch reads and writes.
class Commands {
 public:
  explicit Commands(const Vulkan& b);
  /// Drops the commands unless `submit` was called.
  ~Commands();
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  std::uint32_t subgroup() const { return device_.subgroup; }
  /// Threads of a workgroup that sorts.
  std::uint32_t sort_threads() const { return subgroup() < 32 ? 8 * subgroup() : 256; }

  /// Copies `values` to where kernels of these commands read them.
  template <class T>
  const T* constants(Span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    return static_cast<const T*>(copy(values.data, values.size * sizeof(T)));
  }

  struct Shape {
    std::uint32_t columns, rows = 1;
    std::uint32_t threads = usual_threads;

    /// Workgroups of `each` elements.
    static Shape of(std::size_t elements, std::size_t each = usual_threads,
                    std::uint32_t threads = usual_threads);
  };
  void run(Kernel kernel, const std::vector<std::uint32_t>& constants, const Push& push, const Shape& shape,
           std::initializer_list<Access> accesses);
  void fill(void* to, std::size_t words, std::uint32_t value);

  /// Replaces each of `count` values by the sum of those before it.
  void scan(std::uint32_t* values, Count count);
  /// Takes the memory of scans of so many values. Call it before the first command of a recording.
  void reserve_scan(std::size_t values);

  /// Orders these commands behind all earlier ones of the program.
  void follow_program();
  /// Orders all later commands of the program behind these.
  void precede_program();

  void timestamp(std::uint32_t query);
  /// Lets the host read what the commands wrote.
  void release_to_host();

  std::uint64_t submit();

 private:
  const void* copy(const void* from, std::size_t bytes);

  Vulkan::State& b_;
  VulkanDevice::State& device_;
  CommandSlot& slot_;
  Hazards hazards_;
  bool open_ = false;  ///< begun and not ended, of the library's own
};

}  // namespace vulkan

}  // namespace swiftgs
