// SPDX-License-Identifier: Apache-2.0
#include <string_view>

#include <swiftgs/io/capture.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/message.hpp>

#include "bytes.hpp"
#include "foreign_file.hpp"
#include "gltf_document.hpp"
#include "ksplat_layout.hpp"
#include "mapped_file.hpp"
#include "name_ending.hpp"
#include "scene_building.hpp"
#include "scene_readers.hpp"
#include "spz_content.hpp"

namespace swiftgs {
namespace io {
namespace {

bool is_object(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != text.npos && text[first] == '{';
}

bool is_object_with(std::string_view text, std::string_view key, std::string_view other_key) {
  return is_object(text) && text.find(key) != text.npos && text.find(other_key) != text.npos;
}

/// A format that is told by its content, or by the name's ending.
struct Reader {
  bool (*reads)(std::string_view text, std::string_view name);
  /// `SceneFile::bytes` is left to be those of other files.
  SceneFile (*read)(const Source& source, const SceneReadOptions& options);
  bool reads_parts = false;
};

/// The first that reads a file is taken.
constexpr Reader readers[] = {
    {[](std::string_view text, std::string_view) {
       return text.starts_with("ply\n") || text.starts_with("ply\r\n");
     },
     read_ply, true},
    {[](std::string_view text, std::string_view) { return text.starts_with("NGSP") || is_gzip_of_spz(text); },
     read_spz, true},
    {[](std::string_view text, std::string_view name) {
       return looks_like_gltf(text) || (has_ending(name, ".gltf") && is_object(text));
     },
     read_gltf},
    {[](std::string_view text, std::string_view name) {
       return has_ending(name, ".ksplat") || looks_like_ksplat(text);
     },
     read_ksplat},
    {[](std::string_view text, std::string_view) {
       // The list of an archive's files is at its end.
       return (text.starts_with("PK\3\4") && text.rfind("meta.json") != text.npos) ||
              is_object_with(text, "\"means\"", "\"quats\"");
     },
     read_sog},
    {[](std::string_view text, std::string_view) {
       return is_object_with(text, "\"lodLevels\"", "\"filenames\"");
     },
     read_streamed_sog},
    // Last, as nothing but the name tells.
    {[](std::string_view text, std::string_view name) {
       return has_ending(name, ".splat") && !is_surely_foreign(text);
     },
     read_splat, true},
};

SceneFile read(const Source& source, const SceneReadOptions& options) {
  const std::string_view text = source.text();
  validate(options.part);
  for (const Reader& reader : readers)
    if (reader.reads(text, source.name)) {
      if (!options.part.is_whole() && !reader.reads_parts)
        detail::refuse(source.name,
                       ": a part of it was asked for, expected a PLY, SPZ or .splat file, which can be "
                       "read in parts; 'swiftgs convert' writes one");
      SceneFile file = reader.read(source, options);
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
  source.fail(0, "a scene of Gaussians, found " + what_it_is(text));
}

}  // namespace
}  // namespace io

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
