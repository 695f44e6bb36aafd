// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>

#include <swiftgs/io/cameras.hpp>

#include "camera_parsing.hpp"
#include "mapped_file.hpp"

namespace swiftgs {
namespace io {
namespace {

namespace fs = std::filesystem;

std::vector<Camera> read_colmap(const fs::path& folder, const char* ending,
                                std::vector<Camera> (*parse)(const Source&, const Source&)) {
  const fs::path cameras_path = folder / (std::string("cameras") + ending);
  const fs::path images_path = folder / (std::string("images") + ending);
  const MappedFile cameras(cameras_path), images(images_path);
  return parse({cameras.bytes(), cameras_path.string()}, {images.bytes(), images_path.string()});
}

std::vector<Camera> read_folder(const fs::path& path) {
  for (const fs::path& folder : {path, path / "sparse" / "0"}) {
    const auto has = [&](const char* name) { return fs::exists(folder / name); };
    if (has("cameras.bin") && has("images.bin")) return read_colmap(folder, ".bin", parse_colmap_binary);
    if (has("cameras.txt") && has("images.txt")) return read_colmap(folder, ".txt", parse_colmap_text);
  }
  throw std::system_error(
      ENOENT, std::generic_category(),
      path.string() + ": expected cameras.bin and images.bin (or .txt), here or in sparse/0");
}

}  // namespace
}  // namespace io

std::vector<Camera> read_cameras(const std::filesystem::path& path) {
  std::vector<Camera> cameras;
  if (std::filesystem::is_directory(path)) {
    cameras = io::read_folder(path);
  } else {
    const io::MappedFile file(path);
    const io::Source source{file.bytes(), path.string()};
    const std::size_t first = source.text().find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos || source.text()[first] != '[')
      source.fail(0, "cameras: INRIA's cameras.json (a JSON array), or the folder of a COLMAP model");
    cameras = io::parse_cameras_json(source);
  }
  std::stable_sort(cameras.begin(), cameras.end(),
                   [](const Camera& a, const Camera& b) { return a.name < b.name; });
  return cameras;
}

}  // namespace swiftgs
