// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "support/files.hpp"

namespace swiftgs::test {

/// A `cameras.json` with a camera of 32x16 for each of `images`, which look at the origin from -z.
inline std::string cameras_json(const std::vector<std::string>& images) {
  std::string text = "[";
  for (const std::string& image : images) {
    if (text.size() > 1) text += ",\n";
    text += "{\"id\": 0, \"img_name\": \"" + image +
            "\", \"width\": 32, \"height\": 16, \"fx\": 30, \"fy\": 30, \"position\": [0, -1, -4], "
            "\"rotation\": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}";
  }
  return text + "]";
}

}  // namespace swiftgs::test
