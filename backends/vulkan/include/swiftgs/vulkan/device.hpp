// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/span.hpp>

// As <vulkan/vulkan_core.h> declares them: this header needs nothing of Vulkan.
struct VkInstance_T;
struct VkPhysicalDevice_T;
struct VkDevice_T;
struct VkQueue_T;
struct VkCommandBuffer_T;
struct VkImageView_T;
struct VkSemaphore_T;
struct VkPhysicalDeviceFeatures2;

namespace swiftgs {

/// Handles of a program's Vulkan 1.3 or newer. The objects outlive the `VulkanDevice`.
struct VulkanHandles {
  VkInstance_T* instance = nullptr;
  VkPhysicalDevice_T* physical_device = nullptr;
  VkDevice_T* device = nullptr;
  /// Runs compute. Backends submit to it from the threads that call them: make one `VulkanDevice` of a queue,
  /// and submit to it under `VulkanDevice::lock_queue`.
  VkQueue_T* queue = nullptr;
  std::uint32_t queue_family = 0;
  /// As `device` was made with: the chain has bufferDeviceAddress, timelineSemaphore, scalarBlockLayout,
  /// subgroupSizeControl and computeFullSubgroups. Images are drawn to with
  /// shaderStorageImageWriteWithoutFormat alone.
  const VkPhysicalDeviceFeatures2* enabled_features = nullptr;
  /// `vkGetInstanceProcAddr`: the library links nothing of Vulkan.
  void (*(*get_instance_proc_addr)(VkInstance_T*, const char*))() = nullptr;
};

/// A device of Vulkan on which any number of backends work, also from several threads. Copies are one
/// device, which backends and the scenes that they uploaded keep.
class SWIFTGS_API VulkanDevice {
 public:
  struct State;

  /// Throws `InvalidArgument` for handles that are missing, and `Unavailable` by name for what the device
  /// lacks or the program did not enable.
  explicit VulkanDevice(const VulkanHandles& handles);

  /// The library's own: the first GPU that has all, else a device without a GPU such as lavapipe. Loads
  /// libvulkan.so.1 when it is first asked for. Throws `Unavailable` where there is none.
  static const VulkanDevice& own();
  /// Whether `own` finds a device, without making it: threads of a device without a GPU delay the end of a
  /// program.
  static bool has_own();

  /// What it was made of.
  const VulkanHandles& handles() const;
  /// Keeps backends from submitting to the queue meanwhile. Call none of them before it is unlocked.
  std::unique_lock<std::mutex> lock_queue() const;

  /// The kernels that were compiled so far, for `add_pipelines` of a later run on this device and driver.
  std::vector<std::byte> pipelines() const;
  /// Spares the compilation of kernels that `kept` has. Ignores bytes that are damaged, or of another
  /// device or driver.
  void add_pipelines(Span<const std::byte> kept) const;

  /// Memory of this device.
  const MemoryHook& memory_hook() const;

  State& state() const { return *state_; }

 private:
  std::shared_ptr<State> state_;
};

/// Memory of `VulkanDevice::own()`. `allocate` throws `CapacityError` where there is not enough of it.
struct SWIFTGS_API VulkanMemory {
  static void* allocate(std::size_t bytes);
  static void release(void* memory);
};

}  // namespace swiftgs
