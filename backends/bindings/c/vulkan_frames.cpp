// SPDX-License-Identifier: Apache-2.0

// Frames of `Vulkan` in the memory of the host, and arrays from there.
#include <cstddef>
#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/vulkan.hpp>

#include "device_frames.hpp"

namespace swiftgs::c {
namespace {

/// Copies by a backend of its own, behind what the renderer submitted to the queue of the library's device.
class VulkanCopies {
 public:
  template <class T>
  using Buffer = VulkanBuffer<T>;

  explicit VulkanCopies(const BackendOptions& options)
      : backend_(swiftgs::make_backend(std::type_identity<Vulkan>(), options)) {}

  void upload(const CopiedPlane& plane) {
    dense_.resize(plane.row * plane.height);
    for (std::size_t y = 0; y < plane.height; ++y)
      std::memcpy(dense_.data() + y * plane.row, plane.host + y * plane.pitch, plane.row);
    backend_.write(dense_.data(), plane.device, dense_.size());
  }
  void download(const CopiedPlane& plane) {
    dense_.resize(plane.row * plane.height);
    backend_.read(plane.device, dense_.data(), dense_.size());
    for (std::size_t y = 0; y < plane.height; ++y)
      std::memcpy(plane.host + y * plane.pitch, dense_.data() + y * plane.row, plane.row);
  }

 private:
  Vulkan backend_;
  std::vector<std::byte> dense_;
};

}  // namespace

std::unique_ptr<HostFrames> make_vulkan_frames(const BackendOptions& options) {
  return std::make_unique<DeviceFrames<VulkanCopies>>(options);
}

void update_vulkan_scene(AnyRenderer& renderer, std::size_t scene, std::size_t first, SceneArrays arrays) {
  std::vector<VulkanBuffer<float>> copies;
  const auto copy = [&](const char* name, std::size_t width, FloatArray& array) {
    if (!array.data || arrays.count == 0 || width == 0) return;
    swiftgs::detail::validate_array(name, width, array, arrays.count);
    const std::size_t stride = array.stride != 0 ? std::size_t(array.stride) / sizeof(float) : width;
    VulkanBuffer<float>& there = copies.emplace_back();
    there.reset((arrays.count - 1) * stride + width);
    Vulkan().write(array.data, there.data(), there.size() * sizeof(float));
    array.data = there.data();
  };
  swiftgs::detail::validate_shape(arrays);
  for_each_array(copy, arrays);
  renderer.update_scene(scene, first, arrays);
}

}  // namespace swiftgs::c
