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
/// `std::invalid_argument`, naming `image`, if its size or its channels are not the frame's, or the frame has
/// no colours.
inline void copy_to_array(const FrameView& frame, cudaArray_t array, cudaStream_t stream,
                          const std::string& image) {
  if (!frame.colour.data) throw std::invalid_argument(image + ": the frame has no colours, expected some");
  cudaChannelFormatDesc channels{};
  cudaExtent extent{};
  unsigned flags = 0;
  check_cuda(cudaArrayGetInfo(&channels, &extent, &flags, array), "cudaArrayGetInfo");
  const auto shape = [](std::size_t width, std::size_t height, int count, std::size_t bits) {
    return std::to_string(width) + " x " + std::to_string(height) + " pixels of " + std::to_string(count) +
           " x " + std::to_string(bits) + " bits";
  };
  const std::size_t width = std::size_t(frame.width), height = std::size_t(frame.height);
  const std::size_t bytes = bytes_per_pixel(frame.format);
  const int count = frame.format == PixelFormat::rgb_float ? 3 : 4;
  const std::string expected = shape(width, height, count, 8 * bytes / std::size_t(count));
  const std::string found = shape(extent.width, extent.height,
                                  (channels.x > 0) + (channels.y > 0) + (channels.z > 0) + (channels.w > 0),
                                  std::size_t(channels.x));
  if (found != expected)
    throw std::invalid_argument(image + ": " + found + ", expected those of the frame, " + expected);
  const bool upward = frame.colour.pitch < 0;
  check_cuda(cudaMemcpy2DToArrayAsync(array, 0, 0, upward ? frame.colour.row(height - 1) : frame.colour.data,
                                      std::size_t(upward ? -frame.colour.pitch : frame.colour.pitch),
                                      width * bytes, height, cudaMemcpyDeviceToDevice, stream),
             "cudaMemcpy2DToArrayAsync");
}

}  // namespace swiftgs
