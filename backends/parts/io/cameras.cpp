// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>

#include <swiftgs/error.hpp>
#include <swiftgs/io/cameras.hpp>

#include "camera_parsing.hpp"
#include "file_kind.hpp"
#include "mapped_file.hpp"
#include "text.hpp"

namespace swiftgs {
namespace io {
namespace {

namespace fs = std::filesystem;

CameraFile sorted_by_name(CameraFile file) {
  std::stable_sort(file.cameras.begin(), file.cameras.end(),
                   [](const Camera& a, const Camera& b) { return a.name < b.name; });
  return file;
}

CameraFile read_colmap(const fs::path& folder, const char* ending,
                       std::vector<Camera> (*parse)(const Source&, const Source&)) {
  const fs::path cameras_path = folder / (std::string("cameras") + ending);
  const fs::path images_path = folder / (std::string("images") + ending);
  const MappedFile cameras(cameras_path), images(images_path);
  return sorted_by_name(
      {parse({cameras.bytes(), cameras_path.string()}, {images.bytes(), images_path.string()}), {}});
}

CameraFile read_model(const fs::path& folder) {
  return is_colmap(folder, ".bin") ? read_colmap(folder, ".bin", parse_colmap_binary)
                                   : read_colmap(folder, ".txt", parse_colmap_text);
}

/// Notes other splits beside the one at `path`, which was found in a folder: a caller may not know of them.
void note_other_splits(const fs::path& path, std::vector<std::string>& notes) {
  if (std::ranges::find(split_files, path.filename().string()) == split_files.end()) return;
  std::vector<std::string> others;
  for (const std::string_view split : split_files)
    if (path.filename() != split && fs::exists(fs::path(path).replace_filename(split)))
      others.emplace_back(split);
  if (!others.empty())
    notes.push_back("The cameras of " + path.filename().string() + " were read, those of " + listed(others) +
                    " were not.");
}

CameraFile read_file(const fs::path& path) {
  const MappedFile file(path);
  const Source source{file.bytes(), path.string()};
  const std::string_view text = source.text();
  const FileKind kind = kind_of(text, source.name);
  if (kind == FileKind::transforms_json)
    return read_transforms_json(source, path.has_parent_path() ? path.parent_path() : ".");
  if (kind == FileKind::camera_path) return parse_camera_path(source);
  // The reader of INRIA's cameras.json also takes any other array: its error says what is missing.
  if (kind == FileKind::cameras_json ||
      (kind == FileKind::other && text.substr(json_start(text)).starts_with('[')))
    return sorted_by_name(parse_cameras_json(source));
  source.fail(0,
              "cameras: INRIA's cameras.json (a JSON array), a transforms.json (a JSON object with "
              "'frames'), nerfstudio's camera_path.json (one with 'camera_path'), or the folder of a COLMAP "
              "model, found " +
                  what_it_is(text, source.name));
}

CameraFile read(const fs::path& path) {
  const bool is_folder = fs::is_directory(path);
  const fs::path found = is_folder ? cameras_in(path) : path;
  if (found.empty())
    detail::refuse(path.string(),
                   ": expected cameras.json, transforms.json, or a COLMAP model (cameras.bin and "
                   "images.bin, or .txt), here or in sparse/0 or sparse");
  if (fs::is_directory(found)) return read_model(found);
  CameraFile file = read_file(found);
  if (is_folder) note_other_splits(found, file.notes);
  return file;
}

}  // namespace
}  // namespace io

CameraFile read_cameras(const std::filesystem::path& path) {
  return io::with_file_errors([&] { return io::read(path); });
}

std::vector<Camera> load_cameras(const std::filesystem::path& path) { return read_cameras(path).cameras; }

}  // namespace swiftgs
