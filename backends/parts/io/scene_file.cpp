// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/io/capture.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "file_kind.hpp"
#include "mapped_file.hpp"
#include "scene_building.hpp"
#include "scene_encoding.hpp"
#include "scene_format.hpp"
#include "text.hpp"

namespace swiftgs {
namespace io {
namespace {

/// "a PLY, SPZ or .splat", of which parts can be read.
std::string formats_with_parts() {
  std::vector<std::string> names;
  for (const SceneFormat* format : scene_formats)
    if (format->reads_parts)
      names.emplace_back(names.empty() ? format->name : format->name.substr(format->name.find(' ') + 1));
  return either(names);
}

SceneFile read(const Source& source, const SceneReadOptions& options) {
  validate(options.part);
  if (options.level < 0)
    detail::refuse(source.name, ": level is ", options.level, ", expected 0, the finest detail, or more");
  const SceneFormat* format = scene_format_of(source.text(), source.name);
  if (!format) source.fail(0, "a scene of Gaussians, found " + what_it_is(source.text(), source.name));
  if (!options.part.is_whole() && !format->reads_parts)
    detail::refuse(source.name, ": a part of it was asked for, expected ", formats_with_parts(),
                   " file, which can be read in parts; 'swiftgs convert' writes one");
  SceneFile file = format->read(source, options);
  file.bytes += source.bytes.size();
  if (const dvec3& origin = file.scene.origin; origin != dvec3(0.0))
    file.notes.push_back(
        "Positions are too far from zero for float: the scene has them relative to the origin " +
        text_of(origin) + ".");
  if (file.scene.model.kernel == RenderingModel::Kernel::disk)
    file.notes.push_back("The Gaussians were trained as 2D ones; they are kept as flat 3D ones.");
  if (!options.part.is_whole()) return file;
  note_dropped_signs(file.signs_dropped, "taken", file.notes);
  note_left_out(file.left_out, file.notes);
  return file;
}

/// Names of files as a sentence lists them.
std::string listed_names(bool written) {
  std::vector<std::string> names;
  for (const SceneFormat* format : scene_formats)
    for (const std::string_view name :
         written ? std::span(format->names).first(format->write ? 1 : 0) : std::span(format->names))
      if (!name.empty()) names.emplace_back(name);
  return either(names);
}

}  // namespace
}  // namespace io

std::string readable_scenes() { return io::listed_names(false); }

std::string writable_scenes() { return io::listed_names(true); }

SceneFile read_scene(std::span<const std::byte> bytes, const std::string& name,
                     const SceneReadOptions& options) {
  return io::read({bytes, name}, options);
}

SceneFile read_scene(const std::filesystem::path& path, const SceneReadOptions& options) {
  const std::filesystem::path scene = find_capture(path).scene;
  const io::MappedFile file(scene);
  const std::filesystem::path folder = scene.has_parent_path() ? scene.parent_path() : ".";
  return io::read({file.bytes(), scene.string(), folder, true}, options);
}

Scene load_scene(const std::filesystem::path& path, const SceneReadOptions& options) {
  return read_scene(path, options).scene;
}

namespace io {
namespace {

/// The format whose ending `path` has: of `.compressed.ply` and `.ply` the longer one.
const SceneFormat& format_for(const std::filesystem::path& path, const std::string& ending) {
  const std::string name = ending.empty() ? path.filename().string() : ending;
  const SceneFormat* found = nullptr;
  std::vector<std::string> endings;
  for (const SceneFormat* format : scene_formats) {
    if (!format->write) continue;
    endings.emplace_back(format->names[0]);
    if (has_ending(name, format->names[0]) && (!found || format->names[0].size() > found->names[0].size()))
      found = format;
  }
  if (found) return *found;
  std::sort(endings.begin(), endings.end());
  detail::refuse(ending.empty() ? path.string() : ending, ": expected a scene's name that ends in one of ",
                 listed(endings));
}

/// Tells what of a scene's model the file does not hold.
void note_model(RenderingModel model, const RenderingModel& kept, std::vector<std::string>& notes) {
  if (model == kept) return;
  const RenderingModel usual;
  if (model.blur == kept.blur) model.blur = usual.blur;
  if (model.antialiased == kept.antialiased) model.antialiased = usual.antialiased;
  if (model.order == kept.order) model.order = usual.order;
  if (model.colours == kept.colours) model.colours = usual.colours;
  if (model.kernel == kept.kernel) model.kernel = usual.kernel;
  notes.push_back("How the scene was trained to be drawn is left out: " + text_of(model) + ".");
}

}  // namespace
}  // namespace io

void require_scene_ending(const std::filesystem::path& path, const SceneWriteOptions& options) {
  io::format_for(path, options.ending);
}

WrittenScene write_scene(const std::filesystem::path& path, const Scene& scene,
                         const SceneWriteOptions& options) {
  const io::SceneFormat& format = io::format_for(path, options.ending);
  validate(scene);
  std::vector<std::string> notes;
  const std::optional<Scene> cleaned = io::encodable(scene, notes);
  const Scene& encoded = cleaned ? *cleaned : scene;
  io::LossMeter losses(encoded, scene);
  WrittenScene written = format.write(path, encoded, options, losses);
  written.losses = losses.losses();
  if (!format.holds_doubles && scene.origin != dvec3(0.0))
    written.notes.push_back("The origin " + io::text_of(scene.origin) +
                            " is left out: positions in the file are relative to it.");
  io::note_model(scene.model, written.model, written.notes);
  written.notes.insert(written.notes.begin(), notes.begin(), notes.end());
  return written;
}

}  // namespace swiftgs
