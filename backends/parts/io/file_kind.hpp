// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a file or folder is: a scene, cameras, part of a capture, or an archive of others.

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/frame/api.hpp>

#include "scene_format.hpp"

namespace swiftgs::io {

/// Files that somebody here reads.
enum class FileKind {
  scene,
  cameras_json,  ///< INRIA's
  transforms_json,
  camera_path,
  scene_list,
  other
};

/// What a file is, by its content; by the ending of `name` where nothing else tells. All readers go by it.
FileKind kind_of(std::string_view text, std::string_view name);

/// The format of a file of the kind `scene`; null for another.
const SceneFormat* scene_format_of(std::string_view text, std::string_view name);

/// What a file is, for an error of a reader of other files. What is no scene but often taken for one has its
/// name, and what to give in its place. Of an archive it tells the scenes in it.
std::string what_it_is(std::string_view text, std::string_view name);

/// Whether a file that begins with `text` is a tileset of 3D Tiles.
SWIFTGS_API bool is_tileset(std::string_view text);

/// Whether `folder` holds a COLMAP model whose files end in `ending`.
bool is_colmap(const std::filesystem::path& folder, const char* ending);

/// Camera files of instant-ngp, nerfstudio and Blender's scenes. The first that exists counts.
inline constexpr std::string_view transforms_files[] = {"transforms.json", "transforms_train.json",
                                                        "transforms_test.json", "transforms_val.json"};

/// Files that hold a part of a scene's cameras.
inline constexpr std::span split_files = std::span(transforms_files).subspan<1>();

/// The cameras in the folder of a capture: a file or the folder of a COLMAP model. Empty if there are none.
std::filesystem::path cameras_in(const std::filesystem::path& folder);

inline bool is_zip(std::string_view text) { return text.starts_with("PK\3\4"); }
inline bool is_gzip(std::string_view text) { return text.starts_with("\x1f\x8b"); }
inline bool is_tar(std::string_view text) { return text.size() >= 512 && text.substr(257, 5) == "ustar"; }

/// The names of files whose headers are in `text`, the beginning of a tar archive.
std::vector<std::string> names_in_tar(std::string_view text);

/// What kind of archive `archive` is, judged by the `names` of its files, and what to do with it: the end of
/// an error message.
std::string archive_of(const std::string& archive, const std::vector<std::string>& names);

/// How many bytes of a file are read to find out what it is.
inline constexpr std::size_t beginning_bytes = 1 << 16;

/// What a file is that nobody knows.
inline constexpr const char* something_else = "something else";

/// Whether a file begins with at least four bytes, or as JSON with keys, that say it is nothing that is read,
/// whatever its name.
bool is_surely_foreign(std::string_view text);

/// What a file is that nobody here reads, and what to give in its place.
std::string foreign_file(std::string_view text, std::string_view name);

/// Whether the name is of a file that people take for a scene, or pack scenes in.
bool is_foreign_name(std::string_view name);

}  // namespace swiftgs::io
