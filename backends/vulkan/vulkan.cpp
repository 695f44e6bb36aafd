// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/vulkan/backend.hpp>

#include "commands.hpp"

namespace swiftgs {

namespace {
/// Memory through which copies between the host and the device go.
constexpr std::size_t staging_bytes = std::size_t(1) << 22;

}  // namespace

void vulkan::refuse_while_recording(const Vulkan::State& b, const char* call) {
  if (b.recording) throw OrderError(std::string("vulkan: ") + call + " within record, expected it before");
}

namespace {
void release(VulkanDevice::State& device, vulkan::CommandSlot& slot) {
  vulkan::clear_images(device, slot);
  for (vulkan::Constants& constants : slot.blocks) {
    device.vk.vkDestroyDescriptorPool(device.device, constants.uniforms.pool, nullptr);
    device.release(constants.block);
  }
  slot.blocks.clear();
}
}  // namespace

Vulkan::State::State(const VulkanDevice& on, const std::optional<MemoryHook>& memory)
    : device(on), hook(memory ? *memory : on.memory_hook()), hooked(memory) {
  if (memory) validate(*memory);
  use_memory(hook, numbers, long_tiles);
}

void Vulkan::State::create() {
  VulkanDevice::State& of = device.state();
  VkCommandPoolCreateInfo of_pool{};
  of_pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  of_pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  of_pool.queueFamilyIndex = of.handles.queue_family;
  vulkan::check(of.vk.vkCreateCommandPool(of.device, &of_pool, nullptr, &pool), "vkCreateCommandPool");
  VkCommandBufferAllocateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  info.commandPool = pool, info.commandBufferCount = 1;
  for (vulkan::CommandSlot& slot : slots)
    vulkan::check(of.vk.vkAllocateCommandBuffers(of.device, &info, &slot.commands),
                  "vkAllocateCommandBuffers");
  if (of.nanoseconds != 0) times = of.make_queries(vulkan::time_points);
  report = of.allocate_host_block(sizeof(FrameReport), vulkan::HostMemory::cached);
  groups = of.allocate_block(groups_bytes);
}

Vulkan::State::~State() {
  VulkanDevice::State& of = device.state();
  if (open) of.close(open->number);
  try {
    of.wait(last);
  } catch (const std::exception&) {
    // A lost device has nothing under way.
  }
  of.vk.vkDestroyCommandPool(of.device, pool, nullptr);
  for (const VkQueryPool queries : {times, profile.times})
    of.vk.vkDestroyQueryPool(of.device, queries, nullptr);
  for (vulkan::CommandSlot& slot : slots) release(of, slot);
  of.release(report), of.release(groups), of.release(staging);
}

bool Vulkan::usable() {
  static const bool found = VulkanDevice::has_own();
  return found;
}

Vulkan::Vulkan(const VulkanDevice& device, const std::optional<MemoryHook>& memory)
    : state_(std::make_unique<State>(device, memory)) {
  state_->create();
}
Vulkan::~Vulkan() = default;
Vulkan::Vulkan(Vulkan&&) noexcept = default;
Vulkan& Vulkan::operator=(Vulkan&&) noexcept = default;

std::string Vulkan::device_name() const { return state_->device.state().name; }
const MemoryHook& Vulkan::memory_hook() const { return state_->hook; }

struct VulkanRecording::Kept {
  VulkanDevice device;
  vulkan::CommandSlot slot;

  Kept(const VulkanDevice& on, VkCommandBuffer commands) : device(on) {
    slot.commands = commands;
    slot.number = device.state().open();
  }
  ~Kept() {
    release(device.state(), slot);
    device.state().close(slot.number);
  }
};
VulkanRecording::VulkanRecording(std::unique_ptr<Kept> kept) : kept_(std::move(kept)) {}
VulkanRecording::~VulkanRecording() = default;
VulkanRecording::VulkanRecording(VulkanRecording&&) noexcept = default;
VulkanRecording& VulkanRecording::operator=(VulkanRecording&&) noexcept = default;

VulkanRecording Vulkan::record(VkCommandBuffer_T* commands, const std::function<void()>& draw) {
  State& b = *state_;
  vulkan::refuse_while_recording(b, "record");
  if (b.profile.on) throw OrderError("vulkan: record within profile, expected it before or behind");
  if (b.open) vulkan::Commands(*this).submit();
  auto kept = std::make_unique<VulkanRecording::Kept>(b.device, commands);
  const struct Recording {
    State& b;
    Recording(State& of, vulkan::CommandSlot& slot) : b(of) {
      b.open = &slot, b.recording = true, b.hazards.forget(), b.forget_launches();
    }
    ~Recording() {
      b.open = nullptr, b.recording = false;
      b.forget_launches();  // the program submits the commands when it likes
    }
  } recording(b, kept->slot);
  vulkan::Commands(*this).follow_program();
  draw();
  vulkan::Commands(*this).precede_program();
  return VulkanRecording(std::move(kept));
}

void Vulkan::write(const void* from, void* to, std::size_t bytes) const {
  State& b = *state_;
  vulkan::refuse_while_recording(b, "write");
  if (bytes == 0) return;
  if (!b.staging.host)
    b.staging = b.device.state().allocate_host_block(staging_bytes, vulkan::HostMemory::cached);
  for (std::size_t at = 0; at < bytes; at += staging_bytes) {
    const std::size_t part = std::min(staging_bytes, bytes - at), words = (part + 3) / 4;
    std::byte* const to_part = static_cast<std::byte*>(to) + at;
    // The last word may hold more than is written.
    if (part % 4 != 0) {
      std::byte last[4];
      read(to_part + part / 4 * 4, last, 4);
      std::memcpy(b.staging.host + part / 4 * 4, last, 4);
    }
    std::memcpy(b.staging.host, static_cast<const std::byte*>(from) + at, part);
    vulkan::Commands commands(*this);
    commands.run(vulkan::Kernel::copy, {},
                 vulkan::Push(vulkan::address(b.staging.device), vulkan::writes(to_part, 4 * words),
                              std::uint32_t(words)),
                 vulkan::Commands::Shape::of(words));
    b.device.state().wait(commands.submit());
  }
}

void Vulkan::read(const void* from, void* to, std::size_t bytes) const {
  State& b = *state_;
  vulkan::refuse_while_recording(b, "read");
  if (bytes == 0) return wait();
  if (!b.staging.host)
    b.staging = b.device.state().allocate_host_block(staging_bytes, vulkan::HostMemory::cached);
  for (std::size_t at = 0; at < bytes; at += staging_bytes) {
    const std::size_t part = std::min(staging_bytes, bytes - at), words = (part + 3) / 4;
    const std::byte* const from_part = static_cast<const std::byte*>(from) + at;
    vulkan::Commands commands(*this);
    commands.run(vulkan::Kernel::copy, {},
                 vulkan::Push(vulkan::reads(from_part, 4 * words),
                              vulkan::writes(b.staging.device, 4 * words), std::uint32_t(words)),
                 vulkan::Commands::Shape::of(words));
    b.device.state().wait(commands.submit());
    std::memcpy(static_cast<std::byte*>(to) + at, b.staging.host, part);
  }
}

void Vulkan::wait() const {
  vulkan::refuse_while_recording(*state_, "wait");
  if (state_->open) vulkan::Commands(*this).submit();
  state_->device.state().wait(state_->last);
}

void Vulkan::trim() {
  wait();
  trim_parts(*this, state_->numbers, state_->long_tiles), state_->long_of = nullptr;
  for (vulkan::CommandSlot& slot : state_->slots) release(state_->device.state(), slot);
  state_->device.state().release(state_->staging);
}

Vulkan::Signal Vulkan::last_signal() const {
  if (state_->open && !state_->recording) vulkan::Commands(*this).submit();
  return {state_->device.state().timeline, state_->last};
}

Vulkan::TimePoint Vulkan::now() {
  State& b = *state_;
  vulkan::refuse_while_recording(b, "now");
  const TimePoint point{++b.serial};
  if (!b.times) return point;
  const auto query = std::uint32_t(point.serial % vulkan::time_points);
  vulkan::Commands commands(*this);
  commands.timestamp(b.times, query);
  b.reached_at[query] = ~std::uint64_t(0), b.open_points.push_back(query);
  commands.finish();
  return point;
}

std::optional<double> Vulkan::milliseconds(TimePoint from, TimePoint to) const {
  const State& b = *state_;
  VulkanDevice::State& of = b.device.state();
  if (b.open && !b.recording) vulkan::Commands(*this).submit();
  if (!b.times || b.serial - from.serial >= vulkan::time_points - 1) return {};
  const auto query = [](TimePoint point) { return std::uint32_t(point.serial % vulkan::time_points); };
  for (const TimePoint point : {from, to})
    if (!of.is_done(b.reached_at[query(point)])) return {};
  return of.milliseconds(b.times, query(from), query(to));
}

std::vector<Vulkan::KernelTime> Vulkan::profile(const std::function<void()>& draw) {
  VulkanDevice::State& of = state_->device.state();
  vulkan::refuse_while_recording(*state_, "profile");
  if (!state_->times) return draw(), std::vector<KernelTime>{};
  vulkan::Profile& profile = state_->profile;
  if (!profile.times) profile.times = of.make_queries(2 * vulkan::Profile::most);
  profile.kernels.clear();
  const struct Profiling {
    bool& on;
    explicit Profiling(bool& to) : on(to) { on = true; }
    ~Profiling() { on = false; }
  } profiling(profile.on);
  draw();
  wait();
  std::vector<KernelTime> taken;
  for (const vulkan::Kernel kernel : profile.kernels) {
    const auto query = std::uint32_t(2 * taken.size());
    taken.push_back({name_of(kernel), of.milliseconds(profile.times, query, query + 1).value_or(0)});
  }
  return taken;
}

}  // namespace swiftgs
