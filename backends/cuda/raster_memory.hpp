// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <tuple>

#include <swiftgs/cuda/stages.hpp>

namespace swiftgs {

/// What the rasterizers of a backend keep from frame to frame, until `Cuda::trim`.
struct RasterMemory {
  static RasterMemory& of(const Cuda& cuda);

  DeviceBuffer<std::byte> scratch;
  DeviceBuffer<std::uint32_t> order;  ///< of raster blocks
  DeviceBuffer<vec4> colours;         ///< of frames that convert them
  DeviceBuffer<View> views;           ///< whose planes were replaced
  DeviceBuffer<std::uint32_t> word;   ///< one counter of quiet frames, which kernels keep
  /// The word as the host knows it: from the last report that it has awaited, so before that frame was
  /// rasterized. 0 before the first report, and while frames are recorded.
  std::uint32_t known_word = 0;

  /// At least `size` elements of one of them. Zeroed when they are allocated, and not again. Throws if it
  /// must grow while the stream is being captured.
  template <class T>
  static T* at_least(const Cuda& cuda, DeviceBuffer<T>& memory, std::size_t size) {
    if (memory.size() < size) {
      cuda.check_not_captured("rasterize");
      memory.reset(size);
      try {
        cuda.clear(memory.data(), memory.size() * sizeof(T));
      } catch (const DeviceError&) {
        memory.trim();
        throw;
      }
    }
    return memory.data();
  }

  static auto buffers(auto& self) {
    return std::tie(self.scratch, self.order, self.colours, self.views, self.word);
  }
};

}  // namespace swiftgs
