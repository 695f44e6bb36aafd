// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/io/scene_file.hpp>

#include "sog_content.hpp"

namespace swiftgs::io {

/// What the SOGs that make up a scene say beside their Gaussians.
class SogFindings {
 public:
  void add(const SogMeta& meta, const SogOddities& odd);

  /// Drops what cannot be rendered, and sets `file`'s notes and its scene's model.
  void finish(SceneFile& file) const;

 private:
  bool antialiased_ = false, plain_ = false;
  RenderingModel::Kernel kernel_ = RenderingModel::Kernel::ellipsoid;
  std::string unknown_model_;
  SogOddities odd_;
};

/// Reads `lod-meta.json`, whose chunks and their images `open` opens by names relative to it.
SceneFile read_streamed_sog(const Source& source, const SogFiles& open, const SceneReadOptions& options);

}  // namespace swiftgs::io
