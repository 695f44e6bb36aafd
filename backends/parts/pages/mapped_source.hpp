// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

#include <swiftgs/pages/paged_scene.hpp>

namespace swiftgs::pages {

struct MappedSource {
  PageSource read;
  std::uint64_t size = 0;
};

/// Maps a regular file into memory for as long as the source lives. Throws `FileError`.
MappedSource map_source(const std::filesystem::path& path);

}  // namespace swiftgs::pages
