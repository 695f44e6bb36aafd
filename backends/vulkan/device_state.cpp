// SPDX-License-Identifier: Apache-2.0
#include "device_state.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
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
  host_type_ = memory_type(VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                           VK_MEMORY_PROPERTY_HOST_CACHED_BIT);

  VkSemaphoreTypeCreateInfo of_type{};
  of_type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
  of_type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
  VkSemaphoreCreateInfo semaphore{};
  semaphore.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, semaphore.pNext = &of_type;
  vulkan::check(vk.vkCreateSemaphore(device, &semaphore, nullptr, &timeline), "vkCreateSemaphore");

  stores_images = handles.enabled_features->features.shaderStorageImageWriteWithoutFormat;
  VkDescriptorSetLayoutBinding of_images[2]{};
  for (std::uint32_t k = 0; k < 2; ++k) {
    of_images[k].binding = k, of_images[k].descriptorCount = 1;
    of_images[k].descriptorType = vulkan::image_types[k];
    of_images[k].stageFlags = VK_SHADER_STAGE_COMPUTE_BIT;
  }
  VkDescriptorSetLayoutCreateInfo of_set{};
  of_set.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  of_set.bindingCount = 2, of_set.pBindings = of_images;
  vulkan::check(vk.vkCreateDescriptorSetLayout(device, &of_set, nullptr, &images),
                "vkCreateDescriptorSetLayout");
  const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, 128};
  VkPipelineLayoutCreateInfo of_layout{};
  of_layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  of_layout.setLayoutCount = 1, of_layout.pSetLayouts = &images;
  of_layout.pushConstantRangeCount = 1, of_layout.pPushConstantRanges = &push;
  vulkan::check(vk.vkCreatePipelineLayout(device, &of_layout, nullptr, &layout), "vkCreatePipelineLayout");
  VkPipelineCacheCreateInfo of_cache{};
  of_cache.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
  vulkan::check(vk.vkCreatePipelineCache(device, &of_cache, nullptr, &pipelines), "vkCreatePipelineCache");
}

VulkanDevice::State::~State() {
  for (const auto& [key, pipeline] : pipelines_) vk.vkDestroyPipeline(device, pipeline, nullptr);
  for (const auto& [value, allocation] : released_) free(allocation);
  for (const auto& [address, allocation] : memories_) free(allocation);
  vk.vkDestroyPipelineCache(device, pipelines, nullptr);
  vk.vkDestroyPipelineLayout(device, layout, nullptr);
  vk.vkDestroyDescriptorSetLayout(device, images, nullptr);
  vk.vkDestroySemaphore(device, timeline, nullptr);
}

std::uint32_t VulkanDevice::State::memory_type(VkMemoryPropertyFlags required,
                                               VkMemoryPropertyFlags preferred) const {
  for (const VkMemoryPropertyFlags wanted : {required | preferred, required})
    for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
      if ((memory_types_ >> i & 1) != 0 && (memory_.memoryTypes[i].propertyFlags & wanted) == wanted)
        return i;
  throw Unavailable("vulkan device '" + name + "': expected memory that the host reaches");
}

VkBuffer VulkanDevice::State::make_buffer(std::size_t bytes) const {
  VkBufferCreateInfo buffer{};
  buffer.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, buffer.size = bytes;
  buffer.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                 VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  VkBuffer made = VK_NULL_HANDLE;
  vulkan::check(vk.vkCreateBuffer(device, &buffer, nullptr, &made), "vkCreateBuffer");
  return made;
}

/// The caller holds `mutex_`.
std::pair<vulkan::Allocation, void*> VulkanDevice::State::allocate_buffer(std::size_t bytes,
                                                                          std::uint32_t type) {
  try {
    return try_allocate_buffer(bytes, type);
  } catch (const CapacityError&) {
    wait(submitted_);
    collect();
    return try_allocate_buffer(bytes, type);
  }
}

std::pair<vulkan::Allocation, void*> VulkanDevice::State::try_allocate_buffer(std::size_t bytes,
                                                                              std::uint32_t type) {
  vulkan::Allocation made{make_buffer(bytes)};
  const auto refuse = [&](VkResult result, const char* call) {
    free(made);
    if (result == VK_ERROR_TOO_MANY_OBJECTS)
      throw CapacityError("allocations of device memory (maxMemoryAllocationCount)",
                          std::uint64_t(most_allocations_) + 1, most_allocations_);
    if (result != VK_ERROR_OUT_OF_DEVICE_MEMORY && result != VK_ERROR_OUT_OF_HOST_MEMORY)
      vulkan::check(result, call);
    throw CapacityError("bytes of device memory", bytes,
                        memory_.memoryHeaps[memory_.memoryTypes[type].heapIndex].size);
  };
  VkMemoryRequirements needs{};
  vk.vkGetBufferMemoryRequirements(device, made.buffer, &needs);
  VkMemoryAllocateFlagsInfo flags{};
  flags.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO;
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo memory{};
  memory.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, memory.pNext = &flags;
  memory.allocationSize = needs.size, memory.memoryTypeIndex = type;
  if (const VkResult r = vk.vkAllocateMemory(device, &memory, nullptr, &made.memory); r != VK_SUCCESS)
    refuse(r, "vkAllocateMemory");
  if (const VkResult r = vk.vkBindBufferMemory(device, made.buffer, made.memory, 0); r != VK_SUCCESS)
    refuse(r, "vkBindBufferMemory");
  VkBufferDeviceAddressInfo address{};
  address.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, address.buffer = made.buffer;
  return {made, reinterpret_cast<void*>(vk.vkGetBufferDeviceAddress(device, &address))};
}

void VulkanDevice::State::free(const vulkan::Allocation& allocation) {
  vk.vkDestroyBuffer(device, allocation.buffer, nullptr);
  vk.vkFreeMemory(device, allocation.memory, nullptr);
}

void* VulkanDevice::State::allocate(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  collect();
  const auto [allocation, address] = allocate_buffer(bytes, device_type_);
  memories_.emplace(address, allocation);
  return address;
}

void VulkanDevice::State::release(void* memory) {
  const std::lock_guard lock(mutex_);
  const auto found = memories_.find(memory);
  put_off(found->second);
  memories_.erase(found);
}

vulkan::Block VulkanDevice::State::allocate_block(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  const auto [allocation, address] = allocate_buffer(bytes, device_type_);
  return {allocation, nullptr, static_cast<std::byte*>(address), bytes};
}

vulkan::Block VulkanDevice::State::allocate_host_block(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  const auto [allocation, address] = allocate_buffer(bytes, host_type_);
  void* host = nullptr;
  if (const VkResult r = vk.vkMapMemory(device, allocation.memory, 0, VK_WHOLE_SIZE, 0, &host);
      r != VK_SUCCESS) {
    free(allocation);
    vulkan::check(r, "vkMapMemory");
  }
  return {allocation, static_cast<std::byte*>(host), static_cast<std::byte*>(address), bytes};
}

void VulkanDevice::State::release(vulkan::Block& block) {
  if (!block.device) return;
  const std::lock_guard lock(mutex_);
  put_off(std::exchange(block, {}).allocation);
}

namespace {
/// In place of the value of the timeline where open commands may still use the memory.
constexpr std::uint64_t behind_open = ~std::uint64_t(0);
}  // namespace

/// Frees memory once the queue has finished with it. The caller holds `mutex_`.
void VulkanDevice::State::put_off(const vulkan::Allocation& allocation) {
  released_.emplace_back(open_ != 0 ? behind_open : submitted_, allocation);
  collect();
}

void VulkanDevice::State::count_open(int more) {
  const std::lock_guard lock(mutex_);
  if ((open_ += more) != 0) return;
  for (auto& [value, allocation] : released_)
    if (value == behind_open) value = submitted_;
}

/// Frees released memory that the queue has finished with. The caller holds `mutex_`.
void VulkanDevice::State::collect() {
  if (released_.empty()) return;
  if (vk.vkGetSemaphoreCounterValue(device, timeline, &done_) != VK_SUCCESS) return;
  std::erase_if(released_, [&](const auto& released) {
    if (released.first > done_) return false;
    free(released.second);
    return true;
  });
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

namespace {
/// What kept pipelines begin with.
struct KeptHeader {
  std::uint64_t magic = 0x3165706950534753;  // "SGSPipe1"
  std::uint64_t bytes = 0, hash = 0;

  /// By FNV-1a.
  explicit KeptHeader(Span<const std::byte> kept) : bytes(kept.size), hash(0xcbf29ce484222325) {
    for (const std::byte b : kept) hash = (hash ^ std::uint64_t(b)) * 0x100000001b3;
  }
};
}  // namespace

std::vector<std::byte> VulkanDevice::State::kept_pipelines() {
  const std::lock_guard lock(cache_mutex_);
  std::size_t bytes = 0;
  vulkan::check(vk.vkGetPipelineCacheData(device, pipelines, &bytes, nullptr), "vkGetPipelineCacheData");
  std::vector<std::byte> kept(sizeof(KeptHeader) + bytes);
  std::byte* const data = kept.data() + sizeof(KeptHeader);
  vulkan::check(vk.vkGetPipelineCacheData(device, pipelines, &bytes, data), "vkGetPipelineCacheData");
  kept.resize(sizeof(KeptHeader) + bytes);
  const KeptHeader header({data, bytes});
  std::memcpy(kept.data(), &header, sizeof header);
  return kept;
}

void VulkanDevice::State::add_pipelines(Span<const std::byte> kept) {
  if (kept.size < sizeof(KeptHeader) + sizeof cache_header_) return;
  const Span<const std::byte> data{kept.data + sizeof(KeptHeader), kept.size - sizeof(KeptHeader)};
  const KeptHeader header(data);
  if (std::memcmp(kept.data, &header, sizeof header) != 0 ||
      std::memcmp(data.data, &cache_header_, sizeof cache_header_) != 0)
    return;
  VkPipelineCacheCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
  info.initialDataSize = data.size, info.pInitialData = data.data;
  VkPipelineCache more = VK_NULL_HANDLE;
  vulkan::check(vk.vkCreatePipelineCache(device, &info, nullptr, &more), "vkCreatePipelineCache");
  const std::lock_guard lock(cache_mutex_);
  const VkResult result = vk.vkMergePipelineCaches(device, pipelines, 1, &more);
  vk.vkDestroyPipelineCache(device, more, nullptr);
  vulkan::check(result, "vkMergePipelineCaches");
}

VkPipeline VulkanDevice::State::pipeline(vulkan::Kernel kernel, std::uint32_t threads,
                                         const std::vector<std::uint32_t>& constants) {
  std::vector<std::uint32_t> key{std::uint32_t(kernel), subgroup, threads, arithmetic};
  key.insert(key.end(), constants.begin(), constants.end());
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = pipelines_.find(key); found != pipelines_.end()) return found->second;
  }
  // Others go on meanwhile. If two threads compile the same, the first that is done wins.
  const VkPipeline made = [&] {
    const std::shared_lock lock(cache_mutex_);
    return compile(kernel, key);
  }();
  const std::lock_guard lock(mutex_);
  const auto [at, is_new] = pipelines_.emplace(key, made);
  if (!is_new) vk.vkDestroyPipeline(device, made, nullptr);
  return at->second;
}

VkPipeline VulkanDevice::State::compile(vulkan::Kernel kernel, const std::vector<std::uint32_t>& key) const {
  const Span<const std::uint32_t> code = vulkan::code_of(kernel);
  VkShaderModuleCreateInfo of_module{};
  of_module.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  of_module.codeSize = code.size * sizeof(std::uint32_t), of_module.pCode = code.data;
  VkShaderModule module = VK_NULL_HANDLE;
  vulkan::check(vk.vkCreateShaderModule(device, &of_module, nullptr, &module), "vkCreateShaderModule");
  // The constants of `common.glsl` first.
  std::vector<VkSpecializationMapEntry> entries;
  for (std::uint32_t i = 1; i < key.size(); ++i)
    entries.push_back({i - 1, std::uint32_t((i - 1) * sizeof(std::uint32_t)), sizeof(std::uint32_t)});
  const VkSpecializationInfo specialization{std::uint32_t(entries.size()), entries.data(),
                                            (key.size() - 1) * sizeof(std::uint32_t), key.data() + 1};
  VkPipelineShaderStageRequiredSubgroupSizeCreateInfo required{};
  required.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO;
  required.requiredSubgroupSize = subgroup;
  VkComputePipelineCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO, info.layout = layout;
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, info.stage.pNext = &required;
  info.stage.flags = VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT, info.stage.module = module, info.stage.pName = "main";
  info.stage.pSpecializationInfo = &specialization;
  VkPipeline made = VK_NULL_HANDLE;
  const VkResult result = vk.vkCreateComputePipelines(device, pipelines, 1, &info, nullptr, &made);
  vk.vkDestroyShaderModule(device, module, nullptr);
  vulkan::check(result, "vkCreateComputePipelines");
  return made;
}

}  // namespace swiftgs
