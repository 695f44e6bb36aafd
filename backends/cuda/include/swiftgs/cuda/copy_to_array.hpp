// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include <cuda_runtime_api.h>

#include <swiftgs/cuda/check.hpp>
#include <swiftgs/frame.hpp>

namespace swiftgs {

/// Copies the colours of `frame` to an image of a graphics library, in stream order: rows as they lie in
/// memory, so that a frame with rows from bottom to top fills an image that begins at the bottom. Throws
/// `std::invalid_argument`, naming `image`, if it has another size than the frame or a plane is missing.
inline void copy_to_array(const FrameView& frame, cudaArray_t array, cudaStream_t stream,
                          const std::string& image) {
  if (!frame.colour.data) throw std::invalid_argument(image + ": the frame has no colours, expected some");
  cudaChannelFormatDesc channels{};
  cudaExtent extent{};
  unsigned flags = 0;
  check_cuda(cudaArrayGetInfo(&channels, &extent, &flags, array), "cudaArrayGetInfo");
  const auto size = [](std::size_t width, std::size_t height, std::size_t bytes) {
    return std::to_string(width) + " x " + std::to_string(height) + " pixels of " + std::to_string(bytes) +
           " bytes";
  };
  const std::size_t width = std::size_t(frame.width), height = std::size_t(frame.height);
  const std::size_t bytes = bytes_per_pixel(frame.format);
  const std::string found =
      size(extent.width, extent.height, std::size_t(channels.x + channels.y + channels.z + channels.w) / 8);
  const std::string expected = size(width, height, bytes);
  if (found != expected)
    throw std::invalid_argument(image + ": " + found + ", expected those of the frame, " + expected);
  const bool upward = frame.colour.pitch < 0;
  check_cuda(cudaMemcpy2DToArrayAsync(array, 0, 0, upward ? frame.colour.row(height - 1) : frame.colour.data,
                                      std::size_t(upward ? -frame.colour.pitch : frame.colour.pitch),
                                      width * bytes, height, cudaMemcpyDeviceToDevice, stream),
             "cudaMemcpy2DToArrayAsync");
}

}  // namespace swiftgs
