// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/io/capture.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/message.hpp>

#include "file_kind.hpp"
#include "listed.hpp"
#include "mapped_file.hpp"
#include "scene_building.hpp"
#include "scene_format.hpp"

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

}  // namespace swiftgs
