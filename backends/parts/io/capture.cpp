// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/io/capture.hpp>

#include "file_kind.hpp"
#include "mapped_file.hpp"
#include "scene_format.hpp"
#include "text.hpp"

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

using Names = std::vector<std::string_view>;

/// What formats of scenes say of names in the folder of a capture, preferred formats first.
struct SceneNames {
  Names endings{}, last_endings{};
  Names whole{};  ///< of what describes a scene that is a folder
};

const SceneNames& scene_names() {
  static const SceneNames names = [] {
    auto formats = std::to_array(scene_formats);
    std::ranges::sort(formats, {}, &SceneFormat::place_in_capture);
    SceneNames sorted;
    for (const SceneFormat* format : formats)
      for (const std::string_view name : format->names) {
        Names& endings = format->last_in_capture ? sorted.last_endings : sorted.endings;
        if (!name.empty()) (name.starts_with('.') ? endings : sorted.whole).push_back(name);
      }
    return sorted;
  }();
  return names;
}

/// ".spz, .ply or .sog": no ending that ends in another one.
std::string choice_of(const Names& endings) {
  std::vector<std::string> names;
  for (const std::string_view ending : endings)
    if (std::none_of(endings.begin(), endings.end(),
                     [&](std::string_view other) { return other != ending && has_ending(ending, other); }))
      names.emplace_back(ending);
  return either(names);
}

/// The ending of a scene's name, or nothing.
std::string_view ending_of(std::string_view name, const Names& known) {
  for (const std::string_view ending : known)
    if (has_ending(name, ending)) return ending;
  return {};
}

/// The scene with one of the endings `known` in `folder`: the one that is called as the folder, of several
/// the one whose ending comes first, or else the only one. Otherwise empty, and `found` has their names.
fs::path scene_in(const fs::path& folder, const Names& known, std::vector<std::string>& found) {
  const std::string name = name_of(folder);
  std::vector<std::string> scenes;
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::string file = entry.path().filename().string();
    if (!ending_of(file, known).empty() && file != "input.ply" && entry.is_regular_file())
      scenes.push_back(std::move(file));
  }
  std::sort(scenes.begin(), scenes.end());
  for (const std::string_view ending : known)
    for (const std::string& file : scenes)
      if (file.size() == name.size() + ending.size() && file.starts_with(name) && has_ending(file, ending))
        return folder / file;
  if (scenes.size() == 1) return folder / scenes.front();
  found = std::move(scenes);
  return {};
}

/// Folders of checkpoints, and how their trainers make a scene of them.
struct Checkpoints {
  const char *folder, *advice;
};
constexpr Checkpoints checkpoints[] = {
    {"nerfstudio_models", ", checkpoints of nerfstudio; export a PLY with 'ns-export gaussian-splat'"},
    {"ckpts", ", checkpoints of gsplat; train with --save_ply and give a PLY of its folder 'ply'"}};

/// What a folder without a scene holds: something that is taken for one, or cameras.
std::string found_instead(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (is_foreign_name(entry.path().filename().string()) && entry.is_regular_file())
      files.push_back(entry.path());
  if (!files.empty()) {
    const fs::path& file = *std::min_element(files.begin(), files.end());
    const MappedFile content(file);
    const std::string_view text = Source{content.bytes(), file.string()}.text();
    const std::string what = what_it_is(text, file.string());
    return file.filename().string() + (what == something_else ? "" : ", " + what);
  }
  for (const auto& [name, advice] : checkpoints)
    if (fs::is_directory(folder / name)) return std::string(name) + advice;
  const fs::path cameras = cameras_in(folder);
  if (cameras.empty()) return "none";
  return (cameras == folder ? "a COLMAP model" : cameras.lexically_relative(folder).string()) +
         ", which holds cameras alone";
}

fs::path scene_in(const fs::path& folder) {
  std::vector<std::string> scenes;
  const auto& [endings, last_endings, whole] = scene_names();
  if (fs::path scene = scene_in(folder, endings, scenes); !scene.empty()) return scene;
  for (const std::string_view file : whole)
    if (scenes.empty() && fs::exists(folder / file)) return folder / file;
  if (scenes.empty())
    if (fs::path scene = scene_in(folder, last_endings, scenes); !scene.empty()) return scene;
  std::string found = scenes.empty() ? found_instead(folder) : "";
  for (const std::string& scene : scenes) found += (found.empty() ? "" : ", ") + scene;
  detail::refuse(folder.string(), ": expected a capture, a folder with one ", choice_of(endings),
                 " in it, or else one ", choice_of(last_endings), ", found ", found);
}

std::string name_of_scene(const fs::path& scene) {
  const std::string file = scene.filename().string();
  for (const Names* known : {&scene_names().endings, &scene_names().last_endings})
    if (const std::string_view ending = ending_of(file, *known); !ending.empty())
      return file.substr(0, file.size() - ending.size());
  return scene.stem().string();
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
  for (const std::string_view file : transforms_files)
    if (fs::path json = folder / file; fs::exists(json)) return json;
  return {};
}

namespace {

Capture find(const fs::path& path) {
  Capture capture;
  fs::path folder = path;
  if (!fs::is_directory(path)) {
    capture.scene = path;
    folder = path.has_parent_path() ? path.parent_path() : ".";
  } else if (capture.scene = trained_in(path); !capture.scene.empty()) {
    capture.name = name_of(path);
  } else {
    capture.scene = scene_in(path);
  }
  for (const std::string_view file : scene_names().whole)
    if (capture.scene.filename() == file && fs::is_directory(folder)) capture.name = name_of(folder);
  if (capture.name.empty()) capture.name = name_of_scene(capture.scene);
  capture.cameras = cameras_in(folder);
  if (fs::path photos = folder / "photos"; fs::is_directory(photos)) capture.photos = photos;
  return capture;
}

}  // namespace
}  // namespace io

Capture find_capture(const std::filesystem::path& path) {
  return io::with_file_errors([&] { return io::find(path); });
}

}  // namespace swiftgs
