// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <shared_mutex>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <swiftgs/vulkan/device.hpp>

#include "functions.hpp"
#include "kernels.hpp"

namespace swiftgs {

namespace vulkan {
/// Throws `DeviceError` unless `result` is VK_SUCCESS.
void check(VkResult result, const char* call);

/// Memory that the host reaches: cached there, or where the device reads it as fast as its own.
enum class HostMemory { cached, of_device };

/// The functions of an instance. Throws `Unavailable` by name for one that is missing.
Functions functions_of(PFN_vkGetInstanceProcAddr get, VkInstance instance);

/// Descriptors of an image to store to, and of one to load from, by their bindings.
inline constexpr std::array image_types{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE};
/// The descriptor of a kernel's uniform.
inline constexpr VkDescriptorType uniform_type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC;

/// Push constants of a kernel at most: every device has so many. @units{bytes}
inline constexpr std::uint32_t push_bytes = 128;

/// A descriptor set in a pool of its own.
struct Descriptors {
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VkDescriptorSet set = VK_NULL_HANDLE;
};

/// A buffer with memory of its own.
struct Allocation {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
};

/// Memory of the library's own.
struct Block {
  Allocation allocation;
  std::byte* host = nullptr;    ///< null where the host does not reach it
  std::byte* device = nullptr;  ///< its address there
  std::size_t bytes = 0;
};
}  // namespace vulkan

/// All members but the constants may be used by several threads: `mutex` guards them.
struct VulkanDevice::State {
  /// Throws `Unavailable` by name for a function that is missing.
  State(const VulkanHandles& handles, const vulkan::Functions& of_instance);
  /// Makes what may fail, on a device that has all that is needed.
  void create();
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State();

  /// Memory of the device by its address.
  void* allocate(std::size_t bytes);
  /// Frees the memory once the queue has finished all work begun so far.
  void release(void* memory);
  vulkan::Block allocate_block(std::size_t bytes);
  /// A block that the host can map. Where there is no more memory `of_device` it is `cached`.
  vulkan::Block allocate_host_block(std::size_t bytes, vulkan::HostMemory kind);
  void release(vulkan::Block& block);

  /// Notes that commands are begun, and returns their number. Memory that is released before `close` of it is
  /// freed behind them.
  std::uint64_t open();
  /// Notes that these commands are submitted or dropped.
  void close(std::uint64_t number);

  /// Submits commands, and returns the value that the timeline reaches when they are done.
  std::uint64_t submit(VkCommandBuffer commands);
  std::unique_lock<std::mutex> lock_queue() { return std::unique_lock(queue_mutex_); }
  bool is_done(std::uint64_t value);
  void wait(std::uint64_t value);

  /// A set of the layout `of`, which has a descriptor of each of `types`.
  vulkan::Descriptors make_descriptors(VkDescriptorSetLayout of,
                                       const std::vector<VkDescriptorType>& types) const;
  VkQueryPool make_queries(std::uint32_t timestamps) const;
  /// Between two timestamps that were submitted; nothing while they are not reached.
  std::optional<double> milliseconds(VkQueryPool times, std::uint32_t from, std::uint32_t to) const;

  /// Made when it is first used. `threads` a workgroup.
  VkPipeline pipeline(const vulkan::Shader& shader, std::uint32_t threads,
                      const std::vector<std::uint32_t>& constants);

  /// The bytes of compiled pipelines behind a header of their length and hash.
  std::vector<std::byte> kept_pipelines();
  /// Ignores bytes that `kept_pipelines` of this device and driver did not give: drivers may trust them.
  void add_pipelines(Span<const std::byte> kept);

  // Constants.
  vulkan::Functions vk;
  VulkanHandles handles;
  VkDevice device;
  std::string name;
  std::uint32_t subgroup = 0;
  std::uint32_t arithmetic = 0;   ///< bits: `fma` rounds once; `exp2` is exact enough for pixels
  std::uint32_t most_groups = 0;  ///< workgroups of a launch in its first direction
  float nanoseconds = 0;          ///< of a tick of timestamps; 0: there are none
  std::uint64_t tick_mask = 0;
  bool stores_images = false;
  VkDescriptorSetLayout images = VK_NULL_HANDLE;    ///< set 0: an image to store to, and one to load from
  VkDescriptorSetLayout uniforms = VK_NULL_HANDLE;  ///< set 1: a uniform
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipelineCache pipelines = VK_NULL_HANDLE;
  VkSemaphore timeline = VK_NULL_HANDLE;
  MemoryHook hook;

 private:
  /// Memory to be freed when the timeline reaches `done_at`, which is known once no commands up to number
  /// `opened` are open.
  struct Released {
    vulkan::Allocation allocation;
    std::uint64_t opened;
    std::optional<std::uint64_t> done_at;
  };

  VkPipeline compile(const vulkan::Shader& shader, const std::vector<std::uint32_t>& constants) const;
  /// Waits for released memory where there is not enough, and tries again once.
  std::pair<vulkan::Allocation, void*> allocate_buffer(std::size_t bytes, std::uint32_t type);
  std::pair<vulkan::Allocation, void*> allocate_host_buffer(std::size_t bytes, vulkan::HostMemory kind);
  std::pair<vulkan::Allocation, void*> try_allocate_buffer(std::size_t bytes, std::uint32_t type);
  VkDescriptorSetLayout make_layout(const std::vector<VkDescriptorType>& types) const;
  VkBuffer make_buffer(std::size_t bytes) const;
  void free(const vulkan::Allocation& allocation);
  void put_off(const vulkan::Allocation& allocation);
  void find_ends();
  void collect();
  std::uint32_t memory_type(VkMemoryPropertyFlags required, VkMemoryPropertyFlags preferred) const;

  std::mutex mutex_;
  std::shared_mutex cache_mutex_;  ///< of the pipeline cache; threads that compile share it
  std::mutex queue_mutex_;         ///< locked within `mutex_`
  std::uint64_t submitted_ = 0, done_ = 0;
  std::uint64_t opened_ = 0;      ///< number of the last commands that were begun
  std::set<std::uint64_t> open_;  ///< those not submitted or dropped yet
  std::map<void*, vulkan::Allocation> memories_;
  std::vector<Released> released_;
  /// A pipeline by its kernel, its own code and its constants.
  std::map<std::tuple<vulkan::Kernel, const void*, std::vector<std::uint32_t>>, VkPipeline> pipelines_;
  VkPipelineCacheHeaderVersionOne cache_header_{};  ///< what its bytes begin with
  VkPhysicalDeviceMemoryProperties memory_{};
  std::uint32_t memory_types_ = 0;  ///< bits of those that buffers may have
  std::uint32_t device_type_ = 0, most_allocations_ = 0;
  std::uint32_t host_types_[2] = {};  ///< by `HostMemory`
};

}  // namespace swiftgs
