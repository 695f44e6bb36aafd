// SPDX-License-Identifier: Apache-2.0
#include "commands.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <utility>

namespace swiftgs::vulkan {
namespace {

/// Devices take so many workgroups in each direction at least.
constexpr std::uint32_t most_workgroups = 65535;

/// Stages, and how they access memory.
struct Scope {
  VkPipelineStageFlags stages;
  VkAccessFlags accesses;
};
constexpr Scope kernels_write{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT};
constexpr Scope kernels{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                        VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
/// Kernels, and the device reading sizes of indirect launches, which it may do early.
constexpr Scope launches{kernels.stages | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT,
                         kernels.accesses | VK_ACCESS_INDIRECT_COMMAND_READ_BIT};
constexpr Scope host_reads{VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT};
/// All commands of the program, and its host.
constexpr Scope program{VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT,
                        VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT};

void barrier(const VulkanDevice::State& device, VkCommandBuffer commands, Scope from, Scope to) {
  VkMemoryBarrier memory{};
  memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  memory.srcAccessMask = from.accesses, memory.dstAccessMask = to.accesses;
  device.vk.vkCmdPipelineBarrier(commands, from.stages, to.stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

/// Closes commands once they are submitted or dropped.
struct Closing {
  VulkanDevice::State& device;
  std::uint64_t number;
  ~Closing() { device.close(number); }
};

}  // namespace

void clear_images(const VulkanDevice::State& device, CommandSlot& slot) {
  for (const Descriptors& image : slot.images)
    device.vk.vkDestroyDescriptorPool(device.device, image.pool, nullptr);
  slot.images.clear();
}

Commands::Commands(const Vulkan& b)
    : b_(b.state()), device_(b_.device.state()), exceptions_(std::uncaught_exceptions()) {
  if (b_.open) return;
  CommandSlot& slot = b_.slots[b_.next_slot++ % b_.slots.size()];
  device_.wait(slot.done_at);
  slot.block = slot.used = 0;
  clear_images(device_, slot);
  VkCommandBufferBeginInfo begin{};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(device_.vk.vkBeginCommandBuffer(slot.commands, &begin), "vkBeginCommandBuffer");
  slot.number = device_.open();
  b_.open = &slot;
  b_.hazards.forget();
}

Commands::~Commands() {
  if (b_.open && !b_.recording && std::uncaught_exceptions() > exceptions_) drop();
}

const void* Commands::copy(const void* from, std::size_t bytes, std::size_t room) {
  CommandSlot& slot = *b_.open;
  constexpr std::size_t least = 1 << 16, most = 1 << 24, alignment = 256;  // of uniforms on any device
  room = std::max(room, bytes);
  while (slot.block < slot.blocks.size() && slot.blocks[slot.block].block.bytes - slot.used < room)
    ++slot.block, slot.used = 0;
  if (slot.block == slot.blocks.size()) {
    // Twice as large as the last one, since devices limit how many there are.
    const std::size_t wanted = slot.blocks.empty() ? least : 2 * slot.blocks.back().block.bytes;
    Constants& made = slot.blocks.emplace_back();
    made.uniforms = device_.make_descriptors(device_.uniforms, {uniform_type});
    made.block = device_.allocate_host_block(std::max(room, std::min(wanted, most)), HostMemory::of_device);
    const VkDescriptorBufferInfo of_buffer{made.block.allocation.buffer, 0, Uniform::most};
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = made.uniforms.set, write.descriptorCount = 1;
    write.descriptorType = uniform_type, write.pBufferInfo = &of_buffer;
    device_.vk.vkUpdateDescriptorSets(device_.device, 1, &write, 0, nullptr);
  }
  const Block& block = slot.blocks[slot.block].block;
  std::memcpy(block.host + slot.used, from, bytes);
  const void* const to = block.device + slot.used;
  slot.used = std::min((slot.used + bytes + alignment - 1) / alignment * alignment, block.bytes);
  return to;
}

Uniform Commands::uniform_at(const void* copied) const {
  const Constants& constants = b_.open->blocks[b_.open->block];
  const auto offset = static_cast<const std::byte*>(copied) - constants.block.device;
  return {constants.uniforms.set, std::uint32_t(offset)};
}

Commands::Shape Commands::Shape::of(std::size_t elements, std::size_t each, std::uint32_t threads) {
  const std::size_t groups = (elements + each - 1) / each;
  const std::size_t rows = std::max<std::size_t>((groups + most_workgroups - 1) / most_workgroups, 1);
  return {std::uint32_t((groups + rows - 1) / rows), std::uint32_t(rows), threads};
}

Commands::Shape Commands::over(Count count, Groups::Of of) const {
  Shape shape = of == Groups::usual   ? Shape::of(count.most)
                : of == Groups::fours ? Shape::of(count.most, 4 * usual_threads)
                                      : Shape::of(count.most, sort_part(count.most), sort_threads());
  for (std::size_t k = 0; k < b_.counted.size(); ++k)
    if (count.exact && b_.counted[k].exact == count.exact && b_.counted[k].most == count.most)
      shape.at = k * sizeof(Groups) + of * sizeof(VkDispatchIndirectCommand);
  return shape;
}

void Commands::run(const Shader& shader, const std::vector<std::uint32_t>& constants, Push push,
                   const Shape& shape) {
  if (shape.columns == 0) return;
  if (shape.at) push.touch(reads(b_.groups.device + *shape.at, sizeof(VkDispatchIndirectCommand)));
  const VkPipeline pipeline = device_.pipeline(shader, shape.threads, constants);
  const VkCommandBuffer commands = b_.open->commands;
  const Functions& vk = device_.vk;
  if (b_.hazards.next(push.accesses()))
    barrier(device_, commands, kernels_write, std::exchange(b_.launches_written, false) ? launches : kernels);
  const Access groups = reads(b_.groups.device, b_.groups.bytes);
  for (const Access& access : push.accesses())
    b_.launches_written =
        b_.launches_written || (access.how != Access::read && groups.conflicts_with(access));
  vk.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
  vk.vkCmdPushConstants(commands, device_.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, push.size(), push.data());
  if (const Uniform& uniform = push.uniform(); uniform.set)
    vk.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, device_.layout, 1, 1, &uniform.set,
                               1, &uniform.offset);
  Profile& profile = b_.profile;
  if (!profile.on || profile.kernels.size() == Profile::most) return dispatch(shape);
  const auto query = std::uint32_t(2 * profile.kernels.size());
  profile.kernels.push_back(shader.kernel());
  barrier(device_, commands, kernels, kernels);
  timestamp(profile.times, query);
  dispatch(shape);
  barrier(device_, commands, kernels, kernels);
  timestamp(profile.times, query + 1);
}

void Commands::dispatch(const Shape& shape) {
  const VkCommandBuffer commands = b_.open->commands;
  if (shape.at)
    device_.vk.vkCmdDispatchIndirect(commands, b_.groups.allocation.buffer, *shape.at);
  else
    device_.vk.vkCmdDispatch(commands, shape.columns, shape.rows, shape.layers);
}

void Commands::bind_image(VkImageView image, std::uint32_t binding) {
  const Functions& vk = device_.vk;
  const VkDescriptorSet set =
      b_.open->images
          .emplace_back(device_.make_descriptors(device_.images, {image_types.begin(), image_types.end()}))
          .set;
  const VkDescriptorImageInfo of_image{VK_NULL_HANDLE, image, VK_IMAGE_LAYOUT_GENERAL};
  VkWriteDescriptorSet write{};
  write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
  write.dstSet = set, write.dstBinding = binding, write.descriptorCount = 1;
  write.descriptorType = image_types[binding], write.pImageInfo = &of_image;
  vk.vkUpdateDescriptorSets(device_.device, 1, &write, 0, nullptr);
  vk.vkCmdBindDescriptorSets(b_.open->commands, VK_PIPELINE_BIND_POINT_COMPUTE, device_.layout, 0, 1, &set, 0,
                             nullptr);
}

void Commands::fill(std::uint32_t* to, std::size_t words, std::uint32_t value) {
  run(Kernel::fill, {}, Push(writes(to, words), std::uint32_t(words), value), Shape::of(words));
}

bool Commands::run_beside() {
  if (b_.beside.empty()) return false;
  const auto next = std::move(b_.beside.front());
  b_.beside.pop_front();
  next(*this);
  return true;
}

void Commands::timestamp(VkQueryPool times, std::uint32_t query) {
  device_.vk.vkCmdResetQueryPool(b_.open->commands, times, query, 1);
  device_.vk.vkCmdWriteTimestamp(b_.open->commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, times, query);
}

void Commands::follow_program() { barrier(device_, b_.open->commands, program, launches); }
void Commands::precede_program() { barrier(device_, b_.open->commands, kernels_write, program); }

void Commands::drop() {
  const Closing closing{device_, b_.open->number};
  b_.open_points.clear(), b_.forget_launches();
  device_.vk.vkEndCommandBuffer(std::exchange(b_.open, nullptr)->commands);
}

void Commands::finish() {
  if (b_.hooked) submit();
}

std::uint64_t Commands::submit() {
  if (b_.recording) return b_.last;
  CommandSlot& slot = *std::exchange(b_.open, nullptr);
  const Closing closing{device_, slot.number};
  const auto points = std::exchange(b_.open_points, {});
  barrier(device_, slot.commands, kernels_write, host_reads);
  check(device_.vk.vkEndCommandBuffer(slot.commands), "vkEndCommandBuffer");
  b_.last = slot.done_at = device_.submit(slot.commands);
  for (const std::uint32_t point : points) b_.reached_at[point] = b_.last;
  return b_.last;
}

}  // namespace swiftgs::vulkan
