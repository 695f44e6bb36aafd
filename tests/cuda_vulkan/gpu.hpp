// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Vulkan without a window, and a box that it draws with depth into memory that it exports.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <vulkan/vulkan_raii.hpp>

#include "box.frag.hpp"
#include "box.vert.hpp"
#include "support/among_splats.hpp"

namespace swiftgs::test {

constexpr auto opaque_fd = vk::ExternalMemoryHandleTypeFlagBits::eOpaqueFd;
constexpr auto semaphore_fd = vk::ExternalSemaphoreHandleTypeFlagBits::eOpaqueFd;
constexpr auto general = vk::ImageLayout::eGeneral;
constexpr vk::ImageSubresourceRange colour_part(vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1);
constexpr vk::ImageSubresourceRange depth_part(vk::ImageAspectFlagBits::eDepth, 0, 1, 0, 1);

/// Vulkan, whose layers are to have nothing to say.
class Instance {
 public:
  Instance() {
    const auto layers = context_.enumerateInstanceLayerProperties();
    const char* const validation = "VK_LAYER_KHRONOS_validation";
    const bool validated = std::any_of(layers.begin(), layers.end(), [&](const vk::LayerProperties& layer) {
      return std::string_view(layer.layerName) == validation;
    });
    const char* const utilities = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const vk::ApplicationInfo application({}, 0, {}, 0, VK_API_VERSION_1_3);
    vk::InstanceCreateInfo info({}, &application);
    if (!validated)
      MESSAGE("no validation layers here (package vulkan-validationlayers): nothing checks calls");
    if (validated) info.setPEnabledLayerNames(validation).setPEnabledExtensionNames(utilities);
    try {
      made_.emplace(context_, info);
    } catch (const vk::IncompatibleDriverError&) {
      return;
    }
    if (!validated) return;
    using Severity = vk::DebugUtilsMessageSeverityFlagBitsEXT;
    using Type = vk::DebugUtilsMessageTypeFlagBitsEXT;
    const vk::DebugUtilsMessengerCreateInfoEXT messages({}, Severity::eWarning | Severity::eError,
                                                        Type::eValidation, &Instance::count, this);
    messenger_.emplace(*made_, messages);
  }
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;
  ~Instance() { CHECK(messages_ == 0); }

  /// Empty where there is no driver.
  std::vector<vk::raii::PhysicalDevice> devices() const {
    try {
      if (made_) return vk::raii::PhysicalDevices(*made_);
    } catch (const vk::SystemError&) {
    }
    return {};
  }

 private:
  static VKAPI_ATTR VkBool32 VKAPI_CALL count(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                              VkDebugUtilsMessageTypeFlagsEXT,
                                              const VkDebugUtilsMessengerCallbackDataEXT* message,
                                              void* self) {
    if (++static_cast<Instance*>(self)->messages_ < 10) std::fprintf(stderr, "%s\n", message->pMessage);
    return VK_FALSE;
  }

  vk::raii::Context context_;
  std::optional<vk::raii::Instance> made_;
  std::optional<vk::raii::DebugUtilsMessengerEXT> messenger_;
  int messages_ = 0;
};

using Uuid = std::array<std::uint8_t, VK_UUID_SIZE>;
inline Uuid uuid_of(const vk::raii::PhysicalDevice& device) {
  return device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceIDProperties>()
      .get<vk::PhysicalDeviceIDProperties>()
      .deviceUUID;
}

/// A device that exports memory and semaphores, with a queue.
struct Gpu {
  explicit Gpu(const vk::raii::PhysicalDevice& of) : physical(of) {
    const std::vector<const char*> extensions = {VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME,
                                                 VK_KHR_EXTERNAL_SEMAPHORE_FD_EXTENSION_NAME};
    const float priority = 1;
    const vk::DeviceQueueCreateInfo queues({}, 0, 1, &priority);
    vk::PhysicalDeviceVulkan12Features timelines;
    timelines.timelineSemaphore = true;
    vk::PhysicalDeviceVulkan13Features rendering;
    rendering.dynamicRendering = true;
    rendering.setPNext(&timelines);
    device = {physical, vk::DeviceCreateInfo({}, queues, {}, extensions, nullptr, &rendering)};
    queue = {device, 0, 0};
    pool = {device, vk::CommandPoolCreateInfo(vk::CommandPoolCreateFlagBits::eResetCommandBuffer, 0)};
  }

  vk::raii::CommandBuffer make_commands() const {
    return std::move(vk::raii::CommandBuffers(device, {*pool, vk::CommandBufferLevel::ePrimary, 1}).front());
  }

  enum class Export { no, yes, dedicated };

  /// Memory for a buffer or an image, bound to it.
  template <class Resource>
  vk::raii::DeviceMemory allocate(const Resource& resource, vk::MemoryPropertyFlags wanted,
                                  Export exporting) const {
    const vk::MemoryRequirements need = resource.getMemoryRequirements();
    const auto types = physical.getMemoryProperties().memoryTypes;
    unsigned type = 0;
    while (!(need.memoryTypeBits >> type & 1) || (types[type].propertyFlags & wanted) != wanted) ++type;
    vk::MemoryDedicatedAllocateInfo alone;
    if constexpr (std::is_same_v<Resource, vk::raii::Image>)
      alone.image = *resource;
    else
      alone.buffer = *resource;
    const vk::ExportMemoryAllocateInfo to_others(opaque_fd,
                                                 exporting == Export::dedicated ? &alone : nullptr);
    vk::MemoryAllocateInfo info(need.size, type);
    if (exporting != Export::no) info.pNext = &to_others;
    vk::raii::DeviceMemory memory(device, info);
    resource.bindMemory(*memory, 0);
    return memory;
  }

  /// Passes a buffer to CUDA, or takes it back.
  vk::BufferMemoryBarrier pass(vk::Buffer buffer, bool to_others) const {
    const auto any = vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite;
    vk::BufferMemoryBarrier barrier(any, any, 0, VK_QUEUE_FAMILY_EXTERNAL, buffer, 0, VK_WHOLE_SIZE);
    if (!to_others) std::swap(barrier.srcQueueFamilyIndex, barrier.dstQueueFamilyIndex);
    return barrier;
  }

  vk::raii::PhysicalDevice physical;
  vk::raii::Device device{nullptr};
  vk::raii::Queue queue{nullptr};
  vk::raii::CommandPool pool{nullptr};
};

inline void order(const vk::raii::CommandBuffer& commands,
                  vk::ArrayProxy<const vk::ImageMemoryBarrier> images,
                  vk::ArrayProxy<const vk::BufferMemoryBarrier> buffers = {}) {
  const auto all = vk::PipelineStageFlagBits::eAllCommands;
  const auto any = vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite;
  commands.pipelineBarrier(all | vk::PipelineStageFlagBits::eHost, all | vk::PipelineStageFlagBits::eHost, {},
                           vk::MemoryBarrier(any, any), buffers, images);
}

/// Memory that the host reads.
struct HostCopy {
  HostCopy(const Gpu& gpu, std::size_t size)
      : bytes(size),
        buffer(gpu.device, vk::BufferCreateInfo({}, size, vk::BufferUsageFlagBits::eTransferDst)),
        memory(gpu.allocate(
            buffer, vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent,
            Gpu::Export::no)),
        data(static_cast<const unsigned char*>(memory.mapMemory(0, size))) {}

  Bytes content(std::size_t from, std::size_t count) const { return {data + from, data + from + count}; }

  std::size_t bytes;
  vk::raii::Buffer buffer;
  vk::raii::DeviceMemory memory;
  const unsigned char* data;
};

constexpr std::size_t colour_bytes = 4 * pixels, depth_bytes = sizeof(float) * pixels;

/// Draws the box and copies its colours, BGRA, and its depths behind them to a buffer that is exported.
class Canvas {
 public:
  explicit Canvas(const Gpu& gpu)
      : gpu_(&gpu),
        layout_(gpu.device, vk::PipelineLayoutCreateInfo({}, {}, push)),
        pipeline_(make_pipeline(gpu.device, *layout_)),
        colour_(make_image(bgra, vk::ImageUsageFlagBits::eColorAttachment)),
        depth_(make_image(vk::Format::eD32Sfloat, vk::ImageUsageFlagBits::eDepthStencilAttachment)),
        colour_memory_(gpu.allocate(colour_, {}, Gpu::Export::no)),
        depth_memory_(gpu.allocate(depth_, {}, Gpu::Export::no)),
        colour_view_(gpu.device, {{}, *colour_, vk::ImageViewType::e2D, bgra, {}, colour_part}),
        depth_view_(gpu.device,
                    {{}, *depth_, vk::ImageViewType::e2D, vk::Format::eD32Sfloat, {}, depth_part}) {
    const vk::ExternalMemoryBufferCreateInfo exporting(opaque_fd);
    const auto use = vk::BufferUsageFlagBits::eTransferDst | vk::BufferUsageFlagBits::eTransferSrc;
    vk::BufferCreateInfo info({}, colour_bytes + depth_bytes, use);
    planes = {gpu.device, info.setPNext(&exporting)};
    memory = gpu.allocate(planes, vk::MemoryPropertyFlagBits::eDeviceLocal, Gpu::Export::dedicated);
  }

  void draw_box(const vk::raii::CommandBuffer& commands, const glm::mat4& matrix) const {
    const auto any = vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite;
    const auto barrier = [&](vk::Image image, vk::ImageLayout from, vk::ImageSubresourceRange part) {
      return vk::ImageMemoryBarrier(any, any, from, general, VK_QUEUE_FAMILY_IGNORED, VK_QUEUE_FAMILY_IGNORED,
                                    image, part);
    };
    const auto ordered = [&](vk::ImageLayout from) {
      order(commands, {barrier(*colour_, from, colour_part), barrier(*depth_, from, depth_part)});
    };
    vk::RenderingAttachmentInfo to_colour(*colour_view_, general), to_depth(*depth_view_, general);
    to_colour.loadOp = to_depth.loadOp = vk::AttachmentLoadOp::eClear;
    to_depth.clearValue.depthStencil.depth = 1;
    ordered(vk::ImageLayout::eUndefined);
    commands.beginRendering({{}, {{}, {width, height}}, 1, 0, to_colour, &to_depth});
    commands.bindPipeline(vk::PipelineBindPoint::eGraphics, *pipeline_);
    commands.pushConstants<glm::mat4>(*layout_, vk::ShaderStageFlagBits::eVertex, 0, matrix);
    commands.draw(36, 1, 0, 0);
    commands.endRendering();
    ordered(general);
    vk::BufferImageCopy copy(0, 0, 0, {vk::ImageAspectFlagBits::eColor, 0, 0, 1}, {}, {width, height, 1});
    commands.copyImageToBuffer(*colour_, general, *planes, copy);
    copy.setBufferOffset(colour_bytes).imageSubresource.aspectMask = vk::ImageAspectFlagBits::eDepth;
    commands.copyImageToBuffer(*depth_, general, *planes, copy);
    order(commands, {});
  }

  vk::raii::Buffer planes{nullptr};
  vk::raii::DeviceMemory memory{nullptr};

 private:
  static constexpr auto bgra = vk::Format::eB8G8R8A8Unorm;
  static constexpr vk::PushConstantRange push{vk::ShaderStageFlagBits::eVertex, 0, sizeof(glm::mat4)};

  vk::raii::Image make_image(vk::Format format, vk::ImageUsageFlags use) const {
    vk::ImageCreateInfo info({}, vk::ImageType::e2D, format, {width, height, 1}, 1, 1);
    return {gpu_->device, info.setUsage(use | vk::ImageUsageFlagBits::eTransferSrc)};
  }

  static vk::raii::Pipeline make_pipeline(const vk::raii::Device& device, vk::PipelineLayout layout) {
    const vk::raii::ShaderModule vert(device, {{}, sizeof box_vert, box_vert});
    const vk::raii::ShaderModule frag(device, {{}, sizeof box_frag, box_frag});
    using Stage = vk::ShaderStageFlagBits;
    const vk::PipelineShaderStageCreateInfo stages[] = {{{}, Stage::eVertex, *vert, "main"},
                                                        {{}, Stage::eFragment, *frag, "main"}};
    const vk::PipelineVertexInputStateCreateInfo no_vertex_input;
    const vk::PipelineInputAssemblyStateCreateInfo shapes({}, vk::PrimitiveTopology::eTriangleList);
    const vk::Viewport viewport(0, 0, width, height, 0, 1);
    const vk::Rect2D whole({}, {width, height});
    const vk::PipelineViewportStateCreateInfo viewports({}, viewport, whole);
    const auto raster = vk::PipelineRasterizationStateCreateInfo().setLineWidth(1);
    const vk::PipelineMultisampleStateCreateInfo multisampling;
    const vk::PipelineDepthStencilStateCreateInfo depth({}, true, true, vk::CompareOp::eLess);
    const auto rgba = vk::PipelineColorBlendAttachmentState().setColorWriteMask(vk::ColorComponentFlags(15));
    const vk::PipelineColorBlendStateCreateInfo blend({}, false, {}, rgba);
    const vk::PipelineRenderingCreateInfo targets({}, bgra, vk::Format::eD32Sfloat);
    vk::GraphicsPipelineCreateInfo info({}, stages, &no_vertex_input, &shapes, {}, &viewports, &raster,
                                        &multisampling, &depth, &blend, {}, layout);
    return {device, nullptr, info.setPNext(&targets)};
  }

  const Gpu* gpu_;
  vk::raii::PipelineLayout layout_;
  vk::raii::Pipeline pipeline_;
  vk::raii::Image colour_, depth_;
  vk::raii::DeviceMemory colour_memory_, depth_memory_;
  vk::raii::ImageView colour_view_, depth_view_;
};

}  // namespace swiftgs::test
