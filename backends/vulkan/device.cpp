// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <dlfcn.h>

#include <swiftgs/error.hpp>
#include <swiftgs/vulkan/device.hpp>

#include "commands.hpp"

namespace swiftgs {
namespace {

/// A feature that the shaders need: its name, and whether a chain of features has it.
struct Feature {
  const char* name;
  VkBool32 enabled = VK_FALSE;
};
using Features = std::array<Feature, 5>;

/// Features of all versions in one chain.
struct FeatureChain {
  VkPhysicalDeviceFeatures2 all{};
  VkPhysicalDeviceVulkan12Features of_1_2{};
  VkPhysicalDeviceVulkan13Features of_1_3{};

  FeatureChain() {
    all.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, all.pNext = &of_1_2;
    of_1_2.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, of_1_2.pNext = &of_1_3;
    of_1_3.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
  }
  FeatureChain(const FeatureChain&) = delete;
  FeatureChain& operator=(const FeatureChain&) = delete;
};

/// The needed features that a chain enables, in the structs of 1.2 and 1.3 or in those of each.
Features needed_features(const VkPhysicalDeviceFeatures2& chain) {
  VkBool32 address = VK_FALSE, timeline = VK_FALSE, scalar = VK_FALSE, size = VK_FALSE, full = VK_FALSE;
  for (const auto* link = reinterpret_cast<const VkBaseInStructure*>(&chain); link; link = link->pNext) {
    switch (link->sType) {
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES: {
        const auto& of = *reinterpret_cast<const VkPhysicalDeviceVulkan12Features*>(link);
        address = of.bufferDeviceAddress, timeline = of.timelineSemaphore, scalar = of.scalarBlockLayout;
        break;
      }
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES: {
        const auto& of = *reinterpret_cast<const VkPhysicalDeviceVulkan13Features*>(link);
        size = of.subgroupSizeControl, full = of.computeFullSubgroups;
        break;
      }
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES:
        address =
            reinterpret_cast<const VkPhysicalDeviceBufferDeviceAddressFeatures*>(link)->bufferDeviceAddress;
        break;
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES:
        timeline =
            reinterpret_cast<const VkPhysicalDeviceTimelineSemaphoreFeatures*>(link)->timelineSemaphore;
        break;
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES:
        scalar = reinterpret_cast<const VkPhysicalDeviceScalarBlockLayoutFeatures*>(link)->scalarBlockLayout;
        break;
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES: {
        const auto& of = *reinterpret_cast<const VkPhysicalDeviceSubgroupSizeControlFeatures*>(link);
        size = of.subgroupSizeControl, full = of.computeFullSubgroups;
        break;
      }
      default:
        break;
    }
  }
  return {{{"bufferDeviceAddress", address},
           {"timelineSemaphore", timeline},
           {"scalarBlockLayout", scalar},
           {"subgroupSizeControl", size},
           {"computeFullSubgroups", full}}};
}

/// Names the first property, features apart, that the shaders need and `device` lacks. Empty if it has all.
std::string lacks(const vulkan::Functions& vk, VkPhysicalDevice device) {
  VkPhysicalDeviceVulkan13Properties of_1_3{};
  of_1_3.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES;
  VkPhysicalDeviceVulkan12Properties of_1_2{};
  of_1_2.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES, of_1_2.pNext = &of_1_3;
  VkPhysicalDeviceVulkan11Properties of_1_1{};
  of_1_1.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES, of_1_1.pNext = &of_1_2;
  VkPhysicalDeviceProperties2 all{};
  all.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  vk.vkGetPhysicalDeviceProperties2(device, &all);
  const std::string begin = "vulkan device '" + std::string(all.properties.deviceName) + "': expected ";
  if (all.properties.apiVersion < VK_API_VERSION_1_3) return begin + "Vulkan 1.3";
  all.pNext = &of_1_1;
  vk.vkGetPhysicalDeviceProperties2(device, &all);
  if (!of_1_2.shaderRoundingModeRTEFloat32) return begin + "shaderRoundingModeRTEFloat32";
  const VkSubgroupFeatureFlags operations = VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_VOTE_BIT |
                                            VK_SUBGROUP_FEATURE_ARITHMETIC_BIT |
                                            VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_SHUFFLE_BIT;
  if ((of_1_1.subgroupSupportedOperations & operations) != operations ||
      !(of_1_1.subgroupSupportedStages & VK_SHADER_STAGE_COMPUTE_BIT))
    return begin + "basic, vote, arithmetic, ballot and shuffle operations of subgroups in compute shaders";
  if (of_1_1.subgroupSize < 4 || of_1_1.subgroupSize > 64) return begin + "subgroups of 4 to 64 lanes";
  if (!(of_1_3.requiredSubgroupSizeStages & VK_SHADER_STAGE_COMPUTE_BIT))
    return begin + "compute shaders that require a size of subgroups";
  const VkPhysicalDeviceLimits& limits = all.properties.limits;
  const std::uint32_t lanes = of_1_1.subgroupSize;
  const std::uint32_t subgroups = std::max(vulkan::usual_threads, vulkan::sort_threads(lanes)) / lanes;
  if (limits.maxComputeWorkGroupInvocations < 256 || limits.maxComputeWorkGroupSize[0] < 256 ||
      of_1_3.maxComputeWorkgroupSubgroups < subgroups)
    return begin + "workgroups of 256 threads and " + std::to_string(subgroups) + " subgroups";
  // What rasterizing long lists takes with subgroups of 32 lanes.
  if (limits.maxComputeSharedMemorySize < 32768) return begin + "32,768 bytes of shared memory";
  return {};
}

/// `VulkanDevice::own()` before it is checked: an instance, and the device once it is made.
class OwnDevice {
 public:
  OwnDevice() : OwnDevice(loader()) {
    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, application.apiVersion = VK_API_VERSION_1_3;
    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, info.pApplicationInfo = &application;
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(get_(nullptr, "vkCreateInstance"));
    if (!create || create(&info, nullptr, &instance_) != VK_SUCCESS)
      throw Unavailable("vulkan: expected an instance of Vulkan 1.3");
    vk_ = vulkan::functions_of(get_, instance_);
  }
  ~OwnDevice() {
    if (device_)
      reinterpret_cast<PFN_vkDestroyDevice>(vk_.vkGetDeviceProcAddr(device_, "vkDestroyDevice"))(device_,
                                                                                                 nullptr);
    if (instance_)
      reinterpret_cast<PFN_vkDestroyInstance>(get_(instance_, "vkDestroyInstance"))(instance_, nullptr);
  }
  OwnDevice(const OwnDevice&) = delete;
  OwnDevice& operator=(const OwnDevice&) = delete;

  VulkanHandles handles() const {
    const auto get_queue =
        reinterpret_cast<PFN_vkGetDeviceQueue>(vk_.vkGetDeviceProcAddr(device_, "vkGetDeviceQueue"));
    VkQueue queue = VK_NULL_HANDLE;
    get_queue(device_, family_, 0, &queue);
    return {instance_, physical_, device_, queue, family_, &enabled_.all, get_};
  }

  /// Throws `Unavailable` if no device has all that is needed.
  VkPhysicalDevice choose() const {
    std::uint32_t count = 0;
    vulkan::check(vk_.vkEnumeratePhysicalDevices(instance_, &count, nullptr), "vkEnumeratePhysicalDevices");
    std::vector<VkPhysicalDevice> devices(count);
    vk_.vkEnumeratePhysicalDevices(instance_, &count, devices.data());
    devices.resize(count);
    const auto rank = [&](VkPhysicalDevice device) {
      VkPhysicalDeviceProperties2 of{};
      of.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
      vk_.vkGetPhysicalDeviceProperties2(device, &of);
      const VkPhysicalDeviceType type = of.properties.deviceType;
      return type == VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU ? 0 : type == VK_PHYSICAL_DEVICE_TYPE_CPU ? 2 : 1;
    };
    std::stable_sort(devices.begin(), devices.end(), [&](auto a, auto b) { return rank(a) < rank(b); });
    std::string why = "vulkan: expected a device";
    for (const VkPhysicalDevice device : devices) {
      const std::string lacking = why_not(device);
      if (lacking.empty()) return device;
      why = lacking;
    }
    throw Unavailable(why);
  }

  void make(VkPhysicalDevice device) {
    physical_ = device;
    std::uint32_t count = 0;
    vk_.vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vk_.vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
    const auto computes = [](const auto& of) { return (of.queueFlags & VK_QUEUE_COMPUTE_BIT) != 0; };
    family_ = std::uint32_t(std::find_if(families.begin(), families.end(), computes) - families.begin());
    if (family_ == count) throw Unavailable("vulkan: expected a queue that computes");
    FeatureChain found;
    vk_.vkGetPhysicalDeviceFeatures2(device, &found.all);
    enabled_.of_1_3.subgroupSizeControl = enabled_.of_1_3.computeFullSubgroups = VK_TRUE;
    enabled_.of_1_2.bufferDeviceAddress = enabled_.of_1_2.timelineSemaphore = VK_TRUE;
    enabled_.of_1_2.scalarBlockLayout = VK_TRUE;
    enabled_.all.features.shaderStorageImageWriteWithoutFormat =
        found.all.features.shaderStorageImageWriteWithoutFormat;
    const float priority = 1;
    VkDeviceQueueCreateInfo queue{};
    queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, queue.queueFamilyIndex = family_;
    queue.queueCount = 1, queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, info.pNext = &enabled_.all;
    info.queueCreateInfoCount = 1, info.pQueueCreateInfos = &queue;
    vulkan::check(vk_.vkCreateDevice(device, &info, nullptr, &device_), "vkCreateDevice");
  }

 private:
  /// A complete object, whose destructor runs if the other constructor throws.
  explicit OwnDevice(PFN_vkGetInstanceProcAddr get) : get_(get) {}

  static PFN_vkGetInstanceProcAddr loader() {
    void* const library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library) throw Unavailable("vulkan: expected libvulkan.so.1, the loader of Vulkan");
    const auto get = reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(library, "vkGetInstanceProcAddr"));
    if (!get) throw Unavailable("vulkan: expected vkGetInstanceProcAddr in libvulkan.so.1");
    return get;
  }

  std::string why_not(VkPhysicalDevice device) const {
    if (std::string lacking = lacks(vk_, device); !lacking.empty()) return lacking;
    FeatureChain found;
    vk_.vkGetPhysicalDeviceFeatures2(device, &found.all);
    for (const Feature& feature : needed_features(found.all))
      if (!feature.enabled) return std::string("vulkan: expected a device with ") + feature.name;
    return {};
  }

  PFN_vkGetInstanceProcAddr get_;
  vulkan::Functions vk_;
  VkInstance instance_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  std::uint32_t family_ = 0;
  FeatureChain enabled_;
};

/// Asks the device what its arithmetic promises, as `State::arithmetic` has it.
std::uint32_t find_arithmetic(const VulkanDevice& device) {
  constexpr std::uint32_t products = vulkan::usual_threads;
  std::vector<float> factors;
  for (std::uint32_t i = 0; i < 2 * products; ++i)
    factors.push_back(1 + 0x1p-23f * float((i * 2654435761u) >> 9));
  std::vector<std::uint32_t> lacks(products);
  Vulkan b(device);
  VulkanBuffer<float> there(b.memory_hook());
  VulkanBuffer<std::uint32_t> found(b.memory_hook());
  there.reset(factors.size()), found.reset(products);
  b.write(factors.data(), there.data(), factors.size() * sizeof(float));
  vulkan::Commands commands(b);
  commands.run(
      vulkan::Kernel::probe, {},
      vulkan::Push(vulkan::reads(there.data(), factors.size()), vulkan::writes(found.data(), products)),
      vulkan::Commands::Shape::of(products));
  commands.submit();
  b.download(std::as_const(found).span(), lacks.data());
  return ~std::accumulate(lacks.begin(), lacks.end(), 0u, std::bit_or()) & 3;
}

}  // namespace

VulkanDevice::VulkanDevice(const VulkanHandles& handles) {
  if (!handles.instance || !handles.physical_device || !handles.device || !handles.queue ||
      !handles.enabled_features || !handles.get_instance_proc_addr)
    throw InvalidArgument(
        "vulkan: a handle is missing, expected instance, physical_device, device, queue, enabled_features "
        "and "
        "get_instance_proc_addr");
  for (const Feature& feature : needed_features(*handles.enabled_features))
    if (!feature.enabled)
      throw Unavailable(std::string("vulkan: the device was made without ") + feature.name +
                        ", expected it among enabled_features");
  const auto get = reinterpret_cast<PFN_vkGetInstanceProcAddr>(handles.get_instance_proc_addr);
  const vulkan::Functions of_instance = vulkan::functions_of(get, handles.instance);
  if (const std::string lacking = lacks(of_instance, handles.physical_device); !lacking.empty())
    throw Unavailable(lacking);
  const auto state = std::make_shared<State>(handles, of_instance);
  state->create();
  state_ = state;
  state_->arithmetic = find_arithmetic(*this);
}

const VulkanDevice& VulkanDevice::own() {
  // Never destroyed: objects of the program that end after `main` may still have memory of it.
  static const VulkanDevice* const device = [] {
    auto own = std::make_unique<OwnDevice>();
    own->make(own->choose());
    const auto* const checked = new VulkanDevice(own->handles());
    own.release();
    return checked;
  }();
  return *device;
}

bool VulkanDevice::has_own() {
  try {
    OwnDevice().choose();
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

const VulkanHandles& VulkanDevice::handles() const { return state_->handles; }
std::unique_lock<std::mutex> VulkanDevice::lock_queue() const { return state_->lock_queue(); }

std::vector<std::byte> VulkanDevice::pipelines() const { return state_->kept_pipelines(); }
void VulkanDevice::add_pipelines(Span<const std::byte> kept) const { state_->add_pipelines(kept); }

const MemoryHook& VulkanDevice::memory_hook() const { return state_->hook; }

void* VulkanMemory::allocate(std::size_t bytes) { return VulkanDevice::own().state().allocate(bytes); }
void VulkanMemory::release(void* memory) { VulkanDevice::own().state().release(memory); }

}  // namespace swiftgs
