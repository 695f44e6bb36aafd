// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_SQUARE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_SQUARE_INL
#undef SWIFTGS_CPU_SQUARE_INL
#else
#define SWIFTGS_CPU_SQUARE_INL
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

#include <swiftgs/frame.hpp>
#include <swiftgs/raster/raster.hpp>

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A row of a square is 16 lanes: one register with AVX-512, two with AVX2, four with SSE4 or NEON.
using F32 = hn::CappedTag<float, square_side>;
using Vec = hn::Vec<F32>;
using Mask = hn::Mask<F32>;
constexpr std::size_t lanes = hn::MaxLanes(F32());
constexpr std::size_t parts = square_side / lanes;

/// Running state of a square's pixels, one array a quantity. A pixel that has stopped has the negative of its
/// transmittance: any splat would bring that below the limit, so it stays stopped without a mask of its own.
struct alignas(64) SquareState {
  float transmittance[square_side][square_side];
  float red[square_side][square_side], green[square_side][square_side], blue[square_side][square_side];
  float depth[square_side][square_side];
  float occluder[square_side][square_side];
};

/// Transparent black, with the pixels beyond the image's right border already stopped.
template <bool kDepth, bool kOccluder>
HWY_INLINE void Clear(const FrameView& frame, const PlacedSquare& square, SquareState& state) {
  const F32 d;
  for (std::size_t row = 0; row < square_side; ++row)
    for (std::size_t part = 0; part < parts; ++part) {
      const std::size_t column = part * lanes;
      const Mask inside = hn::Lt(hn::Iota(d, float(column)), hn::Set(d, float(square.columns)));
      hn::Store(hn::IfThenElse(inside, hn::Set(d, 1.0f), hn::Set(d, -1.0f)), d,
                state.transmittance[row] + column);
      hn::Store(hn::Zero(d), d, state.red[row] + column);
      hn::Store(hn::Zero(d), d, state.green[row] + column);
      hn::Store(hn::Zero(d), d, state.blue[row] + column);
      if constexpr (kDepth) hn::Store(hn::Zero(d), d, state.depth[row] + column);
      if constexpr (kOccluder) hn::Store(hn::Inf(d), d, state.occluder[row] + column);
    }
  if (kOccluder && frame.occluder.data)
    for (std::size_t row = 0; row < std::size_t(square.rows); ++row)
      std::memcpy(state.occluder[row], frame.occluder.row(std::size_t(square.y0) + row) + square.x0,
                  std::size_t(square.columns) * sizeof(float));
}

/// Bits of the rows that still have a live pixel.
HWY_INLINE std::uint32_t LiveRows(const PlacedSquare& square, const SquareState& state) {
  const F32 d;
  std::uint32_t rows = 0;
  for (int row = 0; row < square.rows; ++row)
    for (std::size_t part = 0; part < parts; ++part)
      if (!hn::AllTrue(d, hn::Lt(hn::Load(d, state.transmittance[row] + part * lanes), hn::Zero(d))))
        rows |= 1u << row;
  return rows;
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
