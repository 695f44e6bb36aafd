// SPDX-License-Identifier: Apache-2.0

// Images of the program: colours to and from them, and depths from them.
#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/frame/render_input.hpp>
#include <swiftgs/vulkan/backend.hpp>

#include "commands.hpp"
#include "planes.hpp"

namespace swiftgs {

namespace {

/// Copies pixels of `plane` by one kernel.
void copy_pixels(const Vulkan& b, vulkan::Kernel kernel, VkImageView image, const Plane<void>& plane,
                 const FrameView& frame, const std::vector<std::uint32_t>& constants = {}) {
  if (!image || !plane.data) throw InvalidArgument("vulkan: expected an image and memory for its pixels");
  validate(frame);
  vulkan::check_colours(frame);
  const bool stores = kernel == vulkan::Kernel::store_image;
  const std::uint64_t pitch = std::uint64_t(plane.pitch);
  vulkan::Push push(vulkan::address(plane.data), std::uint32_t(pitch), std::uint32_t(pitch >> 32),
                    std::uint32_t(frame.width), std::uint32_t(frame.height), std::uint32_t(frame.format));
  push.touch(vulkan::pixels_of(plane, frame.height, stores ? vulkan::Access::read : vulkan::Access::written));
  vulkan::Commands commands(b);
  // Views do not tell which image they show, so each copy is ordered as if it were the program's.
  commands.follow_program();
  commands.bind_image(image, stores ? 0 : 1);
  commands.run(kernel, constants, push,
               vulkan::Commands::Shape::of(std::size_t(frame.width) * std::size_t(frame.height)));
  commands.precede_program();
  commands.submit();
}

}  // namespace

void Vulkan::store(const FrameView& frame, VkImageView_T* image) {
  if (!state_->device.state().stores_images)
    throw Unavailable(
        "vulkan: the device was made without shaderStorageImageWriteWithoutFormat, expected it for images");
  copy_pixels(*this, vulkan::Kernel::store_image, image, frame.colour, frame);
}

void Vulkan::load(VkImageView_T* image, const FrameView& frame) {
  copy_pixels(*this, vulkan::Kernel::load_image, image, frame.colour, frame);
}

void Vulkan::load_depth(VkImageView_T* image, float* to, int width, int height) {
  const auto pitch = std::ptrdiff_t(sizeof(float)) * width;
  copy_pixels(*this, vulkan::Kernel::load_image, image, {to, pitch},
              {.width = width, .height = height, .occluder = {to, pitch}}, {VK_TRUE});
}

}  // namespace swiftgs
