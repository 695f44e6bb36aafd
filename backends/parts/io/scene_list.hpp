// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <swiftgs/io/scene_list.hpp>

#include "bytes.hpp"

namespace swiftgs::io {

/// `read_scene_list` of a file in memory.
std::vector<ListedScene> parse_scene_list(const Source& source);

}  // namespace swiftgs::io
