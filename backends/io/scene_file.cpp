// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/io/capture.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/message.hpp>

#include "bytes.hpp"
#include "file_kind.hpp"
#include "mapped_file.hpp"
#include "scene_building.hpp"
#include "scene_readers.hpp"

namespace swiftgs {
namespace io {
namespace {

struct Reader {
  FileKind kind;
  /// `SceneFile::bytes` is left to be those of other files.
  SceneFile (*read)(const Source& source, const SceneReadOptions& options);
  bool reads_parts = false;
};

constexpr Reader readers[] = {{FileKind::ply, read_ply, true},    {FileKind::spz, read_spz, true},
                              {FileKind::gltf, read_gltf},        {FileKind::ksplat, read_ksplat},
                              {FileKind::sog, read_sog},          {FileKind::streamed_sog, read_streamed_sog},
                              {FileKind::splat, read_splat, true}};

SceneFile read(const Source& source, const SceneReadOptions& options) {
  validate(options.part);
  if (options.level < 0)
    detail::refuse(source.name, ": level is ", options.level, ", expected 0, the finest detail, or more");
  const FileKind kind = kind_of(source.text(), source.name);
  for (const Reader& reader : readers)
    if (reader.kind == kind) {
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
  source.fail(0, "a scene of Gaussians, found " + what_it_is(source.text(), source.name));
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
