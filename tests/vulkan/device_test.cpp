// SPDX-License-Identifier: Apache-2.0

// Devices of the program, and what programs do with them beside frames.
#include "vulkan/device.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/contribution.hpp>
#include <swiftgs/swiftgs.hpp>

#include "commands.hpp"
#include "policies/images.hpp"
#include "policies/random_splats.hpp"

namespace swiftgs::test {
namespace {

/// The features that a program enables.
struct EnabledFeatures {
  VkPhysicalDeviceVulkan13Features of_1_3{};
  VkPhysicalDeviceVulkan12Features of_1_2{};
  VkPhysicalDeviceFeatures2 all{};

  EnabledFeatures() {
    of_1_3.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    of_1_3.subgroupSizeControl = of_1_3.computeFullSubgroups = VK_TRUE;
    of_1_2.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, of_1_2.pNext = &of_1_3;
    of_1_2.bufferDeviceAddress = of_1_2.timelineSemaphore = of_1_2.scalarBlockLayout = VK_TRUE;
    all.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, all.pNext = &of_1_2;
  }
  EnabledFeatures(const EnabledFeatures&) = delete;
};

VulkanHandles with_features(const EnabledFeatures& features) {
  VulkanHandles handles = VulkanDevice::own().handles();
  handles.enabled_features = &features.all;
  return handles;
}

/// A device that lacks a function, whose submits and waits fail once it is lost, whose allocations fail as
/// often as told, and that counts submissions, freed memory and merges of pipelines.
std::string missing;
std::atomic<bool> lost = false;
std::atomic<int> failing_allocations = 0, submissions = 0, frees = 0, merges = 0;
using Function = void (*)();
VkResult submit_or_fail(VkQueue queue, std::uint32_t count, const VkSubmitInfo* submits, VkFence fence) {
  if (lost) return VK_ERROR_DEVICE_LOST;
  ++submissions;
  return VulkanDevice::own().state().vk.vkQueueSubmit(queue, count, submits, fence);
}
VkResult wait_or_fail(VkDevice device, const VkSemaphoreWaitInfo* wait, std::uint64_t) {
  if (lost) return VK_ERROR_DEVICE_LOST;
  return VulkanDevice::own().state().vk.vkWaitSemaphores(device, wait, ~std::uint64_t(0));
}
VkResult allocate_or_fail(VkDevice device, const VkMemoryAllocateInfo* info, const VkAllocationCallbacks*,
                          VkDeviceMemory* memory) {
  if (failing_allocations > 0) return --failing_allocations, VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return VulkanDevice::own().state().vk.vkAllocateMemory(device, info, nullptr, memory);
}
void count_free(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks*) {
  ++frees;
  VulkanDevice::own().state().vk.vkFreeMemory(device, memory, nullptr);
}
VkResult count_merge(VkDevice device, VkPipelineCache to, std::uint32_t count, const VkPipelineCache* from) {
  ++merges;
  return VulkanDevice::own().state().vk.vkMergePipelineCaches(device, to, count, from);
}
PFN_vkVoidFunction get_of_device(VkDevice device, const char* name) {
  const std::string wanted = name;
  if (wanted == missing) return nullptr;
  if (wanted == "vkQueueSubmit") return reinterpret_cast<PFN_vkVoidFunction>(submit_or_fail);
  if (wanted == "vkWaitSemaphores") return reinterpret_cast<PFN_vkVoidFunction>(wait_or_fail);
  if (wanted == "vkAllocateMemory") return reinterpret_cast<PFN_vkVoidFunction>(allocate_or_fail);
  if (wanted == "vkFreeMemory") return reinterpret_cast<PFN_vkVoidFunction>(count_free);
  if (wanted == "vkMergePipelineCaches") return reinterpret_cast<PFN_vkVoidFunction>(count_merge);
  return VulkanDevice::own().state().vk.vkGetDeviceProcAddr(device, name);
}
Function get_hooked(VkInstance instance, const char* name) {
  if (name == missing) return nullptr;
  if (std::string(name) == "vkGetDeviceProcAddr") return reinterpret_cast<Function>(get_of_device);
  return VulkanDevice::own().handles().get_instance_proc_addr(instance, name);
}
VulkanHandles hooked() {
  VulkanHandles handles = VulkanDevice::own().handles();
  handles.get_instance_proc_addr = get_hooked;
  return handles;
}

/// Commands of the program, begun, on the device of `b`.
VkCommandBuffer begin_commands(const Vulkan& b) {
  const VulkanDevice::State& device = b.state().device.state();
  VkCommandBufferAllocateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  info.commandPool = b.state().pool, info.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  REQUIRE(device.vk.vkAllocateCommandBuffers(device.device, &info, &commands) == VK_SUCCESS);
  VkCommandBufferBeginInfo begin{};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  REQUIRE(device.vk.vkBeginCommandBuffer(commands, &begin) == VK_SUCCESS);
  return commands;
}

}  // namespace

TEST_CASE("vulkan: a device without handles is refused by name") {
  CHECK_THROWS_WITH_AS(VulkanDevice{VulkanHandles{}},
                       doctest::Contains("vulkan: a handle is missing, expected instance, physical_device"),
                       InvalidArgument);
}

SWIFTGS_VULKAN_CASE("vulkan: each feature that a program did not enable is refused by name") {
  const auto check = [](VkBool32& feature, const EnabledFeatures& features, const std::string& name) {
    feature = VK_FALSE;
    const std::string expected =
        "vulkan: the device was made without " + name + ", expected it among enabled_features";
    CHECK_THROWS_WITH_AS(VulkanDevice{with_features(features)}, expected.c_str(), Unavailable);
    feature = VK_TRUE;
  };
  EnabledFeatures features;
  check(features.of_1_2.bufferDeviceAddress, features, "bufferDeviceAddress");
  check(features.of_1_2.timelineSemaphore, features, "timelineSemaphore");
  check(features.of_1_2.scalarBlockLayout, features, "scalarBlockLayout");
  check(features.of_1_3.subgroupSizeControl, features, "subgroupSizeControl");
  check(features.of_1_3.computeFullSubgroups, features, "computeFullSubgroups");
  Vulkan b{VulkanDevice(with_features(features))};
  CHECK_THROWS_WITH_AS(
      b.store({.width = 1, .height = 1}, nullptr),
      "vulkan: the device was made without shaderStorageImageWriteWithoutFormat, expected it "
      "for images",
      Unavailable);
}

SWIFTGS_VULKAN_CASE("vulkan: a function that is missing and a queue that is none are refused by name") {
  VulkanHandles handles = hooked();
  missing = "vkGetPhysicalDeviceFeatures2";
  CHECK_THROWS_WITH_AS(VulkanDevice{handles},
                       "vulkan: no function vkGetPhysicalDeviceFeatures2, expected an instance of Vulkan 1.3",
                       Unavailable);
  missing = "vkWaitSemaphores";
  CHECK_THROWS_WITH_AS(VulkanDevice{handles},
                       "vulkan: no function vkWaitSemaphores, expected a device of Vulkan 1.3", Unavailable);
  missing.clear();
  handles.queue_family = 1000;
  CHECK_THROWS_WITH_AS(VulkanDevice{handles}, doctest::Contains("vulkan: queue_family is 1000, expected one"),
                       InvalidArgument);
}

/// Small frames with timestamps, on a hooked device.
struct TimedFrames {
  VulkanDevice device{hooked()};
  Renderer<Vulkan> renderer{Vulkan(device)};
  VulkanScene scene = renderer.backend().upload(make_builtin_scene(500));
  Camera camera = builtin_camera(32, 32);
  RenderSettings timed;

  TimedFrames() { timed.time = true; }
};

SWIFTGS_VULKAN_CASE(
    "vulkan: a lost device is an error of the device and ends no program by a wait for ever") {
  {
    TimedFrames frames;
    auto& [device, renderer, scene, camera, timed] = frames;
    const Frame before = renderer.render(scene, camera, timed);
    REQUIRE(before.colour.size() == 3 * 32 * 32);
    lost = true;
    CHECK_THROWS_WITH_AS(renderer.render(scene, camera, timed), doctest::Contains("the device is lost"),
                         DeviceError);
    CHECK_THROWS_WITH_AS(renderer.backend().wait(), doctest::Contains("the device is lost"), DeviceError);
    lost = false;  // commands whose submit failed leave nothing behind
    CHECK(same_bits(renderer.render(scene, camera, timed).colour, before.colour));
  }
}

SWIFTGS_VULKAN_CASE("vulkan: a frame and its timestamps take two submissions") {
  TimedFrames frames;
  auto& [device, renderer, scene, camera, timed] = frames;
  renderer.render(scene, camera, timed);
  submissions = 0;
  renderer.render_resident(scene, camera, timed);
  renderer.wait();
  CHECK(submissions == 2);
  if (device.state().nanoseconds != 0) CHECK(renderer.times().total > 0);
}

SWIFTGS_VULKAN_CASE("vulkan: a signal that is asked for within a frame of stages is that of all its work") {
  const VulkanDevice device(hooked());
  Vulkan b(device);
  vulkan::Commands(b).fill(vulkan::words_at(b.state().groups.device), 3, 1);
  submissions = 0;
  const Vulkan::Signal signal = b.last_signal();
  CHECK(submissions == 1);
  device.state().wait(signal.value);
  CHECK(b.last_signal().value == signal.value);
  CHECK(submissions == 1);
}

SWIFTGS_VULKAN_CASE("vulkan: a view whose memory does not suffice adds no contributions and drops none") {
  const VulkanDevice device(hooked());
  const auto scene = std::make_shared<const Scene>(make_builtin_scene(500));
  Contributions<Vulkan> found(scene, Vulkan(device)), expected(scene, Vulkan(device));
  found.add(builtin_camera(32, 32), {}), expected.add(builtin_camera(32, 32), {});
  failing_allocations = 100;
  CHECK_THROWS_AS(found.add(builtin_camera(512, 512), {}), CapacityError);
  failing_allocations = 0;
  CHECK(found.sums() == expected.sums());
}

SWIFTGS_VULKAN_CASE("vulkan: an image that is null and a frame without pixels or colours are refused") {
  Vulkan b;
  VulkanBuffer<float> colours;
  colours.reset(3);
  VkImageView image = reinterpret_cast<VkImageView>(&b);  // never read
  CHECK_THROWS_AS(b.load(nullptr, {.width = 1, .height = 1, .colour = {colours.data(), 12}}),
                  InvalidArgument);
  CHECK_THROWS_AS(b.load(image, {.width = 1, .height = 1}), InvalidArgument);
  CHECK_THROWS_AS(b.load(image, {.width = 0, .height = 1, .colour = {colours.data(), 12}}), InvalidArgument);
  CHECK_THROWS_AS(b.load(image, {.width = 2, .height = 1, .colour = {colours.data(), 12}}), InvalidArgument);
  CHECK_THROWS_AS(b.load_depth(nullptr, colours.data(), 1, 1), InvalidArgument);
  CHECK_THROWS_AS(b.load_depth(image, nullptr, 1, 1), InvalidArgument);
  CHECK_THROWS_AS(b.load_depth(image, colours.data(), 1, -1), InvalidArgument);
}

SWIFTGS_VULKAN_CASE("vulkan: memory that is not enough is asked for again once and then refused") {
  const VulkanDevice device(hooked());
  const MemoryHook& hook = device.memory_hook();
  failing_allocations = 1;
  hook.release(hook.context, hook.allocate(hook.context, 64), 64);
  CHECK(failing_allocations == 0);
  failing_allocations = 2;
  CHECK_THROWS_AS(hook.allocate(hook.context, 64), CapacityError);
}

SWIFTGS_VULKAN_CASE(
    "vulkan: constants lie in memory of the host where the device has no more and trim frees them") {
  const VulkanDevice device(hooked());
  VulkanDevice::State& state = device.state();
  failing_allocations = 2;
  vulkan::Block block = state.allocate_host_block(64, vulkan::HostMemory::of_device);
  CHECK(failing_allocations == 0);
  CHECK(block.host);
  state.release(block);
  failing_allocations = 2;
  CHECK_THROWS_AS(state.allocate_host_block(64, vulkan::HostMemory::cached), CapacityError);

  Vulkan b(device);
  vulkan::Commands(b).constants(Span<const std::uint32_t>{&state.subgroup, 1});
  b.wait();
  frees = 0;
  b.trim();
  CHECK(frees == 1);
}

SWIFTGS_VULKAN_CASE("vulkan: footprints of a frame that was not projected are those of no bounds") {
  const VulkanDevice device(hooked());
  Vulkan b(device);
  const View view = view_without_camera(32, 32);
  ProjectScratch<Vulkan> scratch;
  Splats<Vulkan> splats;
  Footprints<Vulkan> footprints;
  footprints.found_within = Ellipse::name;
  lost = true;
  CHECK_THROWS_AS(vulkan::project(b, plan_without_scene({&view, 1}), vulkan::bounds_kind<Ellipse>, scratch,
                                  splats, footprints),
                  DeviceError);
  lost = false;
  CHECK(footprints.found_within.empty());
}

SWIFTGS_VULKAN_CASE("vulkan: bytes behind those that are written stay") {
  const Vulkan b;
  VulkanBuffer<std::uint8_t> there;
  there.reset(8);
  const std::vector<std::uint8_t> ones(8, 1), twos(8, 2);
  for (std::size_t bytes = 1; bytes < 8; ++bytes) {
    CAPTURE(bytes);
    b.write(ones.data(), there.data(), ones.size());
    b.write(twos.data(), there.data(), bytes);
    std::vector<std::uint8_t> expected = ones;
    std::fill_n(expected.begin(), bytes, std::uint8_t(2));
    CHECK(to_host(b, std::as_const(there).span()) == expected);
  }
}

SWIFTGS_VULKAN_CASE("vulkan: memory that is released while a recording is kept is freed behind it") {
  const VulkanDevice device(hooked());
  Vulkan b(device);
  const MemoryHook& hook = device.memory_hook();
  void* const first = hook.allocate(hook.context, 64);
  void* const second = hook.allocate(hook.context, 64);
  VulkanRecording kept = b.record(begin_commands(b), [] {});
  frees = 0;
  hook.release(hook.context, first, 64);
  CHECK(frees == 0);
  // A later recording uses the second alone.
  kept = b.record(begin_commands(b), [] {});
  hook.release(hook.context, second, 64);
  CHECK(frees == 1);
}

/// A frame of colours that was drawn once, for which memory is reserved.
struct Recordable {
  Renderer<Vulkan> renderer{};
  Vulkan& b = renderer.backend();
  VulkanScene scene;
  VulkanBuffer<float> colours{};
  VulkanBuffer<FrameReport> report{};
  std::vector<float> drawn{};

  Recordable(const Scene& of, int width, int height) : scene(b.upload(of)) {
    colours.reset(3 * width * height), report.reset(1);
    FrameView frame{.width = width, .height = height};
    frame.colour = {colours.data(), 12 * width};
    const View view = make_view(forward_camera(width, height), {}, frame);
    renderer.render_into(scene, {&view, 1});
    drawn = shown();
    renderer.reserve(scene, {&view, 1});
  }

  std::vector<float> shown() { return to_host(b, std::as_const(colours).span()); }
  void record() { renderer.record(scene.view(), report.data()); }
};

SWIFTGS_VULKAN_CASE("vulkan: later frames expect nothing of a recording that threw or was not submitted") {
  Recordable frame(random_scene(500, 0, 4), 32, 32);
  Vulkan& b = frame.b;
  const auto check = [&] {
    const Vulkan::State& state = b.state();
    CHECK(state.launches_written);
    CHECK(state.long_of == nullptr);
    for (const Count& count : state.counted) CHECK(count.exact == nullptr);
  };
  {
    const VulkanRecording dropped = b.record(begin_commands(b), [&] { frame.record(); });
  }
  check();
  CHECK_THROWS_AS(b.record(begin_commands(b), [&] { frame.record(), throw OrderError("vulkan: expected"); }),
                  OrderError);
  check();
}

SWIFTGS_VULKAN_CASE("vulkan: a backend submits to its queue once the program has unlocked it") {
  const VulkanDevice device(hooked());
  const Vulkan b(device);
  VulkanBuffer<std::uint32_t> there(b.memory_hook());
  there.reset(1);
  auto lock = device.lock_queue();
  const std::uint32_t value = 7;
  const auto written = std::async(std::launch::async, [&] { b.write(&value, there.data(), sizeof value); });
  CHECK(written.wait_for(std::chrono::milliseconds(20)) == std::future_status::timeout);
  lock.unlock(), written.wait();
  CHECK(to_host(b, std::as_const(there).span())[0] == value);
}

SWIFTGS_VULKAN_CASE("vulkan: pipelines are kept for a later run and damaged bytes are ignored") {
  const VulkanDevice device(hooked());
  const std::vector<std::byte> kept = device.pipelines();
  const auto merges_of = [&](const std::vector<std::byte>& bytes) {
    merges = 0;
    device.add_pipelines({bytes.data(), bytes.size()});
    return merges.load();
  };
  CHECK(merges_of(kept) == 1);
  for (const std::size_t bytes : {std::size_t(0), std::size_t(7), kept.size() / 2, kept.size() - 1})
    CHECK(merges_of({kept.begin(), kept.begin() + std::ptrdiff_t(bytes)}) == 0);
  for (std::size_t at = 0; at < kept.size(); ++at) {
    std::vector<std::byte> damaged = kept;
    damaged[at] ^= std::byte(255);
    CHECK(merges_of(damaged) == 0);
  }
}

SWIFTGS_VULKAN_CASE("vulkan: a frame within commands of the program has the bits of one that is submitted") {
  Recordable frame(random_scene(1000, 1, 4), 90, 50);
  Vulkan& b = frame.b;
  VulkanDevice::State& device = b.state().device.state();
  const std::vector<float> nothing(frame.drawn.size());
  const auto clear = [&] { b.write(nothing.data(), frame.colours.data(), 4 * nothing.size()); };
  clear();

  const VkCommandBuffer commands = begin_commands(b);
  const VulkanRecording recording = b.record(commands, [&] {
    frame.record();
    FrameReport report;
    CHECK_THROWS_WITH_AS(b.read(frame.report.data(), &report, 24),
                         "vulkan: read within record, expected it before", OrderError);
  });
  REQUIRE(device.vk.vkEndCommandBuffer(commands) == VK_SUCCESS);
  CHECK(same_bits(frame.shown(), nothing));
  for (int again = 0; again < 2; ++again) {
    device.wait(device.submit(commands));
    CHECK(same_bits(frame.shown(), frame.drawn));
    CHECK(to_host(b, std::as_const(frame.report).span())[0].visible == frame.renderer.statistics().visible);
    clear();
  }
}

}  // namespace swiftgs::test
