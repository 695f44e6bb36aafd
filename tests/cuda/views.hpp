// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames of several views in the memory of a device.

#include <array>
#include <cstddef>

#include "cuda/device.hpp"
#include "policies/views.hpp"

namespace swiftgs::test {

/// A copy of a frame's memory on the device. `OnHost` is the form of hosts.
class OnDevice {
 public:
  explicit OnDevice(PlanesMemory& memory) : memory_(&memory) {
    for (std::size_t plane = 0; plane < PlanesMemory::planes; ++plane)
      planes_[plane] = to_device(memory.bytes[plane]);
  }

  FrameView frame() {
    return memory_->frame({planes_[0].data(), planes_[1].data(), planes_[2].data(), planes_[3].data()});
  }
  void finish(const Cuda& cuda) {
    for (std::size_t plane = 0; plane < PlanesMemory::planes; ++plane)
      memory_->bytes[plane] = to_host(cuda, std::as_const(planes_[plane]).span());
  }

 private:
  PlanesMemory* memory_;
  std::array<DeviceBuffer<unsigned char>, PlanesMemory::planes> planes_;
};

}  // namespace swiftgs::test
