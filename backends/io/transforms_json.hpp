// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace swiftgs::io {

/// Whether JSON of this `name` is a transforms.json of cameras, as NeRF's tools write it.
inline bool is_transforms_json(std::string_view text, std::string_view name) {
  const auto holds = [&](std::string_view word) { return text.find(word) != text.npos; };
  return name.ends_with("transforms.json") || holds("\"frames\"") || holds("\"transform_matrix\"");
}

}  // namespace swiftgs::io
