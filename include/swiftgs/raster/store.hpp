// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Stores colour, alpha and depth of a blended pixel.

#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/half.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/srgb.hpp>

namespace swiftgs {

/// Result of blending in a pixel.
struct BlendedPixel {
  vec3 colour{0};           ///< sum of colours, each times its weight
  float transmittance = 1;  ///< part of the light that all splats let through
  float depth = 0;          ///< sum of depths, each times its weight
};

/// Channel in 8 bits: cut and rounded to the nearest step; NaN becomes 0. It counts half
/// steps, so that only a product rounds, which no compiler can contract into another operation.
SWIFTGS_HD inline std::uint8_t to_unorm8(float value) {
  return value > 0 ? std::uint8_t((int((value < 1 ? value : 1.0f) * 510.0f) + 1) >> 1) : std::uint8_t(0);
}

namespace detail {
/// Channel of 8-bit formats that holds red; 2 minus it holds blue.
SWIFTGS_HD constexpr int red_of(PixelFormat format) { return format == PixelFormat::bgra_8 ? 2 : 0; }

SWIFTGS_HD inline vec4 load_colour(const FrameView& frame, std::size_t x, std::size_t y) {
  const void* row = frame.colour.row(y);
  switch (frame.format) {
    case PixelFormat::rgb_float: {
      const float* p = static_cast<const float*>(row) + 3 * x;
      return vec4(p[0], p[1], p[2], 1);
    }
    case PixelFormat::rgba_float: {
      const float* p = static_cast<const float*>(row) + 4 * x;
      return vec4(p[0], p[1], p[2], p[3]);
    }
    case PixelFormat::rgba_half: {
      const Half* p = static_cast<const Half*>(row) + 4 * x;
      return vec4(to_float(p[0]), to_float(p[1]), to_float(p[2]), to_float(p[3]));
    }
    case PixelFormat::rgba_8:
    case PixelFormat::bgra_8:
      break;
  }
  const std::uint8_t* p = static_cast<const std::uint8_t*>(row) + 4 * x;
  const int red = red_of(frame.format);
  return vec4(p[red], p[1], p[2 - red], p[3]) * (1.0f / 255);
}

SWIFTGS_HD inline void store_colour(const FrameView& frame, std::size_t x, std::size_t y, vec4 colour) {
  void* row = frame.colour.row(y);
  switch (frame.format) {
    case PixelFormat::rgb_float:
      for (int c = 0; c < 3; ++c) static_cast<float*>(row)[3 * x + std::size_t(c)] = colour[c];
      return;
    case PixelFormat::rgba_float:
      for (int c = 0; c < 4; ++c) static_cast<float*>(row)[4 * x + std::size_t(c)] = colour[c];
      return;
    case PixelFormat::rgba_half:
      for (int c = 0; c < 4; ++c) static_cast<Half*>(row)[4 * x + std::size_t(c)] = to_half(colour[c]);
      return;
    case PixelFormat::rgba_8:
    case PixelFormat::bgra_8:
      break;
  }
  std::uint8_t* p = static_cast<std::uint8_t*>(row) + 4 * x;
  const int red = red_of(frame.format);
  p[red] = to_unorm8(colour.x), p[1] = to_unorm8(colour.y);
  p[2 - red] = to_unorm8(colour.z), p[3] = to_unorm8(colour.w);
}
/// A channel multiplied by `alpha`, whose straight colour goes through a curve.
SWIFTGS_HD inline float convert_channel(float channel, float alpha, bool encode) {
  const float straight = channel / alpha;
  const float converted = (encode ? to_srgb(straight) : from_srgb(straight)) * alpha;
  return alpha > 0 ? converted : 0.0f;
}

/// Premultiplied colours of the scene's values as `frame` holds them, or the other way `back`.
SWIFTGS_HD inline vec4 convert(const FrameView& frame, vec4 colour, float alpha, bool back) {
  const bool encode = (frame.conversion == Conversion::linear_to_srgb) != back;
  for (int c = 0; c < 3; ++c) colour[c] = convert_channel(colour[c], alpha, encode);
  return colour;
}

/// Pixel of the image that a frame with `over` draws on, in the scene's values.
SWIFTGS_HD inline vec4 load_below(const FrameView& frame, std::size_t x, std::size_t y) {
  const vec4 colour = load_colour(frame, x, y);
  return frame.conversion == Conversion::as_is ? colour : convert(frame, colour, colour.w, true);
}

/// Whether colours of `frame` are not multiplied by its alpha.
SWIFTGS_HD inline bool is_whole_picture(const FrameView& frame, vec3 background) {
  return frame.format == PixelFormat::rgb_float || (!frame.over && background != vec3(0));
}

/// Lays splats, RGB and alpha, on what `frame` shows below them, and converts colours.
SWIFTGS_HD inline vec4 lay_and_convert(const FrameView& frame, std::size_t x, std::size_t y, vec4 splats,
                                       float transmittance, vec3 background) {
  const vec4 below = frame.over ? load_below(frame, x, y) : vec4(background, 0);
  const vec4 laid = splats + transmittance * below;
  return convert(frame, laid, is_whole_picture(frame, background) ? 1.0f : laid.w, false);
}
}  // namespace detail

/// Writes the planes of `frame` at column x of row y. A device converts no colours here, where kernels of all
/// frames would spill registers: see `redirect_colours` of `Cuda`.
SWIFTGS_HD inline void store_pixel(const FrameView& frame, std::size_t x, std::size_t y,
                                   const BlendedPixel& pixel, vec3 background) {
#if defined(__CUDA_ARCH__)
  constexpr bool converts = false;
#else
  const bool converts = frame.conversion != Conversion::as_is;
#endif
  const float alpha = 1 - pixel.transmittance;
  if (frame.colour.data) {
    const vec4 splats(pixel.colour, alpha);
    if (converts) {
      detail::store_colour(frame, x, y,
                           detail::lay_and_convert(frame, x, y, splats, pixel.transmittance, background));
    } else {
      const vec4 below = frame.over ? detail::load_colour(frame, x, y) : vec4(background, 0);
      detail::store_colour(frame, x, y, splats + pixel.transmittance * below);
    }
  }
  if (frame.alpha.data) frame.alpha.row(y)[x] = alpha;
  if (frame.depth.data) frame.depth.row(y)[x] = alpha > 0 ? pixel.depth / alpha : 0.0f;
}

}  // namespace swiftgs
