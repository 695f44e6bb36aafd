// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "ply_fields.hpp"

namespace swiftgs::io {

/// Where the parameters of a Gaussian lie in a row, found by name.
struct PlyLayout {
  std::array<PlyField, 3> mean, scale, colour;
  std::array<PlyField, 4> rotation;
  PlyField opacity;
  std::optional<PlyField> filter;  ///< `filter_3D` of Mip-Splatting: a standard deviation
  PlySh sh;
  bool has_third_scale = true;
  bool flat = false;                  ///< 2D Gaussians: the third scale is 0, whatever the file holds
  bool byte_colour = false;           ///< `colour` holds red, green, blue from 0 to 255, not SH coefficients
  bool all_floats = false;            ///< every field is a 32-bit float
  std::size_t row_bytes = 0;          ///< distance between rows
  std::vector<std::string> unread{};  ///< other properties

  /// Whether a float may not hold the means as they are stored.
  bool wide_means() const;
};

/// The layout of `vertex`. In an ascii file rows are taken to be parsed into an array of doubles first.
/// Throws `FormatError` with the name of the missing property, or the properties of a point cloud.
PlyLayout find_layout(const Source& source, const PlyElement& vertex, PlyEncoding encoding);

}  // namespace swiftgs::io
