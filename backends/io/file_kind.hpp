// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

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

}  // namespace swiftgs::io
