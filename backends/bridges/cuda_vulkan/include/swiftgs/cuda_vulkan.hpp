// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Memory and semaphores of Vulkan for frames of `Cuda`, without a copy to the host. Vulkan exports them as
/// opaque file descriptors (VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT, and of semaphores likewise).
/// A constructor takes ownership of its descriptor, and closes it if it throws.
///
/// Where the stream waits for a semaphore that the same thread signals later, draw by `AnyRenderer::record`:
/// `render_into` waits for the stream, and so for ever.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include <swiftgs/cuda/backend.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/frame/api.hpp>

struct CUexternalMemory_st;
struct CUexternalSemaphore_st;
struct cudaMipmappedArray;

namespace swiftgs::cuda_vulkan {

/// The GPU of a Vulkan device, in CUDA.
class Device {
 public:
  /// By `VkPhysicalDeviceIDProperties::deviceUUID`. Throws `DeviceError` where CUDA has no such device.
  SWIFTGS_API explicit Device(std::span<const std::uint8_t, 16> uuid);

  /// For cudaSetDevice: it is to be the current device of whatever is imported and drawn.
  int number() const { return number_; }

 private:
  int number_ = 0;
};

/// Memory as `vkGetMemoryFdKHR` exports it.
struct ExportedMemory {
  int fd = -1;
  std::size_t bytes = 0;   ///< `VkMemoryAllocateInfo::allocationSize`
  bool dedicated = false;  ///< allocated with `VkMemoryDedicatedAllocateInfo`
};

/// An image that fills its memory: optimal tiling, two dimensions, one level, layer and sample.
struct ImageShape {
  int width = 0, height = 0;
  /// Format of the image's memory: `rgba_8` or `bgra_8` for VK_FORMAT_R8G8B8A8_UNORM, B8G8R8A8_UNORM and
  /// their SRGB, `rgba_half` for R16G16B16A16_SFLOAT, `rgba_float` for R32G32B32A32_SFLOAT.
  PixelFormat format = PixelFormat::rgba_8;
  bool attachment = false;  ///< used with VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT
};

namespace detail {
struct Release {
  SWIFTGS_API void operator()(CUexternalMemory_st* memory) const;
  SWIFTGS_API void operator()(CUexternalSemaphore_st* semaphore) const;
  SWIFTGS_API void operator()(cudaMipmappedArray* image) const;
  SWIFTGS_API void operator()(void* buffer) const;
};
template <class T>
using Owned = std::unique_ptr<T, Release>;
}  // namespace detail

/// Memory of Vulkan's buffers, for planes of frames. Work of streams that use it must be done when it is
/// destroyed, as of all that is imported.
class Buffer {
 public:
  /// Throws `DeviceError` if another device is current, or CUDA cannot import the memory.
  SWIFTGS_API Buffer(const Device& device, const ExportedMemory& memory);

  /// The first byte of the allocation.
  void* data() const { return data_.get(); }

 private:
  detail::Owned<CUexternalMemory_st> memory_;
  detail::Owned<void> data_;
};

/// An image that frames are copied to. CUDA takes no depth: have Vulkan copy it to a buffer.
class Image {
 public:
  /// Throws as `Buffer`, and `InvalidArgument` for a format of three channels.
  SWIFTGS_API Image(const Device& device, const ExportedMemory& memory, const ImageShape& shape);

  /// Copies the colours of `frame`, which lies in memory of the device, in stream order. Rows go as they lie
  /// in memory, and Vulkan's images begin with the top one. Vulkan keeps the contents by the layout
  /// VK_IMAGE_LAYOUT_GENERAL. Throws `InvalidArgument` if sizes or formats differ.
  SWIFTGS_API void write(const FrameView& frame, cudaStream_t stream) const;

 private:
  detail::Owned<CUexternalMemory_st> memory_;
  detail::Owned<cudaMipmappedArray> image_;
  PixelFormat format_;
};

/// A timeline semaphore, as `vkGetSemaphoreFdKHR` exports it.
class Semaphore {
 public:
  /// Throws as `Buffer`.
  SWIFTGS_API Semaphore(const Device& device, int fd);

  /// Later work of `stream` begins when the semaphore has reached `value`.
  SWIFTGS_API void wait(std::uint64_t value, cudaStream_t stream) const;
  /// Sets the semaphore to `value` when the earlier work of `stream` is done.
  SWIFTGS_API void signal(std::uint64_t value, cudaStream_t stream) const;

 private:
  detail::Owned<CUexternalSemaphore_st> semaphore_;
};

}  // namespace swiftgs::cuda_vulkan
