// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/math.hpp>
#include <swiftgs/span.hpp>

namespace swiftgs {

/// Where a projected Gaussian is and how far it reaches.
///
///     | mean.x mean.y l0 l1 | l2 opacity reach half_width |      32 bytes, two 16-byte loads
///
/// The precision matrix is kept as its Cholesky factor in base-2 units, because every other form of it
/// follows without cancellation: at d = pixel - mean the base-2 exponent is s(d) = (l0 dx + l1 dy)^2 + (l2
/// dy)^2, and alpha = opacity 2^-s. A pixel keeps the splat where s <= reach = log2(opacity / alpha_min).
struct alignas(32) SplatShape {
  vec2 mean{0};       ///< @units{pixels}, the first pixel's centre is (0.5, 0.5)
  float l0 = 0;       ///< > 0 @units{1/pixels}
  float l1 = 0;       ///< @units{1/pixels}
  float l2 = 0;       ///< > 0 @units{1/pixels}
  float opacity = 0;  ///< after anti-aliasing compensation; 0 where the splat is hidden
  float reach = 0;    ///< largest s that is kept; 0 or more for a visible splat, -1 for one hidden on a host
  float half_width = 0;  ///< half the width of the ellipse s = reach @units{pixels}
};

/// What a projected Gaussian contributes.
struct alignas(16) SplatColour {
  vec3 rgb{0};      ///< in the scene's own values, 0 or more
  float depth = 0;  ///< camera-space z, > 0
};

/// Largest variance of a splat, blur included: a Gaussian with a larger one is not drawn. Up to here no
/// product of projection leaves the range of float. @units{pixels^2}
inline constexpr float largest_variance = 1e36f;

/// Stores the colour of a splat, cut below at 0. A Gaussian whose colour is not finite is not drawn: its
/// opacity becomes 0, and the result is false. A host then makes its reach -1, which no pixel is within; a
/// device, whose sort may read the reach meanwhile, sets `SplatsView::hidden`.
SWIFTGS_HD inline bool set_colour(SplatShape& shape, SplatColour& colour, vec3 rgb) {
  const float most = 3.4028234663852886e38f;
  bool finite = true;
  for (int c = 0; c < 3; ++c) {
    finite = finite && rgb[c] >= -most && rgb[c] <= most;
    colour.rgb[c] = rgb[c] > 0 ? rgb[c] : 0.0f;
  }
  if (finite) return true;
  shape.opacity = 0;
  colour.rgb = vec3(0);
  return false;
}

/// Visible splats in the order of their Gaussians; `shapes` and `colours` have one element a splat.
struct SplatsView {
  Span<const SplatShape> shapes;
  Span<const SplatColour> colours;

  /// Not 0 if `set_colour` hid a splat: its opacity is 0, its reach is unchanged.
  /// Null: no splat is hidden.
  const std::uint32_t* hidden = nullptr;

  SWIFTGS_HD std::size_t size() const { return shapes.size; }
};

/// Storage of one frame's splats on backend `B`.
template <class B>
struct Splats {
  typename B::template Buffer<SplatShape> shapes;
  typename B::template Buffer<SplatColour> colours;
  std::size_t count = 0;

  SplatsView view() const { return {.shapes = {shapes.data(), count}, .colours = {colours.data(), count}}; }
  std::size_t bytes() const { return shapes.bytes() + colours.bytes(); }
};

/// Key that orders depths as integers: the bits of a positive float ascend with its value, and its sign bit
/// is zero.
SWIFTGS_HD inline std::uint32_t depth_key(float depth) { return __builtin_bit_cast(std::uint32_t, depth); }
inline constexpr int depth_key_bits = 31;

}  // namespace swiftgs
