// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <swiftgs/io/capture.hpp>

#include "capture_parts.hpp"

namespace swiftgs {
namespace io {
namespace {

namespace fs = std::filesystem;

/// What `folder` is called, also where it is written as `.` or with a slash at the end.
std::string name_of(const fs::path& folder) { return fs::canonical(folder).filename().string(); }

/// The scene that INRIA's training wrote last; empty where there is none.
fs::path trained_in(const fs::path& folder) {
  constexpr std::string_view prefix = "iteration_";
  std::error_code absent;
  std::optional<std::uint64_t> last;
  fs::path scene;
  for (const auto& entry : fs::directory_iterator(folder / "point_cloud", absent)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(prefix) || !fs::is_regular_file(entry.path() / "point_cloud.ply")) continue;
    std::uint64_t iteration = 0;
    const char* const end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(name.data() + prefix.size(), end, iteration);
    if (error != std::errc() || stop != end || (last && iteration < *last)) continue;
    last = iteration, scene = entry.path() / "point_cloud.ply";
  }
  return scene;
}

/// What describes a SOG that is a folder, a streamed one first: its chunks lie in folders of their own.
constexpr const char* sog_files[] = {"lod-meta.json", "meta.json"};

bool is_scene_file(const fs::directory_entry& entry) {
  const fs::path name = entry.path().filename();
  return (name.extension() == ".spz" || name.extension() == ".ply" || name.extension() == ".sog") &&
         name != "input.ply" && entry.is_regular_file();
}

fs::path scene_in(const fs::path& folder) {
  const std::string name = name_of(folder);
  for (const char* extension : {".spz", ".ply", ".sog"})
    if (fs::path file = folder / (name + extension); fs::is_regular_file(file)) return file;
  std::vector<std::string> scenes;
  for (const auto& entry : fs::directory_iterator(folder))
    if (is_scene_file(entry)) scenes.push_back(entry.path().filename().string());
  if (scenes.size() == 1) return folder / scenes.front();
  for (const char* file : sog_files)
    if (scenes.empty() && fs::exists(folder / file)) return folder / file;
  std::sort(scenes.begin(), scenes.end());
  std::string found = scenes.empty() ? "none" : "";
  for (const std::string& scene : scenes) found += (found.empty() ? "" : ", ") + scene;
  if (scenes.empty() && fs::exists(folder / "transforms.json"))
    found = "transforms.json, which holds cameras alone";
  throw std::invalid_argument(
      folder.string() + ": expected a capture, a folder with one .spz, .ply or .sog in it, found " + found);
}

}  // namespace

bool is_colmap(const fs::path& folder, const char* ending) {
  return fs::exists(folder / (std::string("cameras") + ending)) &&
         fs::exists(folder / (std::string("images") + ending));
}

fs::path cameras_in(const fs::path& folder) {
  const auto holds_model = [](const fs::path& place) {
    return is_colmap(place, ".bin") || is_colmap(place, ".txt");
  };
  if (holds_model(folder)) return folder;
  if (fs::path json = folder / "cameras.json"; fs::exists(json)) return json;
  for (const fs::path& place : {folder / "sparse" / "0", folder / "sparse", folder / "0"})
    if (holds_model(place)) return place;
  if (fs::path json = folder / "transforms.json"; fs::exists(json)) return json;
  return {};
}

}  // namespace io

Capture find_capture(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  Capture capture;
  fs::path folder = path;
  if (!fs::is_directory(path)) {
    capture.scene = path;
    folder = path.has_parent_path() ? path.parent_path() : ".";
  } else if (capture.scene = io::trained_in(path); !capture.scene.empty()) {
    capture.name = io::name_of(path);
  } else {
    capture.scene = io::scene_in(path);
  }
  for (const char* file : io::sog_files)
    if (capture.scene.filename() == file && fs::is_directory(folder)) capture.name = io::name_of(folder);
  if (capture.name.empty()) capture.name = capture.scene.stem().string();
  capture.cameras = io::cameras_in(folder);
  if (fs::path photos = folder / "photos"; fs::is_directory(photos)) capture.photos = photos;
  return capture;
}

}  // namespace swiftgs
