// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace swiftgs::cli {

/// A renderer's name, BACKEND/SORT/RASTER/BOUNDS, word by word.
struct RendererWords {
  std::string backend, sort, raster, bounds;

  explicit RendererWords(std::string_view name) {
    for (std::string* word : {&backend, &sort, &raster, &bounds}) {
      const std::size_t length = std::min(name.find('/'), name.size());
      *word = name.substr(0, length);
      name.remove_prefix(std::min(length + 1, name.size()));
    }
  }

  std::string name() const { return backend + "/" + sort + "/" + raster + "/" + bounds; }
};

}  // namespace swiftgs::cli
