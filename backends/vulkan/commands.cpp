// SPDX-License-Identifier: Apache-2.0
#include "commands.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace swiftgs::vulkan {
namespace {

constexpr std::uint32_t scan_part = 8 * usual_threads;
/// Devices take so many workgroups in each direction at least.
constexpr std::uint32_t most_workgroups = 65535;

CommandSlot& next_slot(Vulkan::State& b) {
  if (b.recording) return *b.recording;
  CommandSlot& slot = b.slots[b.next_slot++ % b.slots.size()];
  b.device.state().wait(slot.done_at);
  slot.block = slot.used = 0;
  return slot;
}

/// Stages, and how they access memory.
struct Scope {
  VkPipelineStageFlags stages;
  VkAccessFlags accesses;
};
constexpr Scope shaders_write{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT};
constexpr Scope shaders{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                        VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};

void barrier(const VulkanDevice::State& device, VkCommandBuffer commands, Scope from, Scope to) {
  VkMemoryBarrier memory{};
  memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  memory.srcAccessMask = from.accesses, memory.dstAccessMask = to.accesses;
  device.vk.vkCmdPipelineBarrier(commands, from.stages, to.stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

}  // namespace

Commands::Commands(const Vulkan& b) : b_(b.state()), device_(b_.device.state()), slot_(next_slot(b_)) {
  if (!b_.recording) {
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(device_.vk.vkBeginCommandBuffer(slot_.commands, &begin), "vkBeginCommandBuffer");
    open_ = true;
  }
  // Behind the commands of other recordings, whose accesses are not known here.
  barrier(device_, slot_.commands, shaders_write, shaders);
}

Commands::~Commands() {
  if (open_) device_.vk.vkEndCommandBuffer(slot_.commands);
}

const void* Commands::copy(const void* from, std::size_t bytes) {
  constexpr std::size_t least = 1 << 16, alignment = 64;
  while (slot_.block < slot_.blocks.size() && slot_.blocks[slot_.block].bytes - slot_.used < bytes)
    ++slot_.block, slot_.used = 0;
  if (slot_.block == slot_.blocks.size())
    slot_.blocks.push_back(device_.allocate_block(std::max(bytes, least)));
  const HostBlock& block = slot_.blocks[slot_.block];
  std::memcpy(block.host + slot_.used, from, bytes);
  const void* const to = block.device + slot_.used;
  slot_.used = std::min((slot_.used + bytes + alignment - 1) / alignment * alignment, block.bytes);
  return to;
}

Commands::Shape Commands::Shape::of(std::size_t elements, std::size_t each, std::uint32_t threads) {
  const std::size_t groups = (elements + each - 1) / each;
  const std::size_t rows = std::max<std::size_t>((groups + most_workgroups - 1) / most_workgroups, 1);
  return {std::uint32_t((groups + rows - 1) / rows), std::uint32_t(rows), threads};
}

void Commands::run(Kernel kernel, const std::vector<std::uint32_t>& constants, const Push& push,
                   const Shape& shape, std::initializer_list<Access> accesses) {
  if (shape.columns == 0) return;
  const VkPipeline pipeline = device_.pipeline(kernel, shape.threads, constants);
  if (hazards_.next(accesses)) barrier(device_, slot_.commands, shaders_write, shaders);
  const Functions& vk = device_.vk;
  vk.vkCmdBindPipeline(slot_.commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
  vk.vkCmdPushConstants(slot_.commands, device_.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, push.size(),
                        push.data());
  vk.vkCmdDispatch(slot_.commands, shape.columns, shape.rows, 1);
}

void Commands::fill(void* to, std::size_t words, std::uint32_t value) {
  run(Kernel::fill, {}, Push(to, std::uint32_t(words), value), Shape::of(words), {writes(to, 4 * words)});
}

void Commands::reserve_scan(std::size_t values) { b_.sums.reset((values + scan_part - 1) / scan_part + 1); }

void Commands::scan(std::uint32_t* values, Count count) {
  if (count.most == 0) return;
  std::uint32_t* const sums = b_.sums.data();
  const std::size_t bytes = 4 * count.most, parts = (count.most + scan_part - 1) / scan_part;
  const Access number = reads(count.exact, count.exact ? 4 : 0);
  const Push push(values, sums, count);
  const Shape by_part = Shape::of(count.most, scan_part);
  run(Kernel::scan_sums, {}, push, by_part, {reads(values, bytes), number, writes(sums, 4 * parts)});
  run(Kernel::scan_spine, {}, push, {1}, {writes(sums, 4 * (parts + 1))});
  run(Kernel::scan_apply, {}, push, by_part, {writes(values, bytes), number, reads(sums, 4 * parts)});
}

void Commands::timestamp(std::uint32_t query) {
  device_.vk.vkCmdResetQueryPool(slot_.commands, b_.times, query, 1);
  device_.vk.vkCmdWriteTimestamp(slot_.commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, b_.times, query);
}

void Commands::release_to_host() {
  barrier(device_, slot_.commands, shaders_write, {VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT});
}

void Commands::follow_program() {
  barrier(device_, slot_.commands, {VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_WRITE_BIT}, shaders);
}
void Commands::precede_program() {
  barrier(device_, slot_.commands, shaders_write,
          {VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT});
}

std::uint64_t Commands::submit() {
  if (b_.recording) return b_.last;
  open_ = false;
  check(device_.vk.vkEndCommandBuffer(slot_.commands), "vkEndCommandBuffer");
  return b_.last = slot_.done_at = device_.submit(slot_.commands);
}

}  // namespace swiftgs::vulkan
