// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include <swiftgs/io/cameras.hpp>

#include "bytes.hpp"

/// @file
/// `transforms.json` of nerfstudio and instant-ngp, and `transforms_train.json` of Blender's scenes.

namespace swiftgs::io {

/// Its cameras in the order of the file, with the size of the images in `folder` where the file has none; an
/// empty folder has no images. `dataparser` is nerfstudio's `dataparser_transforms.json`, which takes cameras
/// to the world of the model that it trained, or null.
CameraFile parse_transforms_json(const Source& source, const std::filesystem::path& folder = {},
                                 const Source* dataparser = nullptr);

/// The same with the `dataparser_transforms.json` that is in `folder`, if there is one.
CameraFile read_transforms_json(const Source& source, const std::filesystem::path& folder);

}  // namespace swiftgs::io
