// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <swiftgs/chunks.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// The scene of a host backend: shared, never copied.
class HostScene {
 public:
  /// Throws `std::invalid_argument` as `validate` and `validate_numbers` do.
  explicit HostScene(Scene scene) : HostScene(std::make_shared<const Scene>(std::move(scene))) {}
  explicit HostScene(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {
    if (!scene_) throw std::invalid_argument("upload: expected a scene");
    view_ = swiftgs::view(*scene_);
    validate_numbers(*scene_);
    chunks_ = std::make_shared<const std::vector<ChunkBounds>>(chunk_bounds(view_));
    view_.chunks = {chunks_->data(), chunks_->size()};
    view_.identity = new_scene_identity();
  }

  SceneView view() const { return view_; }

 private:
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const std::vector<ChunkBounds>> chunks_;
  SceneView view_;
};

}  // namespace swiftgs
