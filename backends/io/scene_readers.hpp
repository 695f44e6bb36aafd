// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/io/scene_file.hpp>

#include "bytes.hpp"

/// @file
/// A reader for each format. All throw `FormatError` and `Cancelled`.

namespace swiftgs::io {

SceneFile read_gltf(const Source& source, const SceneReadOptions& options);
SceneFile read_ksplat(const Source& source, const SceneReadOptions& options);
SceneFile read_ply(const Source& source, const SceneReadOptions& options);
SceneFile read_splat(const Source& source, const SceneReadOptions& options);
SceneFile read_spz(const Source& source, const SceneReadOptions& options);
SceneFile read_sog(const Source& source, const SceneReadOptions& options);
SceneFile read_streamed_sog(const Source& source, const SceneReadOptions& options);

}  // namespace swiftgs::io
