// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

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

}  // namespace swiftgs
