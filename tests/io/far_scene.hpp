// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <swiftgs/frame/math.hpp>

#include "ply_text.hpp"

namespace swiftgs::test {

inline constexpr std::size_t far_scene_size = 400;

/// Splats of a millimetre in a cube of side 2, on a grid that floats hold exactly, around `centre`. Positions
/// are of `type`, float or double. Seen from around (0, 0, -3) beside the centre.
inline std::string far_scene(const dvec3& centre, const std::string& type) {
  const double step = 1.0 / 4096;
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                       std::to_string(far_scene_size) + "\n",
              rows;
  std::uint32_t state = 7;
  const auto random = [&] { return double((state = state * 1664525 + 1013904223) >> 19) * step - 1; };
  for (std::size_t i = 0; i < far_scene_size; ++i) {
    auto gaussian = plain_gaussian();
    int axis = 0;
    for (const char* name : {"x", "y", "z"})
      property(gaussian, name) = {type, name, centre[axis++] + random()};
    for (const char* name : {"scale_0", "scale_1", "scale_2"}) property(gaussian, name).value = -6.9;
    property(gaussian, "opacity").value = 3, property(gaussian, "f_dc_0").value = 2 * random();
    for (const PlyValue& value : gaussian) {
      if (i == 0) header += "property " + value.type + " " + value.name + "\n";
      append_value(rows, value.type, value.value);
    }
  }
  return header + "end_header\n" + rows;
}

}  // namespace swiftgs::test
