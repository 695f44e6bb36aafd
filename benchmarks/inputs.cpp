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
#include <swiftgs/io/capture.hpp>
#include <swiftgs/io/scene_file.hpp>

namespace swiftgs::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view builtin_name = "builtin";

fs::path captures_folder() {
  const char* const folder = std::getenv("SWIFTGS_SCENES");
  return folder ? folder : SWIFTGS_SCENES_DEFAULT;
}

/// The captures that have cameras, by name.
std::vector<Capture> captures() {
  std::vector<Capture> captures;
  std::error_code absent;
  for (const auto& entry : fs::directory_iterator(captures_folder(), absent)) {
    if (!entry.is_directory()) continue;
    try {
      captures.push_back(find_capture(entry.path()));
    } catch (const std::invalid_argument&) {
      continue;  // no capture
    }
    if (captures.back().cameras.empty()) captures.pop_back();
  }
  std::sort(captures.begin(), captures.end(),
            [](const Capture& a, const Capture& b) { return a.name < b.name; });
  return captures;
}

Input input_of(const Capture& capture) {
  Input input{capture.name, {}, [file = capture.scene] { return load_scene(file); }};
  const std::vector<Camera> cameras = load_cameras(capture.cameras);
  for (std::size_t i = 0; i < cameras.size(); i += 8) input.views.push_back(cameras[i]);
  if (input.views.empty())
    throw std::invalid_argument(capture.name + ": expected at least one camera, found none");
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
  const std::vector<Capture> known = captures();
  std::vector<std::string> wanted = names;
  if (names.empty()) {
    wanted.emplace_back(builtin_name);
    for (const Capture& capture : known) wanted.push_back(capture.name);
  }
  std::vector<Input> inputs;
  for (const std::string& name : wanted) {
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&](const Capture& capture) { return capture.name == name; });
    if (const std::optional<std::size_t> count = builtin_size(name)) {
      inputs.push_back({name, {builtin_camera()}, [count] { return make_builtin_scene(*count); }});
    } else if (found != known.end()) {
      inputs.push_back(input_of(*found));
    } else {
      std::string expected("builtin, builtin:N");
      for (const Capture& capture : known) expected.append(", ").append(capture.name);
      throw std::invalid_argument("scene '" + name + "' is not known; expected one of " + expected);
    }
  }
  return inputs;
}

}  // namespace swiftgs::bench
