// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace swiftgs::io {

/// Whether `folder` holds a COLMAP model whose files end in `ending`.
bool is_colmap(const std::filesystem::path& folder, const char* ending);

/// Files of cameras that Blender's scenes, instant-ngp and nerfstudio have, the first that is there counts.
inline constexpr std::string_view transforms_files[] = {"transforms.json", "transforms_train.json",
                                                        "transforms_test.json"};

/// The cameras in the folder of a capture: a file or the folder of a COLMAP model. Empty if there are none.
std::filesystem::path cameras_in(const std::filesystem::path& folder);

}  // namespace swiftgs::io
