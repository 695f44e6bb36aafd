// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include <swiftgs/io/scene_file.hpp>

#include "loss_meter.hpp"

/// @file
/// A writer for each format. All take a scene that is valid and `encodable`, and throw `Cancelled` and
/// `FileError`. Those that round also give `losses` the values that a reader will find in the file.

namespace swiftgs::io {

WrittenScene write_compressed_ply(const std::filesystem::path& path, const Scene& scene,
                                  const SceneWriteOptions& options, LossMeter& losses);
WrittenScene write_ply(const std::filesystem::path& path, const Scene& scene,
                       const SceneWriteOptions& options, LossMeter& losses);
WrittenScene write_sog(const std::filesystem::path& path, const Scene& scene,
                       const SceneWriteOptions& options, LossMeter& losses);
WrittenScene write_splat(const std::filesystem::path& path, const Scene& scene,
                         const SceneWriteOptions& options, LossMeter& losses);
WrittenScene write_spz(const std::filesystem::path& path, const Scene& scene,
                       const SceneWriteOptions& options, LossMeter& losses);

}  // namespace swiftgs::io
