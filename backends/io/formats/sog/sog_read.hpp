// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include <swiftgs/io/scene_file.hpp>

#include "sog_content.hpp"

namespace swiftgs::io {

/// What the SOGs that make up a scene say beside their Gaussians.
class SogFindings {
 public:
  /// `odd_labels` is what `decode_gaussians` returned.
  void add(const SogMeta& meta, std::uint64_t odd_labels);

  /// Leaves out Gaussians with a fault, and sets `file`'s notes and its scene's model.
  void finish(SceneFile& file) const;

 private:
  bool antialiased_ = false, plain_ = false;
  RenderingModel::Kernel kernel_ = RenderingModel::Kernel::ellipsoid;
  std::string unknown_model_;
  std::uint64_t odd_labels_ = 0;
};

/// Whether a file is JSON with two keys of a SOG. Keys of a glTF may be any, these among them.
bool has_sog_keys(std::string_view text, std::string_view name, std::string_view first,
                  std::string_view second);

/// Reads `lod-meta.json`, whose chunks and their images `open` opens by names relative to it.
SceneFile read_streamed_sog(const Source& source, const SogFiles& open, const SceneReadOptions& options);

}  // namespace swiftgs::io
