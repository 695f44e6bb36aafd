// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_STORE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_STORE_INL
#undef SWIFTGS_CPU_STORE_INL
#else
#define SWIFTGS_CPU_STORE_INL
#endif

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <swiftgs/functor/blend.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/raster/store.hpp>

#include "half-inl.hpp"
#include "raster_block-inl.hpp"
#include "srgb-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// What a row of a raster block shows where transmittance is left: RGBA, an array a channel.
struct alignas(64) Below {
  float channels[4][raster_block_side];
};

/// Of the whole raster block. A frame rendered over an image takes `LoadRow` instead.
HWY_INLINE void LoadBackground(vec3 background, Below& below) {
  for (std::size_t c = 0; c < 4; ++c)
    for (std::size_t i = 0; i < raster_block_side; ++i)
      below.channels[c][i] = c < 3 ? background[int(c)] : 0.0f;
}

/// Of row `y`.
HWY_INLINE void LoadRow(const FrameView& frame, const RasterBlockOfView& block, std::size_t y, Below& below) {
  for (std::size_t i = 0; i < std::size_t(block.columns); ++i) {
    const vec4 colour = detail::load_below(frame, std::size_t(block.x0) + i, y);
    for (std::size_t c = 0; c < 4; ++c) below.channels[c][i] = colour[int(c)];
  }
}

/// Writes a register of pixels in `format`, one behind the other.
HWY_INLINE void StoreColours(PixelFormat format, Vec red, Vec green, Vec blue, Vec alpha,
                             unsigned char* HWY_RESTRICT to) {
  const F32 d;
  switch (format) {
    case PixelFormat::rgb_float:
      hn::StoreInterleaved3(red, green, blue, d, reinterpret_cast<float*>(to));
      return;
    case PixelFormat::rgba_float:
      hn::StoreInterleaved4(red, green, blue, alpha, d, reinterpret_cast<float*>(to));
      return;
    case PixelFormat::rgba_half:
      hn::StoreInterleaved4(ToHalf(red), ToHalf(green), ToHalf(blue), ToHalf(alpha), U16(),
                            reinterpret_cast<std::uint16_t*>(to));
      return;
    case PixelFormat::bgra_8:
      std::swap(red, blue);
      [[fallthrough]];
    case PixelFormat::rgba_8: {
      // As `to_unorm8`; every processor that has these kernels stores the low byte first.
      const hn::RebindToSigned<F32> di;
      const auto steps = [&](Vec v) HWY_ATTR {
        const Vec cut = hn::IfThenElseZero(hn::Gt(v, hn::Zero(d)), hn::Min(v, hn::Set(d, 1.0f)));
        const auto twice = hn::ConvertTo(di, hn::Mul(cut, hn::Set(d, 510.0f)));
        return hn::ShiftRight<1>(hn::Add(twice, hn::Set(di, 1)));
      };
      const auto pixels = hn::Or(hn::Or(steps(red), hn::ShiftLeft<8>(steps(green))),
                                 hn::Or(hn::ShiftLeft<16>(steps(blue)), hn::ShiftLeft<24>(steps(alpha))));
      hn::StoreU(pixels, di, reinterpret_cast<std::int32_t*>(to));
    }
  }
}

/// Copies `bytes`, a multiple of 4, past the caches where `to` is aligned to 16: a frame is larger than
/// these, and an ordinary store first reads the line that it replaces.
HWY_INLINE void StreamWords(void* to, const void* from, std::size_t bytes) {
  const hn::CappedTag<std::uint8_t, 16> d;
  auto* const out = static_cast<std::uint8_t*>(to);
  const auto* const in = static_cast<const std::uint8_t*>(from);
  std::size_t i = 0;
  if (reinterpret_cast<std::uintptr_t>(to) % 16 == 0)
    for (; i + 16 <= bytes; i += 16) hn::Stream(hn::LoadU(d, in + i), d, out + i);
  for (; i < bytes; i += 4) std::memcpy(out + i, in + i, 4);
}

/// Where the colours of a raster block's row lie; null where the frame has none.
HWY_INLINE unsigned char* ColoursOfRow(const FrameView& frame, const RasterBlockOfView& block,
                                       std::size_t row) {
  if (!frame.colour.data) return nullptr;
  auto* const whole = static_cast<unsigned char*>(frame.colour.row(std::size_t(block.y0) + row));
  return whole + std::size_t(block.x0) * bytes_per_pixel(frame.format);
}

/// Asks for the memory of the pixels' colours, so that the processor has it when they are written: 2 % faster
/// than to write them past the caches.
HWY_INLINE void PrefetchPixels(const FrameView& frame, const RasterBlockOfView& block) {
  const std::size_t bytes = std::size_t(block.columns) * bytes_per_pixel(frame.format);
  for (std::size_t row = 0; row < std::size_t(block.rows); ++row)
    if (const unsigned char* to = ColoursOfRow(frame, block, row))
      for (std::size_t at = 0; at < bytes; at += 64) hwy::Prefetch(to + at);
}

/// Writes the outputs that are asked for, as `store_pixel` does. Turns `state` into rows.
template <class Groups>
HWY_INLINE void StoreRasterBlock(const View& view, const RasterBlockOfView& block, RasterBlockState& state) {
  const F32 d;
  const FrameView& frame = view.frame;
  const std::size_t pixel = bytes_per_pixel(frame.format), columns = std::size_t(block.columns);
  const bool whole = columns == raster_block_side;  // whole rows go to the frame, others by way of an array
  const bool whole_picture = detail::is_whole_picture(frame, view.background);
  Below below;
  LoadBackground(view.background, below);
  for (Plane* plane : {&state.transmittance, &state.red, &state.green, &state.blue}) Groups::ToRows(*plane);
  if (frame.depth.data) Groups::ToRows(state.depth);
  for (std::size_t row = 0; row < std::size_t(block.rows); ++row) {
    alignas(64) unsigned char colours[4 * sizeof(float) * raster_block_side];
    alignas(64) float alphas[raster_block_side], depths[raster_block_side];
    const std::size_t y = std::size_t(block.y0) + row;
    unsigned char* const to = ColoursOfRow(frame, block, row);
    unsigned char* const by = whole && to ? to : colours;
    if (frame.over) LoadRow(frame, block, y, below);
    for (std::size_t column = 0; column < raster_block_side; column += lanes) {
      const Vec transmittance = hn::Abs(hn::Load(d, state.transmittance[row] + column));
      const Vec alpha = hn::Sub(hn::Set(d, 1.0f), transmittance);
      const auto laid = [&](Vec colour, std::size_t channel) HWY_ATTR {
        return hn::MulAdd(transmittance, hn::Load(d, below.channels[channel] + column), colour);
      };
      Vec red = laid(hn::Load(d, state.red[row] + column), 0);
      Vec green = laid(hn::Load(d, state.green[row] + column), 1);
      Vec blue = laid(hn::Load(d, state.blue[row] + column), 2);
      const Vec opacity = laid(alpha, 3);
      if (HWY_UNLIKELY(frame.conversion != Conversion::as_is)) {
        const Vec by_alpha = whole_picture ? hn::Set(d, 1.0f) : opacity;
        for (Vec* channel : {&red, &green, &blue})
          *channel = ConvertChannel(*channel, by_alpha, frame.conversion == Conversion::linear_to_srgb);
      }
      StoreColours(frame.format, red, green, blue, opacity, by + pixel * column);
      hn::Store(alpha, d, alphas + column);
      if (frame.depth.data) {
        const Vec mean = hn::Div(hn::Load(d, state.depth[row] + column), alpha);
        hn::Store(hn::IfThenElseZero(hn::Gt(alpha, hn::Zero(d)), mean), d, depths + column);
      }
    }
    if (to && !whole) StreamWords(to, colours, columns * pixel);
    if (frame.alpha.data) StreamWords(frame.alpha.row(y) + block.x0, alphas, columns * sizeof(float));
    if (frame.depth.data) StreamWords(frame.depth.row(y) + block.x0, depths, columns * sizeof(float));
  }
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
