// SPDX-License-Identifier: Apache-2.0

// Memory of a device, which is freed once the queue has finished with it.
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <utility>

#include <swiftgs/error.hpp>

#include "device_state.hpp"

namespace swiftgs {

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
  buffer.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
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

/// The caller holds `mutex_`.
std::pair<vulkan::Allocation, void*> VulkanDevice::State::allocate_host_buffer(std::size_t bytes,
                                                                               vulkan::HostMemory kind) {
  try {
    return allocate_buffer(bytes, host_types_[std::size_t(kind)]);
  } catch (const CapacityError&) {
    if (kind == vulkan::HostMemory::cached) throw;
    return allocate_buffer(bytes, host_types_[std::size_t(vulkan::HostMemory::cached)]);
  }
}

vulkan::Block VulkanDevice::State::allocate_host_block(std::size_t bytes, vulkan::HostMemory kind) {
  const std::lock_guard lock(mutex_);
  const auto [allocation, address] = allocate_host_buffer(bytes, kind);
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

/// Frees memory once the queue has finished with it. The caller holds `mutex_`.
void VulkanDevice::State::put_off(const vulkan::Allocation& allocation) {
  released_.push_back({allocation, opened_, {}});
  find_ends();
  collect();
}

std::uint64_t VulkanDevice::State::open() {
  const std::lock_guard lock(mutex_);
  open_.insert(++opened_);
  return opened_;
}

void VulkanDevice::State::close(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  open_.erase(number);
  find_ends();
}

/// Finds `done_at` of memory that no open commands may use. The caller holds `mutex_`.
void VulkanDevice::State::find_ends() {
  for (Released& released : released_)
    if (!released.done_at && (open_.empty() || *open_.begin() > released.opened))
      released.done_at = submitted_;
}

/// Frees released memory that the queue has finished with. The caller holds `mutex_`.
void VulkanDevice::State::collect() {
  if (released_.empty()) return;
  if (vk.vkGetSemaphoreCounterValue(device, timeline, &done_) != VK_SUCCESS) return;
  std::erase_if(released_, [&](const auto& released) {
    if (!released.done_at || *released.done_at > done_) return false;
    free(released.allocation);
    return true;
  });
}

}  // namespace swiftgs
