// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include <cuda_runtime_api.h>
#include <unistd.h>

#include <swiftgs/cuda/check.hpp>
#include <swiftgs/cuda_vulkan.hpp>
#include <swiftgs/error.hpp>

#include "copy_to_array.hpp"

namespace swiftgs::cuda_vulkan {

namespace {

/// Closes a file descriptor unless CUDA took it.
struct Descriptor {
  explicit Descriptor(int number) : fd(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd >= 0) close(fd);
  }
  int fd;
};

void require_current(const Device& device, const std::string& caller) {
  int current = 0;
  check_cuda(cudaGetDevice(&current), "cudaGetDevice");
  if (current != device.number())
    throw DeviceError(caller, "the current CUDA device is " + std::to_string(current) + ", expected " +
                                  std::to_string(device.number()) + ", the GPU of the Vulkan device");
}

detail::Owned<CUexternalMemory_st> import_memory(const Device& device, const ExportedMemory& exported,
                                                 const std::string& caller) {
  Descriptor descriptor(exported.fd);
  require_current(device, caller);
  cudaExternalMemoryHandleDesc from{};
  from.type = cudaExternalMemoryHandleTypeOpaqueFd;
  from.handle.fd = exported.fd;
  from.size = exported.bytes;
  from.flags = exported.dedicated ? cudaExternalMemoryDedicated : 0;
  cudaExternalMemory_t imported = nullptr;
  check_cuda(cudaImportExternalMemory(&imported, &from), (caller + ": cudaImportExternalMemory").c_str());
  descriptor.fd = -1;
  return detail::Owned<CUexternalMemory_st>(imported);
}

std::string text_of(const void* uuid) {
  std::string text;
  for (int i = 0; i < 16; ++i) {
    const unsigned byte = static_cast<const unsigned char*>(uuid)[i];
    for (const unsigned digit : {byte / 16, byte % 16}) text += "0123456789abcdef"[digit];
  }
  return text;
}

cudaChannelFormatDesc channels_of(PixelFormat format) {
  const auto four = [](int bits, cudaChannelFormatKind kind) {
    return cudaCreateChannelDesc(bits, bits, bits, bits, kind);
  };
  switch (format) {
    case PixelFormat::rgba_float:
      return four(32, cudaChannelFormatKindFloat);
    case PixelFormat::rgba_half:
      return four(16, cudaChannelFormatKindFloat);
    case PixelFormat::rgba_8:
    case PixelFormat::bgra_8:
      return four(8, cudaChannelFormatKindUnsigned);
    case PixelFormat::rgb_float:
      break;
  }
  throw InvalidArgument("cuda_vulkan::Image: the format has three channels, expected four");
}

}  // namespace

Device::Device(std::span<const std::uint8_t, 16> uuid) {
  int count = 0;
  check_cuda(cudaGetDeviceCount(&count), "cuda_vulkan::Device: cudaGetDeviceCount");
  std::string known;
  for (; number_ < count; ++number_) {
    cudaDeviceProp device{};
    check_cuda(cudaGetDeviceProperties(&device, number_), "cudaGetDeviceProperties");
    if (std::equal(uuid.begin(), uuid.end(), reinterpret_cast<const unsigned char*>(device.uuid.bytes)))
      return;
    known += (number_ == 0 ? "" : ", ") + text_of(device.uuid.bytes) + " (" + device.name + ")";
  }
  throw DeviceError("cuda_vulkan::Device",
                    "no device of CUDA has the UUID " + text_of(uuid.data()) + ", expected " + known);
}

void detail::Release::operator()(CUexternalMemory_st* memory) const { cudaDestroyExternalMemory(memory); }
void detail::Release::operator()(CUexternalSemaphore_st* semaphore) const {
  cudaDestroyExternalSemaphore(semaphore);
}
void detail::Release::operator()(cudaMipmappedArray* image) const { cudaFreeMipmappedArray(image); }
void detail::Release::operator()(void* buffer) const { cudaFree(buffer); }

Buffer::Buffer(const Device& device, const ExportedMemory& memory)
    : memory_(import_memory(device, memory, "cuda_vulkan::Buffer")) {
  cudaExternalMemoryBufferDesc whole{};
  whole.size = memory.bytes;
  void* mapped = nullptr;
  check_cuda(cudaExternalMemoryGetMappedBuffer(&mapped, memory_.get(), &whole),
             "cuda_vulkan::Buffer: cudaExternalMemoryGetMappedBuffer");
  data_.reset(mapped);
}

Image::Image(const Device& device, const ExportedMemory& memory, const ImageShape& shape)
    : memory_(import_memory(device, memory, "cuda_vulkan::Image")), format_(shape.format) {
  cudaExternalMemoryMipmappedArrayDesc levels{};
  levels.formatDesc = channels_of(shape.format);
  levels.extent = {std::size_t(shape.width), std::size_t(shape.height), 0};
  levels.flags = shape.attachment ? cudaArrayColorAttachment : cudaArrayDefault;
  levels.numLevels = 1;
  cudaMipmappedArray_t mapped = nullptr;
  check_cuda(cudaExternalMemoryGetMappedMipmappedArray(&mapped, memory_.get(), &levels),
             "cuda_vulkan::Image: cudaExternalMemoryGetMappedMipmappedArray");
  image_.reset(mapped);
}

void Image::write(const FrameView& frame, cudaStream_t stream) const {
  cudaArray_t level = nullptr;
  check_cuda(cudaGetMipmappedArrayLevel(&level, image_.get(), 0), "cudaGetMipmappedArrayLevel");
  copy_to_array(frame, level, format_, stream, "cuda_vulkan::Image");
}

Semaphore::Semaphore(const Device& device, int fd) {
  Descriptor descriptor(fd);
  require_current(device, "cuda_vulkan::Semaphore");
  cudaExternalSemaphoreHandleDesc from{};
  from.type = cudaExternalSemaphoreHandleTypeTimelineSemaphoreFd;
  from.handle.fd = fd;
  cudaExternalSemaphore_t imported = nullptr;
  check_cuda(cudaImportExternalSemaphore(&imported, &from),
             "cuda_vulkan::Semaphore: cudaImportExternalSemaphore");
  descriptor.fd = -1;
  semaphore_.reset(imported);
}

void Semaphore::wait(std::uint64_t value, cudaStream_t stream) const {
  const cudaExternalSemaphore_t semaphore = semaphore_.get();
  cudaExternalSemaphoreWaitParams reached{};
  reached.params.fence.value = value;
  check_cuda(cudaWaitExternalSemaphoresAsync(&semaphore, &reached, 1, stream),
             "cudaWaitExternalSemaphoresAsync");
}

void Semaphore::signal(std::uint64_t value, cudaStream_t stream) const {
  const cudaExternalSemaphore_t semaphore = semaphore_.get();
  cudaExternalSemaphoreSignalParams reached{};
  reached.params.fence.value = value;
  check_cuda(cudaSignalExternalSemaphoresAsync(&semaphore, &reached, 1, stream),
             "cudaSignalExternalSemaphoresAsync");
}

}  // namespace swiftgs::cuda_vulkan
