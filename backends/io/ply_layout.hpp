// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "ply_header.hpp"

namespace swiftgs::io {

/// A scalar in a row of the vertex element.
struct PlyField {
  PlyType type = PlyType::f32;
  std::size_t offset = 0;  ///< @units{bytes} from the start of the row
};

/// Where the parameters of a Gaussian lie in a row, found by name.
struct PlyLayout {
  std::array<PlyField, 3> mean, scale, colour;
  std::array<PlyField, 4> rotation;
  PlyField opacity;
  std::vector<PlyField> sh_rest;  ///< in the scene's order: a coefficient after another, RGB innermost
  int sh_degree = 0;              ///< of what is kept
  int stored_sh_degree = 0;
  bool has_third_scale = true;
  bool flat = false;          ///< 2D Gaussians: the third scale is 0, whatever the file holds
  bool byte_colour = false;   ///< `colour` holds red, green, blue from 0 to 255, not SH coefficients
  bool all_floats = false;    ///< every field is a 32-bit float
  std::size_t row_bytes = 0;  ///< distance between rows
};

/// The layout of `vertex`. In an ascii file rows are taken to be parsed into an array of doubles first.
/// Throws `FormatError` that names the property which is missing.
PlyLayout find_layout(const Source& source, const PlyElement& vertex, PlyEncoding encoding);

}  // namespace swiftgs::io
