// SPDX-License-Identifier: Apache-2.0
#include "read/scene_input.hpp"

#include <charconv>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/pages/paged_scene.hpp>

#include "draw/team.hpp"
#include "notes.hpp"
#include "options.hpp"

namespace swiftgs::cli {
namespace {

constexpr std::string_view builtin_name = "builtin";
constexpr std::size_t builtin_limit = 100'000'000;

/// All leaves of pages, for commands that do not draw them within a budget.
SceneFile whole_of(const PagedScene& pages) {
  SceneFile file;
  file.scene = read_leaves(pages), file.format = pages.format();
  file.stored = file.scene.size();
  return file;
}

}  // namespace

SpzFrame spz_frame_named(const std::string& name, const std::string& option) {
  if (name == "specified") return SpzFrame::specified;
  if (name == "rub") return SpzFrame::rub;
  if (name == "rdf") return SpzFrame::rdf;
  if (name == "luf") return SpzFrame::luf;
  if (name == "raw") return SpzFrame::raw;
  throw std::invalid_argument(option + " '" + name + "': expected specified, rub, rdf, luf or raw");
}

std::optional<std::size_t> builtin_size(std::string_view scene) {
  if (scene == builtin_name) return builtin_scene_size;
  if (!scene.starts_with("builtin:")) return std::nullopt;
  const std::string_view digits = scene.substr(builtin_name.size() + 1);
  std::size_t count = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), count);
  if (error != std::errc() || end != digits.data() + digits.size() || count < 1 || count > builtin_limit)
    throw std::invalid_argument("scene '" + std::string(scene) + "': expected builtin:N with N from 1 to " +
                                std::to_string(builtin_limit));
  return count;
}

Capture capture_of(const SceneOptions& options) {
  if (const std::optional<std::size_t> size = builtin_size(options.scene))
    return {std::string(builtin_name) + ":" + std::to_string(*size), {}, {}, {}};
  const std::string word = options.scene.substr(0, options.scene.find_first_of(":,=-"));
  const std::string nearest = suggestion(word, {std::string(builtin_name)});
  if (!nearest.empty() && !std::filesystem::exists(options.scene))
    throw std::invalid_argument(options.scene + ": No such file or directory" + nearest);
  return find_capture(options.scene);
}

SceneFile load(const SceneOptions& options, const swiftgs::Progress& progress) {
  const SceneReadOptions read{.spz_frame = spz_frame_named(options.spz_frame, "--spz-frame"),
                              .level = options.level,
                              .progress = progress};
  (void)model_from(options.model);  // before a large file is read
  if (options.model.find("kernel=") != std::string::npos)
    throw std::invalid_argument("--model " + options.model +
                                ": expected no kernel, which the Gaussians have");
  const std::optional<std::size_t> size = builtin_size(options.scene);
  SceneFile file;
  if (!size) {
    const std::filesystem::path path = capture_of(options).scene;
    Team::here().require_same_file(path.string());
    file = is_page_file(path) ? whole_of(open_pages(path)) : read_scene(path, read);
    file.scene.model = model_from(options.model, file.scene.model);
    return file;
  }
  file.scene = make_builtin_scene(*size);
  file.scene.model = model_from(options.model);
  file.format = "built in";
  file.stored = *size;
  return file;
}

DrawnScene load_to_draw(const SceneOptions& options, std::vector<std::string>& said) {
  SceneFile file = load(options);
  say_notes(capture_of(options).scene.string(), file.notes, said);
  return {std::make_shared<const Scene>(std::move(file.scene)), std::move(file.camera)};
}

std::string cameras_of(const SceneOptions& scene, const std::string& cameras) {
  if (!cameras.empty() || builtin_size(scene.scene) || !std::filesystem::is_directory(scene.scene))
    return cameras;
  return capture_of(scene).cameras.string();
}

std::string photos_of(const SceneOptions& scene, const ViewOptions& view, const std::string& photos) {
  if (!photos.empty() || !view.cameras.empty() || builtin_size(scene.scene) ||
      !std::filesystem::is_directory(scene.scene))
    return photos;
  return capture_of(scene).photos.string();
}

}  // namespace swiftgs::cli
