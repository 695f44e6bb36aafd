// SPDX-License-Identifier: Apache-2.0
#include "inputs.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/cameras.hpp>
#include <swiftgs/io/scene_file.hpp>

namespace swiftgs::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view builtin_name = "builtin";

fs::path captures_folder() {
  const char* const folder = std::getenv("SWIFTGS_SCENES");
  return folder ? folder : SWIFTGS_SCENES_DEFAULT;
}

/// The file that holds the Gaussians of the capture in `folder`, or nothing where `folder` is no capture.
std::optional<fs::path> gaussians_of(const fs::path& folder) {
  for (const char* extension : {".spz", ".ply"}) {
    fs::path file = folder / folder.filename();
    file += extension;
    if (fs::is_regular_file(file)) return file;
  }
  return std::nullopt;
}

std::vector<std::string> capture_names() {
  std::vector<std::string> names;
  std::error_code absent;
  for (const auto& entry : fs::directory_iterator(captures_folder(), absent))
    if (entry.is_directory() && gaussians_of(entry.path())) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

Input capture(const std::string& name) {
  const fs::path folder = captures_folder() / name, json = folder / "cameras.json";
  Input input{name, {}, [file = *gaussians_of(folder)] { return load_scene(file); }};
  const std::vector<Camera> cameras = read_cameras(fs::exists(json) ? json : folder / "sparse" / "0");
  for (std::size_t i = 0; i < cameras.size(); i += 8) input.views.push_back(cameras[i]);
  if (input.views.empty()) throw std::invalid_argument(name + ": expected at least one camera, found none");
  return input;
}

/// Gaussians that `name` asks of the built-in scene, or nothing where it asks for another.
std::optional<std::size_t> builtin_size(std::string_view name) {
  if (name == builtin_name) return builtin_scene_size;
  if (!name.starts_with("builtin:")) return std::nullopt;
  name.remove_prefix(builtin_name.size() + 1);
  std::size_t count = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), count);
  if (error != std::errc() || end != name.data() + name.size() || count == 0) return std::nullopt;
  return count;
}

}  // namespace

std::string Input::size() const {
  return std::to_string(views.front().width) + "x" + std::to_string(views.front().height);
}

std::vector<Input> inputs_named(const std::vector<std::string>& names) {
  const std::vector<std::string> captures = capture_names();
  if (names.empty()) {
    std::vector<std::string> all = captures;
    all.insert(all.begin(), std::string(builtin_name));
    return inputs_named(all);
  }
  std::vector<Input> inputs;
  for (const std::string& name : names) {
    if (const std::optional<std::size_t> count = builtin_size(name)) {
      inputs.push_back({name, {builtin_camera()}, [count] { return make_builtin_scene(*count); }});
    } else if (std::find(captures.begin(), captures.end(), name) != captures.end()) {
      inputs.push_back(capture(name));
    } else {
      std::string known("builtin, builtin:N");
      for (const std::string& other : captures) known.append(", ").append(other);
      throw std::invalid_argument("scene '" + name + "' is not known; expected one of " + known);
    }
  }
  return inputs;
}

}  // namespace swiftgs::bench
