// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How exact a frame can be in float: the float64 reference, how far the rounding of the scene itself moves
/// each of its values, and how far a value may jump where a decision stands on the edge.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/reference.hpp>

namespace swiftgs {

/// How a rasterizer works out the exponent s of a splat.
enum class ExponentRepresentation {
  factor,       ///< a sum of two squares from the factor: `PerPixel`, `FloatCholesky`
  float_split,  ///< three terms that may cancel, in float: `FloatSplit`
  half_split,   ///< the same, stored as half, skipped where rounding makes it negative: `HalfSplit`
};

inline constexpr std::size_t exponent_representations = 3;

/// The representation of the rasterizer called `name`, as in a renderer's name.
inline ExponentRepresentation exponent_representation_named(std::string_view name) {
  if (name.find("half-split") != std::string_view::npos) return ExponentRepresentation::half_split;
  if (name.find("float-split") != std::string_view::npos) return ExponentRepresentation::float_split;
  return ExponentRepresentation::factor;
}

/// The reference and what may be asked of a float renderer that draws the same.
struct ConditionedFrame {
  ReferenceFrame frame;                                     ///< without counts
  std::vector<double> colour_move, alpha_move, depth_move;  ///< as in `frame`: largest move in the trials

  /// @shape{height, width} Ambiguous weight for each exponent representation: of splats whose test may go
  /// either way, of what lies behind a stop that may come a splat earlier or later, and of alphas as far as
  /// the representation may err. 0 in pixels that are not ambiguous.
  std::array<std::vector<double>, exponent_representations> ambiguous;

  double colour_span = 0;  ///< largest difference of two colours, background included
  double peak = 0;         ///< largest magnitude in `frame.colour`
  double depth_span = 0;   ///< largest depth
};

/// Renders placed scenes as `render_reference` does, six more times with every float of them moved by up to a
/// unit in its last place, and finds where decisions are ambiguous. Clips decide of the means as they are.
/// What moves is decided by `seed` alone.
/// Throws `InvalidArgument` as `render_reference` does, and where `conventions` are not valid or
/// measure depth along the ray.
SWIFTGS_API ConditionedFrame render_conditioned(Span<const ReferenceScene> scenes, const Camera& camera,
                                                const Conventions& conventions, dvec3 background = dvec3(0),
                                                std::uint64_t seed = 1, int threads = 0,
                                                Span<const float> occluder = {});
/// The same of a scene alone, where it stands by itself.
inline ConditionedFrame render_conditioned(const Scene& scene, const Camera& camera,
                                           const Conventions& conventions, dvec3 background = dvec3(0),
                                           std::uint64_t seed = 1, int threads = 0,
                                           Span<const float> occluder = {}) {
  const ReferenceScene alone{scene};
  return render_conditioned({&alone, 1}, camera, conventions, background, seed, threads, occluder);
}

}  // namespace swiftgs
