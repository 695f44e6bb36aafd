// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include <swiftgs/io/scene_file.hpp>

#include "bytes.hpp"
#include "scene_encoding.hpp"
#include "text.hpp"

/// @file
/// The formats of scenes. The files of a format export one row, which states all that other files use of it.

namespace swiftgs::io {

/// Throws `FormatError` and `Cancelled`. `SceneFile::bytes` is left to be those of other files.
using SceneReader = SceneFile(const Source& source, const SceneReadOptions& options);

/// Takes a scene that is valid and `encodable`, and throws `Cancelled` and `FileError`. A writer that
/// rounds gives `losses` the values that a reader will find in the file.
using SceneWriter = WrittenScene(const std::filesystem::path& path, const Scene& scene,
                                 const SceneWriteOptions& options, LossMeter& losses);

struct SceneFormat {
  std::string_view name;  ///< with its article, as errors say what a file is: "a PLY"
  /// What names of files end in, in small letters. One without a dot in front is the whole name of what
  /// describes a scene that is a folder. Empty ones are none.
  std::array<std::string_view, 2> names{};

  /// Whether `text` has bytes that say so whatever else it looks like. Null: no bytes do.
  bool (*has_mark)(std::string_view text) = nullptr;
  /// Whether a file without a mark, and not `is_surely_foreign`, looks like this format. Null: none does.
  bool (*looks_so)(std::string_view text, std::string_view name) = nullptr;
  bool goes_by_name = false;  ///< where the content of a file tells nothing

  SceneReader* read = nullptr;  ///< null where the content, and so the reader, are another format's
  bool reads_parts = false;
  SceneWriter* write = nullptr;  ///< to a file whose name ends in the first of `names`; null: only read
  bool holds_doubles = false;    ///< of positions, so that the writer keeps an origin

  /// Of several scenes in the folder of a capture, that of the least number is taken.
  int place_in_capture = 0;
  /// Other programs write a scene into this format again, or it may hold something else, such as a mesh: it
  /// counts where a folder has no other scene.
  bool last_in_capture = false;
};

extern const SceneFormat ply_format, compressed_ply_format, spz_format, sog_format, streamed_sog_format,
    gltf_format, splat_format, ksplat_format;

/// All formats, in the order in which texts list them.
inline constexpr const SceneFormat* scene_formats[] = {&ply_format,   &compressed_ply_format, &spz_format,
                                                       &sog_format,   &streamed_sog_format,   &gltf_format,
                                                       &splat_format, &ksplat_format};

/// Whether a file is called as those of `format` are.
inline bool is_named_as(const SceneFormat& format, std::string_view name) {
  return std::any_of(format.names.begin(), format.names.end(),
                     [&](std::string_view known) { return !known.empty() && has_ending(name, known); });
}

}  // namespace swiftgs::io
