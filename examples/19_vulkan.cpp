// SPDX-License-Identifier: Apache-2.0

// Splats between two commands of the program on its own image: a clear, and a copy of the middle to a corner.
#include <vulkan/vulkan.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/swiftgs.hpp>
#include <swiftgs/vulkan.hpp>

using namespace swiftgs;
using enum vk::ImageUsageFlagBits;

int main() {
  if (!Vulkan::usable()) return 77;
  const unsigned width = 320, height = 180;
  const auto format = vk::Format::eR8G8B8A8Unorm;
  const auto general = vk::ImageLayout::eGeneral;
  const VulkanHandles gpu = VulkanDevice::own().handles();
  const vk::Device device = gpu.device;
  const vk::ImageCreateInfo info({}, vk::ImageType::e2D, format, {width, height, 1}, 1, 1,
                                 vk::SampleCountFlagBits::e1, {},
                                 eStorage | eSampled | eTransferSrc | eTransferDst);
  const vk::Image image = device.createImage(info);
  const auto needs = device.getImageMemoryRequirements(image);
  const vk::MemoryAllocateInfo memory(needs.size, unsigned(__builtin_ctz(needs.memoryTypeBits)));
  device.bindImageMemory(image, device.allocateMemory(memory), 0);
  const vk::ImageSubresourceRange all(vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1);
  const auto seen = device.createImageView({{}, image, vk::ImageViewType::e2D, format, {}, all});
  const auto pool = device.createCommandPool({{}, gpu.queue_family});
  const vk::CommandBuffer commands = device.allocateCommandBuffers({pool, {}, 1})[0];
  Renderer<Vulkan> renderer;
  Vulkan& b = renderer.backend();
  const auto scene = b.upload(make_builtin_scene(20'000));
  VulkanBuffer<unsigned> pixels;
  VulkanBuffer<FrameReport> report;
  pixels.reset(width * height), report.reset(1);
  FrameView frame{width, height, {pixels.data(), 4 * width}, PixelFormat::rgba_8};
  Conventions conventions;
  frame.over = true, conventions.far_plane = 7;
  const View view = make_view(builtin_camera(width, height), conventions, frame);
  renderer.reserve(scene, {&view, 1});
  commands.begin(vk::CommandBufferBeginInfo());
  const vk::ImageMemoryBarrier ready({}, vk::AccessFlagBits::eTransferWrite, {}, general, 0, 0, image, all);
  const auto transfer = vk::PipelineStageFlagBits::eTransfer;
  commands.pipelineBarrier(transfer, transfer, {}, {}, {}, ready);
  commands.clearColorImage(image, general, vk::ClearColorValue(0.2f, 0.4f, 0.6f, 1.0f), all);
  const VulkanRecording kept = b.record(commands, [&] {
    b.load(seen, frame), renderer.record(scene.view(), report.data()), b.store(frame, seen);
  });
  const vk::ImageSubresourceLayers layer(vk::ImageAspectFlagBits::eColor, 0, 0, 1);
  const vk::ImageCopy corner(layer, {140, 70, 0}, layer, {0, 0, 0}, {40, 40, 1});
  commands.copyImage(image, general, image, general, corner);
  commands.end(), vk::Queue(gpu.queue).submit(vk::SubmitInfo(0, nullptr, nullptr, 1, &commands));
  device.waitIdle(), b.load(seen, frame);
  static unsigned picture[width * height];
  b.read(pixels.data(), picture, sizeof picture);
  const unsigned cleared = picture[width / 2], middle = picture[90 * width + 160];
  return cleared == 0xff996633 && middle != cleared && picture[20 * width + 20] == middle ? 0 : 1;
}
