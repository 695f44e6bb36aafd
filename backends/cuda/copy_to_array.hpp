// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include <cuda_runtime_api.h>

#include <swiftgs/cuda/check.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame.hpp>

namespace swiftgs {

inline const char* name_of(PixelFormat format) {
  switch (format) {
    case PixelFormat::rgb_float:
      return "rgb_float";
    case PixelFormat::rgba_float:
      return "rgba_float";
    case PixelFormat::rgba_half:
      return "rgba_half";
    case PixelFormat::rgba_8:
      return "rgba_8";
    case PixelFormat::bgra_8:
      break;
  }
  return "bgra_8";
}

/// Copies the colours of `frame` to an image of a graphics library, in stream order: rows as they lie in
/// memory, so that a frame with rows from bottom to top fills an image that begins at the bottom. Throws
/// `InvalidArgument`, naming `image`, if its size or `format` is not the frame's, or the frame has no
/// colours.
inline void copy_to_array(const FrameView& frame, cudaArray_t array, PixelFormat format, cudaStream_t stream,
                          const std::string& image) {
  if (!frame.colour.data) detail::refuse(image, ": the frame has no colours, expected some");
  cudaExtent extent{};
  check_cuda(cudaArrayGetInfo(nullptr, &extent, nullptr, array), "cudaArrayGetInfo");
  const std::size_t width = std::size_t(frame.width), height = std::size_t(frame.height);
  if (extent.width != width || extent.height != height || format != frame.format) {
    const auto shape = [](std::size_t columns, std::size_t rows, PixelFormat of) {
      return std::to_string(columns) + " x " + std::to_string(rows) + " pixels of " + name_of(of);
    };
    detail::refuse(image, ": ", shape(extent.width, extent.height, format), ", expected those of the frame, ",
                   shape(width, height, frame.format));
  }
  const bool upward = frame.colour.pitch < 0;
  check_cuda(
      cudaMemcpy2DToArrayAsync(array, 0, 0, upward ? frame.colour.row(height - 1) : frame.colour.data,
                               std::size_t(upward ? -frame.colour.pitch : frame.colour.pitch),
                               width * bytes_per_pixel(format), height, cudaMemcpyDeviceToDevice, stream),
      "cudaMemcpy2DToArrayAsync");
}

}  // namespace swiftgs
