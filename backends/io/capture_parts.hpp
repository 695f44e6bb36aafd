// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

namespace swiftgs::io {

/// Whether `folder` holds a COLMAP model whose files end in `ending`.
bool is_colmap(const std::filesystem::path& folder, const char* ending);

/// Files of cameras that instant-ngp, nerfstudio and Blender's scenes have, the first that is there counts.
inline constexpr std::string_view transforms_files[] = {"transforms.json", "transforms_train.json",
                                                        "transforms_test.json", "transforms_val.json"};

/// Those that hold a part of a scene's cameras.
inline constexpr std::span split_files = std::span(transforms_files).subspan<1>();

/// The cameras in the folder of a capture: a file or the folder of a COLMAP model. Empty if there are none.
std::filesystem::path cameras_in(const std::filesystem::path& folder);

}  // namespace swiftgs::io
