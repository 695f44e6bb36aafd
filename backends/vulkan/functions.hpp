// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The functions of Vulkan that the backend calls, found by `vkGetInstanceProcAddr`.

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

namespace swiftgs::vulkan {

// clang-format off
#define SWIFTGS_VULKAN_OF_INSTANCE(f) \
  f(vkDestroyInstance) f(vkEnumeratePhysicalDevices) f(vkGetPhysicalDeviceProperties2) \
  f(vkGetPhysicalDeviceFeatures2) f(vkGetPhysicalDeviceMemoryProperties) \
  f(vkGetPhysicalDeviceQueueFamilyProperties) f(vkCreateDevice) f(vkGetDeviceProcAddr)

#define SWIFTGS_VULKAN_OF_DEVICE(f) \
  f(vkCreateBuffer) f(vkDestroyBuffer) f(vkGetBufferMemoryRequirements) \
  f(vkAllocateMemory) f(vkFreeMemory) f(vkBindBufferMemory) f(vkGetBufferDeviceAddress) f(vkMapMemory) \
  f(vkCreateShaderModule) f(vkDestroyShaderModule) f(vkCreatePipelineLayout) f(vkDestroyPipelineLayout) \
  f(vkCreateComputePipelines) f(vkDestroyPipeline) f(vkCreateCommandPool) f(vkDestroyCommandPool) \
  f(vkAllocateCommandBuffers) f(vkBeginCommandBuffer) f(vkEndCommandBuffer) f(vkCmdBindPipeline) \
  f(vkCmdPushConstants) f(vkCmdDispatch) f(vkCmdDispatchIndirect) f(vkCmdPipelineBarrier) \
  f(vkCreateQueryPool) f(vkDestroyQueryPool) f(vkCmdResetQueryPool) f(vkCmdWriteTimestamp) \
  f(vkGetQueryPoolResults) f(vkCreateSemaphore) f(vkDestroySemaphore) f(vkGetSemaphoreCounterValue) \
  f(vkWaitSemaphores) f(vkQueueSubmit) f(vkCreateDescriptorSetLayout) f(vkDestroyDescriptorSetLayout) \
  f(vkCreateDescriptorPool) f(vkDestroyDescriptorPool) f(vkAllocateDescriptorSets) \
  f(vkUpdateDescriptorSets) f(vkCmdBindDescriptorSets) f(vkCreatePipelineCache) \
  f(vkDestroyPipelineCache) f(vkGetPipelineCacheData) f(vkMergePipelineCaches)
// clang-format on

struct Functions {
#define SWIFTGS_VULKAN_DECLARE(name) PFN_##name name = nullptr;
  SWIFTGS_VULKAN_OF_INSTANCE(SWIFTGS_VULKAN_DECLARE)
  SWIFTGS_VULKAN_OF_DEVICE(SWIFTGS_VULKAN_DECLARE)
#undef SWIFTGS_VULKAN_DECLARE
};

}  // namespace swiftgs::vulkan
