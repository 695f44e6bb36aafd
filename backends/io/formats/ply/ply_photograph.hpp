// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/io/scene_file.hpp>

#include "ply_header.hpp"

namespace swiftgs::io {

/// Reads what Apple's SHARP stores beside the Gaussians that it makes of a photograph, in elements whose only
/// property has the element's name: the camera, and whether colours are linear. Colours become sRGB, as later
/// versions of SHARP write them. Rows of elements are at `starts`. Adds the elements to `read`; without a
/// camera that is `color_space` alone.
void read_photograph(const Source& source, const PlyHeader& header,
                     const std::map<std::string, std::uint64_t>& starts, SceneFile& file,
                     std::vector<std::string_view>& read);

}  // namespace swiftgs::io
