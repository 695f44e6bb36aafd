// SPDX-License-Identifier: Apache-2.0

// Pipelines of a device, made when they are first used, and their cache.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <shared_mutex>
#include <tuple>
#include <utility>
#include <vector>

#include "device_state.hpp"

namespace swiftgs {

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

VkPipeline VulkanDevice::State::pipeline(const vulkan::Shader& shader, std::uint32_t threads,
                                         const std::vector<std::uint32_t>& constants) {
  // The constants of `common.glsl` first.
  std::vector<std::uint32_t> all{subgroup, threads, arithmetic};
  all.insert(all.end(), constants.begin(), constants.end());
  const std::tuple key(shader.kernel(), shader.own(), std::move(all));
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = pipelines_.find(key); found != pipelines_.end()) return found->second;
  }
  // Others go on meanwhile. If two threads compile the same, the first that is done wins.
  const VkPipeline made = [&] {
    const std::shared_lock lock(cache_mutex_);
    return compile(shader, std::get<2>(key));
  }();
  const std::lock_guard lock(mutex_);
  const auto [at, is_new] = pipelines_.emplace(key, made);
  if (!is_new) vk.vkDestroyPipeline(device, made, nullptr);
  return at->second;
}

VkPipeline VulkanDevice::State::compile(const vulkan::Shader& shader,
                                        const std::vector<std::uint32_t>& constants) const {
  const vulkan::Code code = shader.code();
  VkShaderModuleCreateInfo of_module{};
  of_module.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  of_module.codeSize = code.words.size * sizeof(std::uint32_t), of_module.pCode = code.words.data;
  VkShaderModule module = VK_NULL_HANDLE;
  vulkan::check(vk.vkCreateShaderModule(device, &of_module, nullptr, &module), "vkCreateShaderModule");
  std::vector<VkSpecializationMapEntry> entries;
  for (std::uint32_t i = 0; i < constants.size(); ++i)
    entries.push_back({i, std::uint32_t(i * sizeof(std::uint32_t)), sizeof(std::uint32_t)});
  const VkSpecializationInfo specialization{std::uint32_t(entries.size()), entries.data(),
                                            constants.size() * sizeof(std::uint32_t), constants.data()};
  VkPipelineShaderStageRequiredSubgroupSizeCreateInfo required{};
  required.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO;
  required.requiredSubgroupSize = subgroup;
  VkComputePipelineCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO, info.layout = layout;
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, info.stage.pNext = &required;
  info.stage.flags = VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module, info.stage.pName = code.entry.c_str();
  info.stage.pSpecializationInfo = &specialization;
  VkPipeline made = VK_NULL_HANDLE;
  const VkResult result = vk.vkCreateComputePipelines(device, pipelines, 1, &info, nullptr, &made);
  vk.vkDestroyShaderModule(device, module, nullptr);
  vulkan::check(result, "vkCreateComputePipelines");
  return made;
}

}  // namespace swiftgs
