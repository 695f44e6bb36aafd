// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <functional>
#include <optional>
#include <type_traits>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/vulkan/backend.hpp>

#include "device_state.hpp"
#include "hazards.hpp"

namespace swiftgs {

namespace vulkan {

/// Where a kernel finds its uniform: a descriptor set, and an offset into its buffer. @units{bytes}
struct Uniform {
  static constexpr std::uint32_t most = 1024;  ///< bytes
  VkDescriptorSet set = VK_NULL_HANDLE;
  std::uint32_t offset = 0;
};

/// Push constants as shaders lay them out: addresses first, then counts, then words. Each
/// address comes with how the kernel uses its memory; barriers follow from that.
class Push {
 public:
  template <class... Values>
  explicit Push(const Values&... values) {
    static_assert((bytes_of<Values> + ... + 0) <= push_bytes, "expected fewer push constants");
    (append(values), ...);
  }
  const std::byte* data() const { return data_; }
  std::uint32_t size() const { return std::uint32_t(size_); }
  /// Adds memory that the kernel reaches by addresses outside of the constants.
  void touch(const Access& at) { accesses_.push_back(at); }
  Span<const Access> accesses() const { return {accesses_.data(), accesses_.size()}; }
  const Uniform& uniform() const { return uniform_; }

 private:
  template <class Value>
  static constexpr std::size_t bytes_of = std::is_same_v<Value, Uniform>  ? 0
                                          : std::is_same_v<Value, Access> ? sizeof(std::uintptr_t)
                                          : std::is_same_v<Value, Count>
                                              ? sizeof(std::uintptr_t) + sizeof(std::uint32_t)
                                              : sizeof(std::uint32_t);

  void append(const Uniform& uniform) { uniform_ = uniform; }
  void append(const Access& at) {
    accesses_.push_back(at);
    append_bytes(&at.begin, sizeof at.begin);
  }
  void append(const Count& count) {
    append(reads(count.exact, 1));
    append(std::uint32_t(count.most));
  }
  void append(const std::uint32_t& word) { append_bytes(&word, sizeof word); }
  void append_bytes(const void* from, std::size_t bytes) {
    static_assert(sizeof(std::uintptr_t) == 8);
    std::memcpy(data_ + size_, from, bytes);
    size_ += bytes;
  }

  std::byte data_[push_bytes];
  std::size_t size_ = 0;
  std::vector<Access> accesses_;
  Uniform uniform_;
};

/// Threads of a workgroup of most kernels.
inline constexpr std::uint32_t usual_threads = 128;

/// Workgroups whose numbers are added up in places.glsl.
inline constexpr std::uint32_t run_size = 4 * usual_threads;

/// Threads of a workgroup that sorts, by the lanes of a subgroup.
constexpr std::uint32_t sort_threads(std::uint32_t lanes) { return lanes < 32 ? 8 * lanes : 256; }

/// Digits of a pass of a sort.
inline constexpr std::uint32_t sort_digits = 256;

/// Workgroups of kernels that run over a number which the device counts, as settle.comp writes them.
struct Groups {
  enum Of : std::uint32_t { usual, fours, sort, kinds };  ///< `fours` has four elements a thread
  VkDispatchIndirectCommand each[kinds];
};

/// Side of the blocks that subgroups rasterize. @units{pixels}
inline constexpr std::uint32_t raster_side = 8;

/// Least intersections of a list that is long, and their least part of all: its blocks are rasterized beside
/// others, by workgroups, which take more work and less time for a block. On an H200 frames of
/// `builtin:1000000` are quickest from 3,072 on, of four million from 6,144 on, of twelve from 12,288 on:
/// with 4,096 these take 6 and 30 % longer.
inline constexpr std::uint32_t long_list = 3072;
inline constexpr std::uint32_t long_part = 1000;

/// Memory of commands for what kernels read, at addresses and as uniforms.
struct Constants {
  Block block;
  Descriptors uniforms;
};

/// A command buffer, and what its commands read beside memory of the device.
struct CommandSlot {
  VkCommandBuffer commands = VK_NULL_HANDLE;
  std::vector<Constants> blocks;
  std::vector<Descriptors> images;
  std::size_t block = 0, used = 0;  ///< where the next copy goes
  std::uint64_t number = 0;         ///< of `VulkanDevice::State::open`
  std::uint64_t done_at = 0;        ///< value of the timeline
};

class Commands;

/// Frees descriptor pools of commands that are done.
void clear_images(const VulkanDevice::State& device, CommandSlot& slot);

/// Points of `Vulkan::now` that can be read.
inline constexpr std::uint32_t time_points = 256;

/// Kernels of `Vulkan::profile`, with a timestamp before each and one behind it.
struct Profile {
  static constexpr std::uint32_t most = 1000;
  bool on = false;
  VkQueryPool times = VK_NULL_HANDLE;
  std::vector<Kernel> kernels;
};

}  // namespace vulkan

struct Vulkan::State {
  State(const VulkanDevice& device, const std::optional<MemoryHook>& memory);
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State();

  /// Makes what may fail: the destructor takes back what there is by then.
  void create();
  /// Forgets what commands write for launches, if they may never run.
  void forget_launches() { launches_written = true, counted = {}, long_of = nullptr; }

  VulkanDevice device;
  MemoryHook hook;
  bool hooked;  ///< `hook` is the program's
  VkCommandPool pool = VK_NULL_HANDLE;
  VkQueryPool times = VK_NULL_HANDLE;
  std::array<vulkan::CommandSlot, 16> slots{};
  std::size_t next_slot = 0;
  vulkan::CommandSlot* open = nullptr;  ///< begun and not submitted, or of the program
  bool recording = false;               ///< `open` is the program's
  vulkan::Hazards hazards;              ///< of `open`
  bool launches_written = true;         ///< whether `groups` may be written since the last barrier for them
  std::uint64_t last = 0;               ///< value of the timeline when all is done
  std::uint64_t serial = 0;
  std::array<std::uint64_t, vulkan::time_points> reached_at{};  ///< values of the timeline of time points
  std::vector<std::uint32_t> open_points;                       ///< those within `open`
  vulkan::Profile profile;
  std::deque<std::function<void(vulkan::Commands&)>> beside;  ///< kernels that wait for others to run beside
  vulkan::Block report;                                       ///< a `FrameReport`
  std::uint64_t reported_at = 0;                              ///< value of the timeline
  bool awaited = false;  ///< whether the frame ends by `await_report`, which submits what is open
  vulkan::Block staging;
  VulkanBuffer<std::uint32_t> numbers;     ///< of digits, of sorts
  vulkan::Block groups;                    ///< two `Groups`, by the last `bin`, and a launch
  std::array<Count, 2> counted{};          ///< its numbers of splats and intersections
  VulkanBuffer<std::uint32_t> long_tiles;  ///< length from which lists are long, tiles of these
  const TileRange* long_of = nullptr;      ///< ranges that `long_tiles` belongs to

  /// Bytes into `groups` of the launch over blocks of long lists.
  static constexpr std::size_t long_launch = 2 * sizeof(vulkan::Groups);
  static constexpr std::size_t groups_bytes = long_launch + sizeof(VkDispatchIndirectCommand);
};

namespace vulkan {

/// Throws `OrderError` where `call` would have to wait for commands that the program has not submitted.
void refuse_while_recording(const Vulkan::State& b, const char* call);

/// Appends commands to those that are not submitted yet, or to those of the program that `Vulkan::record` was
/// given. Barriers follow from what each dispatch reads and writes.
class Commands {
 public:
  explicit Commands(const Vulkan& b);
  /// Drops all that is not submitted if an exception passes.
  ~Commands();
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  std::uint32_t subgroup() const { return device_.subgroup; }
  std::uint32_t sort_threads() const { return vulkan::sort_threads(subgroup()); }
  /// Pairs of a thread in sorts of `most` pairs at most: few fill a GPU by smaller workgroups. The sort of
  /// `builtin:4000000` takes 665 us on an H200, with 8 in place of 12 it takes 718 and with 16 736.
  std::uint32_t sort_each(std::size_t most) const {
    if (subgroup() < 32) return 16;
    return most < (std::size_t(1) << 20) ? 4 : 12;
  }
  std::uint32_t sort_part(std::size_t most) const { return sort_each(most) * sort_threads(); }

  /// Copies `values` to where kernels of these commands read them.
  template <class T>
  const T* constants(Span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    return static_cast<const T*>(copy(values.data, values.size * sizeof(T)));
  }
  /// Copies `value` to where a kernel of these commands has it as its uniform.
  template <class T>
  Uniform uniform(const T& value) {
    static_assert(std::is_trivially_copyable_v<T> && sizeof value <= Uniform::most);
    return uniform_at(copy(&value, sizeof value, Uniform::most));
  }

  struct Shape {
    std::uint32_t columns = 0, rows = 1;
    std::uint32_t threads = usual_threads, layers = 1;
    std::optional<std::size_t> at{};  ///< bytes into `State::groups`, where the device has columns and rows

    /// Workgroups of `each` elements.
    static Shape of(std::size_t elements, std::size_t each = usual_threads,
                    std::uint32_t threads = usual_threads);
  };
  /// Workgroups that run over `count` elements: as many as there are, if the last `bin` counted them, else as
  /// there may be.
  Shape over(Count count, Groups::Of of = Groups::usual) const;

  void run(const Shader& shader, const std::vector<std::uint32_t>& constants, Push push, const Shape& shape);
  /// Lets the next kernels see `image`, at one of `image_types`.
  void bind_image(VkImageView image, std::uint32_t binding);
  void fill(std::uint32_t* to, std::size_t words, std::uint32_t value);
  /// Runs what comes next of `State::beside`. Returns whether there was something.
  bool run_beside();

  /// Orders the next kernel behind all before: frames find scenes by addresses that their kernels do not
  /// note.
  void forget() { b_.hazards.forget(); }

  /// Orders these commands behind all earlier ones of the program.
  void follow_program();
  /// Orders all later commands of the program behind these.
  void precede_program();

  void timestamp(VkQueryPool times, std::uint32_t query);

  /// Ends a stage, which `submit` of a later one submits: memory of a hook alone has to be done with at once.
  void finish();
  /// Drops all that is not submitted.
  void drop();
  /// Submits all, and returns the timeline's value when they are done. From then on the host sees their
  /// writes.
  std::uint64_t submit();

 private:
  /// Copies to the constants, where at least `room` bytes follow.
  const void* copy(const void* from, std::size_t bytes, std::size_t room = 0);
  Uniform uniform_at(const void* copied) const;
  void dispatch(const Shape& shape);

  Vulkan::State& b_;
  VulkanDevice::State& device_;
  int exceptions_;
};

}  // namespace vulkan

}  // namespace swiftgs
