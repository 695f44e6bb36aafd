// SPDX-License-Identifier: Apache-2.0
#include "device_state.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/error.hpp>

namespace swiftgs {

namespace vulkan {
void check(VkResult result, const char* call) {
  if (result == VK_SUCCESS) return;
  const auto text = [&]() -> std::string {
    switch (result) {
      case VK_ERROR_OUT_OF_HOST_MEMORY:
        return "out of host memory";
      case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return "out of device memory";
      case VK_ERROR_DEVICE_LOST:
        return "the device is lost";
      default:
        return "VkResult " + std::to_string(int(result));
    }
  };
  throw DeviceError(call, text());
}

namespace {
template <class Function>
void take(Function& to, PFN_vkVoidFunction found, const char* name, const char* of) {
  if (!found)
    throw Unavailable(std::string("vulkan: no function ") + name + ", expected " + of + " of Vulkan 1.3");
  to = reinterpret_cast<Function>(found);
}
}  // namespace

Functions functions_of(PFN_vkGetInstanceProcAddr get, VkInstance instance) {
  Functions vk;
#define SWIFTGS_VULKAN_GET(name) take(vk.name, get(instance, #name), #name, "an instance");
  SWIFTGS_VULKAN_OF_INSTANCE(SWIFTGS_VULKAN_GET)
#undef SWIFTGS_VULKAN_GET
  return vk;
}
}  // namespace vulkan

namespace {
void* allocate_by_hook(void* context, std::size_t bytes) {
  return static_cast<VulkanDevice::State*>(context)->allocate(bytes);
}
void release_by_hook(void* context, void* memory, std::size_t) {
  static_cast<VulkanDevice::State*>(context)->release(memory);
}
}  // namespace

VulkanDevice::State::State(const VulkanHandles& of, const vulkan::Functions& of_instance)
    : vk(of_instance), handles(of), device(of.device), hook{allocate_by_hook, release_by_hook, this} {
#define SWIFTGS_VULKAN_GET(name) \
  vulkan::take(vk.name, vk.vkGetDeviceProcAddr(device, #name), #name, "a device");
  SWIFTGS_VULKAN_OF_DEVICE(SWIFTGS_VULKAN_GET)
#undef SWIFTGS_VULKAN_GET
}

void VulkanDevice::State::create() {
  VkPhysicalDeviceVulkan11Properties of_1_1{};
  of_1_1.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, properties.pNext = &of_1_1;
  vk.vkGetPhysicalDeviceProperties2(handles.physical_device, &properties);
  name = properties.properties.deviceName, subgroup = of_1_1.subgroupSize;
  cache_header_ = {sizeof cache_header_,
                   VK_PIPELINE_CACHE_HEADER_VERSION_ONE,
                   properties.properties.vendorID,
                   properties.properties.deviceID,
                   {}};
  std::memcpy(cache_header_.pipelineCacheUUID, properties.properties.pipelineCacheUUID, VK_UUID_SIZE);
  std::uint32_t families = 0;
  vk.vkGetPhysicalDeviceQueueFamilyProperties(handles.physical_device, &families, nullptr);
  std::vector<VkQueueFamilyProperties> family(families);
  vk.vkGetPhysicalDeviceQueueFamilyProperties(handles.physical_device, &families, family.data());
  const std::uint32_t number = handles.queue_family;
  if (number >= families || !(family[number].queueFlags & VK_QUEUE_COMPUTE_BIT))
    detail::refuse("vulkan: queue_family is ", number, ", expected one of ", families, " that computes");
  if (const std::uint32_t bits = family[number].timestampValidBits; bits != 0) {
    nanoseconds = properties.properties.limits.timestampPeriod;
    tick_mask = bits >= 64 ? ~std::uint64_t(0) : (std::uint64_t(1) << bits) - 1;
  }

  vk.vkGetPhysicalDeviceMemoryProperties(handles.physical_device, &memory_);
  const VkBuffer probe = make_buffer(64);
  VkMemoryRequirements needs{};
  vk.vkGetBufferMemoryRequirements(device, probe, &needs);
  vk.vkDestroyBuffer(device, probe, nullptr);
  memory_types_ = needs.memoryTypeBits;
  most_allocations_ = properties.properties.limits.maxMemoryAllocationCount;
  most_groups = properties.properties.limits.maxComputeWorkGroupCount[0];
  device_type_ = memory_type(0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  const VkMemoryPropertyFlags of_host =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  host_types_[std::size_t(vulkan::HostMemory::cached)] =
      memory_type(of_host, VK_MEMORY_PROPERTY_HOST_CACHED_BIT);
  host_types_[std::size_t(vulkan::HostMemory::of_device)] =
      memory_type(of_host, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);

  VkSemaphoreTypeCreateInfo of_type{};
  of_type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
  of_type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
  VkSemaphoreCreateInfo semaphore{};
  semaphore.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, semaphore.pNext = &of_type;
  vulkan::check(vk.vkCreateSemaphore(device, &semaphore, nullptr, &timeline), "vkCreateSemaphore");

  stores_images = handles.enabled_features->features.shaderStorageImageWriteWithoutFormat;
  images = make_layout({vulkan::image_types.begin(), vulkan::image_types.end()});
  uniforms = make_layout({vulkan::uniform_type});
  const VkDescriptorSetLayout sets[] = {images, uniforms};
  const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, vulkan::push_bytes};
  VkPipelineLayoutCreateInfo of_layout{};
  of_layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  of_layout.setLayoutCount = 2, of_layout.pSetLayouts = sets;
  of_layout.pushConstantRangeCount = 1, of_layout.pPushConstantRanges = &push;
  vulkan::check(vk.vkCreatePipelineLayout(device, &of_layout, nullptr, &layout), "vkCreatePipelineLayout");
  VkPipelineCacheCreateInfo of_cache{};
  of_cache.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
  vulkan::check(vk.vkCreatePipelineCache(device, &of_cache, nullptr, &pipelines), "vkCreatePipelineCache");
}

VulkanDevice::State::~State() {
  for (const auto& [key, pipeline] : pipelines_) vk.vkDestroyPipeline(device, pipeline, nullptr);
  for (const Released& released : released_) free(released.allocation);
  for (const auto& [address, allocation] : memories_) free(allocation);
  vk.vkDestroyPipelineCache(device, pipelines, nullptr);
  vk.vkDestroyPipelineLayout(device, layout, nullptr);
  for (const VkDescriptorSetLayout of_set : {images, uniforms})
    vk.vkDestroyDescriptorSetLayout(device, of_set, nullptr);
  vk.vkDestroySemaphore(device, timeline, nullptr);
}

std::uint64_t VulkanDevice::State::submit(VkCommandBuffer commands) {
  const std::lock_guard lock(mutex_);
  const std::uint64_t value = submitted_ + 1;
  VkTimelineSemaphoreSubmitInfo values{};
  values.sType = VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO;
  values.signalSemaphoreValueCount = 1, values.pSignalSemaphoreValues = &value;
  VkSubmitInfo submit{};
  submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, submit.pNext = &values;
  submit.commandBufferCount = 1, submit.pCommandBuffers = &commands;
  submit.signalSemaphoreCount = 1, submit.pSignalSemaphores = &timeline;
  const auto queue = lock_queue();
  vulkan::check(vk.vkQueueSubmit(handles.queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
  return submitted_ = value;
}

bool VulkanDevice::State::is_done(std::uint64_t value) {
  std::uint64_t reached = 0;
  vulkan::check(vk.vkGetSemaphoreCounterValue(device, timeline, &reached), "vkGetSemaphoreCounterValue");
  return reached >= value;
}

void VulkanDevice::State::wait(std::uint64_t value) {
  VkSemaphoreWaitInfo wait{};
  wait.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO;
  wait.semaphoreCount = 1, wait.pSemaphores = &timeline, wait.pValues = &value;
  vulkan::check(vk.vkWaitSemaphores(device, &wait, ~std::uint64_t(0)), "vkWaitSemaphores");
}

VkDescriptorSetLayout VulkanDevice::State::make_layout(const std::vector<VkDescriptorType>& types) const {
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (const VkDescriptorType type : types)
    bindings.push_back({std::uint32_t(bindings.size()), type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
  VkDescriptorSetLayoutCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  info.bindingCount = std::uint32_t(bindings.size()), info.pBindings = bindings.data();
  VkDescriptorSetLayout made = VK_NULL_HANDLE;
  vulkan::check(vk.vkCreateDescriptorSetLayout(device, &info, nullptr, &made), "vkCreateDescriptorSetLayout");
  return made;
}

vulkan::Descriptors VulkanDevice::State::make_descriptors(VkDescriptorSetLayout of,
                                                          const std::vector<VkDescriptorType>& types) const {
  std::vector<VkDescriptorPoolSize> sizes;
  for (const VkDescriptorType type : types) sizes.push_back({type, 1});
  VkDescriptorPoolCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, info.maxSets = 1;
  info.poolSizeCount = std::uint32_t(sizes.size()), info.pPoolSizes = sizes.data();
  vulkan::Descriptors made;
  vulkan::check(vk.vkCreateDescriptorPool(device, &info, nullptr, &made.pool), "vkCreateDescriptorPool");
  VkDescriptorSetAllocateInfo of_set{};
  of_set.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
  of_set.descriptorPool = made.pool, of_set.descriptorSetCount = 1, of_set.pSetLayouts = &of;
  if (const VkResult r = vk.vkAllocateDescriptorSets(device, &of_set, &made.set); r != VK_SUCCESS) {
    vk.vkDestroyDescriptorPool(device, made.pool, nullptr);
    vulkan::check(r, "vkAllocateDescriptorSets");
  }
  return made;
}

VkQueryPool VulkanDevice::State::make_queries(std::uint32_t timestamps) const {
  VkQueryPoolCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
  info.queryType = VK_QUERY_TYPE_TIMESTAMP, info.queryCount = timestamps;
  VkQueryPool made = VK_NULL_HANDLE;
  vulkan::check(vk.vkCreateQueryPool(device, &info, nullptr, &made), "vkCreateQueryPool");
  return made;
}

std::optional<double> VulkanDevice::State::milliseconds(VkQueryPool times, std::uint32_t from,
                                                        std::uint32_t to) const {
  std::uint64_t ticks[2] = {};
  const std::uint32_t queries[] = {from, to};
  for (int k = 0; k < 2; ++k) {
    const VkResult result = vk.vkGetQueryPoolResults(device, times, queries[k], 1, sizeof ticks[k], &ticks[k],
                                                     sizeof ticks[k], VK_QUERY_RESULT_64_BIT);
    if (result == VK_NOT_READY) return {};
    vulkan::check(result, "vkGetQueryPoolResults");
  }
  return double((ticks[1] - ticks[0]) & tick_mask) * double(nanoseconds) * 1e-6;
}

}  // namespace swiftgs
