// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

#include <swiftgs/math.hpp>

/// @file
/// Frames, and where a backend writes them. Colours of a frame are in the scene's own values: those of the
/// photographs that it was trained with, usually the sRGB-encoded ones that a display is sent. Nothing
/// converts them. An image whose memory holds encoded values, such as R8G8B8A8_SRGB, takes them as they are.
/// A shader that writes them to an sRGB framebuffer decodes them to linear light first, as the hardware
/// encodes once more; so does one that adds them to linear light. Splats are blended in the scene's values,
/// so what lies below them (`FrameView::over`) is to be in the same.

namespace swiftgs {

/// A rendered image on the host, rows from top to bottom. What was not asked for is empty.
struct Frame {
  int width = 0, height = 0;
  std::vector<float> colour;  ///< @shape{height, width, 3} RGB in the scene's own values, not clamped above
  std::vector<float> alpha;   ///< @shape{height, width} 1 - transmittance
  std::vector<float>
      depth;  ///< @shape{height, width} mean camera-space z, weighted by contribution; 0 where alpha is 0

  std::size_t pixels() const { return std::size_t(width) * height; }
};

/// How the colours of a frame lie in memory, interleaved. RGBA holds in its last channel what covers the
/// pixel, and colours that are already multiplied by it.
enum class PixelFormat {
  rgb_float,   ///< 12 bytes
  rgba_float,  ///< 16 bytes
  rgba_half,   ///< 8 bytes, IEEE half
  rgba_8,      ///< 4 bytes; cut to [0, 1] and rounded to the nearest of 255 steps
};

/// @units{bytes}
SWIFTGS_HD constexpr std::size_t bytes_per_pixel(PixelFormat format) {
  switch (format) {
    case PixelFormat::rgb_float:
      return 12;
    case PixelFormat::rgba_float:
      return 16;
    case PixelFormat::rgba_half:
      return 8;
    case PixelFormat::rgba_8:
      break;
  }
  return 4;
}

/// One plane of a frame in the caller's memory. A null pointer is a plane that there is none of.
template <class T>
struct Plane {
  T* data = nullptr;
  std::size_t pitch = 0;  ///< distance between rows @units{bytes}

  /// Row y from the top.
  SWIFTGS_HD T* row(std::size_t y) const {
    using Byte = std::conditional_t<std::is_const_v<T>, const unsigned char, unsigned char>;
    return reinterpret_cast<T*>(reinterpret_cast<Byte*>(data) + y * pitch);
  }
};

/// Where a backend writes a frame: the caller's memory, reachable by that backend, rows from top to bottom.
/// What is not pointed to is not computed.
struct FrameView {
  int width = 0, height = 0;
  Plane<void> colour{};  ///< of `format`
  PixelFormat format = PixelFormat::rgb_float;
  Plane<float> alpha{};  ///< 1 - transmittance
  Plane<float> depth{};  ///< as `Frame::depth`

  /// The caller's own depth buffer, camera-space z: a splat at a pixel's `occluder` or behind is not blended.
  /// Infinity where nothing stands.
  Plane<const float> occluder{};

  /// Show what `colour` holds, instead of the background, where transmittance is left.
  bool over = false;
};

/// Outputs beside colour.
struct Outputs {
  bool alpha = false;
  bool depth = false;
};

/// Gives `frame` the size and the arrays that are asked for, and views them. Keeps memory that is already
/// there.
inline FrameView prepare(Frame& frame, int width, int height, Outputs outputs) {
  frame.width = width, frame.height = height;
  frame.colour.resize(3 * frame.pixels());
  frame.alpha.resize(outputs.alpha ? frame.pixels() : 0);
  frame.depth.resize(outputs.depth ? frame.pixels() : 0);
  return {.width = width,
          .height = height,
          .colour = {frame.colour.data(), 3 * sizeof(float) * std::size_t(width)},
          .alpha = {outputs.alpha ? frame.alpha.data() : nullptr, sizeof(float) * std::size_t(width)},
          .depth = {outputs.depth ? frame.depth.data() : nullptr, sizeof(float) * std::size_t(width)}};
}

}  // namespace swiftgs
