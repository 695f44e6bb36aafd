// SPDX-License-Identifier: Apache-2.0
#include <string_view>

#include <swiftgs/io/scene_file.hpp>

#include "bytes.hpp"
#include "mapped_file.hpp"

namespace swiftgs {

SceneFile read_scene(std::span<const std::byte> bytes, const std::string& name,
                     const SceneReadOptions& options) {
  const io::Source source{bytes, name};
  const std::string_view text = source.text();
  const auto starts_with = [&](std::string_view start) { return text.substr(0, start.size()) == start; };
  if (starts_with("ply\n") || starts_with("ply\r\n")) return read_ply(bytes, name);
  if (starts_with("NGSP") || starts_with("\x1f\x8b")) return read_spz(bytes, name, options);

  // What people take for a scene most often deserves its name.
  const std::string_view found = bytes.empty()                          ? "an empty file"
                                 : starts_with("PK")                    ? "a ZIP archive"
                                 : starts_with("glTF")                  ? "a binary glTF"
                                 : starts_with("\x89PNG")               ? "a PNG image"
                                 : starts_with("\xff\xd8\xff")          ? "a JPEG image"
                                 : starts_with("{") || starts_with("[") ? "JSON"
                                                                        : "something else";
  source.fail(0, "an INRIA PLY or an SPZ scene, found " + std::string(found));
}

SceneFile read_scene(const std::filesystem::path& path, const SceneReadOptions& options) {
  const io::MappedFile file(path);
  return read_scene(file.bytes(), path.string(), options);
}

Scene load_scene(const std::filesystem::path& path, const SceneReadOptions& options) {
  return read_scene(path, options).scene;
}

}  // namespace swiftgs
