// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include <swiftgs/chunks.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/scene_arrays.hpp>

namespace swiftgs {

/// The scene of a host backend: shared, never copied, or copied from arrays.
class HostScene {
 public:
  /// Loops of `backend` look at it. Throws `std::invalid_argument` as `validate` and `validate_numbers` do.
  template <class B>
  HostScene(const B& backend, std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {
    if (!scene_) throw std::invalid_argument("upload: expected a scene");
    view_ = swiftgs::view(*scene_);
    validate_numbers(backend, *scene_);
    chunks_ = std::make_shared<const std::vector<ChunkBounds>>(chunk_bounds(view_));
    view_.chunks = {chunks_->data(), chunks_->size()};
    view_.identity = new_scene_identity();
  }

  /// A copy of `arrays`, in the memory of `reuse` if that is such a copy and nobody else has it. Throws
  /// as above, and leaves `reuse` as it is then. `arrays` do not lie in it.
  template <class B>
  static HostScene copy(const B& backend, const SceneArrays& arrays, std::optional<HostScene>& reuse) {
    validate(arrays);
    std::shared_ptr<Scene> scene;
    // Numbers that are refused must not reach the memory of a scene that stays.
    if (reuse && reuse->copied_.use_count() == of_one_copy && would_be_finite(backend, arrays))
      scene = std::move(std::exchange(reuse, std::nullopt)->copied_);
    else
      scene = std::make_shared<Scene>();
    copy_scene(backend, arrays, *scene);
    HostScene out(backend, scene);
    out.copied_ = std::move(scene);
    return out;
  }

  SceneView view() const { return view_; }

 private:
  static constexpr long of_one_copy = 2;  // `scene_` and `copied_`

  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<Scene> copied_;  ///< the same where it is of arrays
  std::shared_ptr<const std::vector<ChunkBounds>> chunks_;
  SceneView view_;
};

}  // namespace swiftgs
