// SPDX-License-Identifier: Apache-2.0
#include "sog_files.hpp"

#include <algorithm>
#include <filesystem>

namespace swiftgs::io {

SogFiles files_beside(const Source& meta) {
  if (meta.folder.empty())
    meta.fail(0, "a file in a folder, whose images lie beside it, found JSON of a SOG in memory");
  return [folder = meta.folder](const std::string& name) {
    const std::filesystem::path path = folder / name;
    auto file = std::make_shared<const MappedFile>(path);
    return SogFile{{file->bytes(), path.string()}, file->bytes().size(), file->identity(), file};
  };
}

SogFiles files_beside(const std::string& name, const SogFiles& files) {
  return [folder = std::filesystem::path(name).parent_path(), &files](const std::string& image) {
    return files((folder / image).string());
  };
}

bool stays_inside(const std::string& name) {
  const std::filesystem::path path = name;
  return !path.empty() && path.is_relative() && name.find('\0') == name.npos &&
         std::find(path.begin(), path.end(), "..") == path.end();
}

}  // namespace swiftgs::io
