// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_DRAW_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_DRAW_INL
#undef SWIFTGS_CPU_DRAW_INL
#else
#define SWIFTGS_CPU_DRAW_INL
#endif

/// @file
/// What all rasterizers do with a raster block and with evaluated splats. Defined in draw.cpp alone: no
/// exponent matters here, and each copy takes long to compile.

#include <swiftgs/frame/raster.hpp>
#include <swiftgs/functor/blend.hpp>

#include "batch-inl.hpp"
#include "pick-inl.hpp"
#include "raster_block-inl.hpp"
#include "ray-inl.hpp"
#include "sum-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// What a raster block holds beside colours and depths. Null means not wanted.
struct PlaneStates {
  PickState* picks;
  AttributeState* sums;
  RayState* rays;  ///< of views whose occluder hides splats by their depths along the ray
};

/// Blends evaluated splats, picks them and sums their attributes.
using DrawFunction = void (*)(const RasterJob&, const Batch&, const BlendRules&, Evaluated&,
                              RasterBlockState&, const PlaneStates&, RasterCounts&);
DrawFunction DrawFunctionOf(Blending blending);

/// Sets a raster block to transparent black.
template <class Groups>
void Begin(const RasterJob& job, const RasterBlockOfView& block, Blending blending, RasterBlockState& state,
           const PlaneStates& planes);
/// Writes all planes of a raster block. Leaves its states unspecified.
template <class Groups>
void End(const RasterJob& job, const RasterBlockOfView& block, RasterBlockState& state,
         const PlaneStates& planes);

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
