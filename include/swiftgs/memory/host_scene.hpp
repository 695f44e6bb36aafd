// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/memory/copy_arrays.hpp>
#include <swiftgs/memory/harmonic_packing.hpp>
#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// The scene of a host backend: the caller's, shared without a copy, or its own. Copies of a `HostScene` are
/// one scene.
class HostScene {
 public:
  /// Shares `scene` as it is, and has halves beside it if those are to be kept. Loops of `backend` look at
  /// it. Throws `InvalidArgument` as `validate`, `validate_numbers` and `HarmonicPacking` do.
  template <class B>
  HostScene(const B& backend, std::shared_ptr<const Scene> scene,
            HarmonicsKept kept = HarmonicsKept::smallest)
      : arrays_(std::make_shared<Arrays>()) {
    if (!scene) throw InvalidArgument("upload: expected a scene");
    arrays_->of_caller = std::move(scene);
    look_at(backend);
    if (kept == HarmonicsKept::halves) pack(backend, kept);
  }

  /// Takes `scene` over; its harmonics are let go where they are kept in fewer bytes. Throws as above.
  template <class B>
  HostScene(const B& backend, Scene scene, HarmonicsKept kept = HarmonicsKept::smallest)
      : arrays_(std::make_shared<Arrays>()) {
    arrays_->own = std::move(scene);
    look_at(backend);
    pack(backend, kept);
    if (arrays_->view.sh_rest.is_packed()) arrays_->own.sh_rest = std::vector<float>();
  }

  /// A copy of `arrays`, in the memory of `reuse` if that has its own and nobody else has it. Throws as
  /// above, and leaves `reuse` as it is then. `arrays` do not lie in it.
  template <class B>
  static HostScene copy(const B& backend, const SceneArrays& arrays, std::optional<HostScene>& reuse) {
    validate(arrays);
    Scene scene;
    // Numbers that are refused must not reach the memory of a scene that stays.
    if (reuse && reuse->arrays_.use_count() == 1 && !reuse->arrays_->of_caller &&
        would_be_finite(backend, arrays))
      scene = std::move(std::exchange(reuse, std::nullopt)->arrays_->own);
    copy_scene(backend, arrays, scene);
    return HostScene(backend, std::move(scene), HarmonicsKept::floats);
  }

  /// Arrays of the caller, which outlive all frames of it and may change between them. Numbers are not
  /// checked.
  static HostScene borrow(const SceneView& view) {
    HostScene scene;
    scene.arrays_->view = view, scene.arrays_->borrowed = true;
    return scene;
  }

  /// Replaces Gaussians from number `first` on by those of `arrays`; null arrays keep the scene's values. All
  /// copies of this object change too. No frame of the scene may be under way, and `arrays` do not lie in the
  /// scene. The caller's own scene never changes: the first update of a shared scene copies it, and only
  /// this update moves the arrays of `view`. Earlier views live as long as the caller's scene. SH bands that
  /// were zero throughout show in views taken after the update.
  ///
  /// Throws `InvalidArgument`, and changes nothing, as `validate_update`, `require_replaceable` and
  /// `validate_numbers` do.
  template <class B>
  void update(const B& backend, std::size_t first, const SceneArrays& arrays) {
    if (arrays_->borrowed) throw InvalidArgument(update_of_borrowed);
    require_replaceable(arrays_->view.sh_rest, arrays);
    validate_update(arrays_->scene(), first, arrays);
    require_finite(backend, first, arrays);
    if (arrays.count == 0) return;
    if (arrays_->of_caller) make_own();
    Scene& scene = arrays_->own;
    SceneView& view = arrays_->view;
    const std::size_t end = first + arrays.count;
    const int sh_stride = view.sh_rest.is_packed() ? 0 : 3 * sh_rest_count(scene.sh_degree);
    copy_arrays(backend, arrays, SceneCapacity::of(scene, first, sh_stride, scene.feature_channels));
    if (arrays.sh_rest.data) view.sh_degree = std::max(view.sh_degree, used_sh_degree(scene, first, end));
    if (view.chunks.empty()) return;
    const ChunkRange chunks = chunks_to_bound(first, arrays);
    const auto bound = [&](std::size_t i) {
      arrays_->chunks[chunks.begin + i] = detail::bounds_of_chunk(view, chunks.begin + i);
    };
    backend.for_each(Count{chunks.size()}, bound);
  }

  SceneView view() const { return arrays_->view; }

 private:
  struct Arrays {
    bool borrowed = false;                   ///< `view` is all there is
    std::shared_ptr<const Scene> of_caller;  ///< null: `own` is the scene
    Scene own;
    std::vector<ChunkBounds> chunks;
    std::shared_ptr<const void> packed;  ///< buffer of harmonics, if they are not the scene's floats
    std::vector<std::uint16_t> labels;   ///< of a palette
    SceneView view;

    const Scene& scene() const { return of_caller ? *of_caller : own; }
  };

  HostScene() : arrays_(std::make_shared<Arrays>()) {}

  template <class B>
  void look_at(const B& backend) {
    Arrays& arrays = *arrays_;
    arrays.view = swiftgs::view(arrays.scene());
    validate_numbers(backend, arrays.scene());
    arrays.chunks = chunk_bounds(arrays.view);
    arrays.view.chunks = {arrays.chunks.data(), arrays.chunks.size()};
    arrays.view.identity = new_scene_identity();
  }

  template <class B>
  void pack(const B& backend, HarmonicsKept kept) {
    const HarmonicPacking packing(backend, arrays_->scene(), arrays_->view.sh_degree, kept);
    if (!packing.is_packed()) return;
    const auto packed = std::make_shared<typename B::template Buffer<unsigned char>>();
    packed->reset_exactly(packing.rows() * packing.stride());
    arrays_->packed = packed;
    arrays_->labels.assign(packing.labels().begin(), packing.labels().end());
    unsigned char* const to = packed->data();
    backend.for_each(Count(packing.rows()),
                     [&](std::size_t i) { packing.write(i, to + i * packing.stride()); });
    arrays_->view.sh_rest = packing.rows_at(to, arrays_->labels.data());
  }

  void make_own() {
    arrays_->own = *arrays_->of_caller;
    arrays_->of_caller.reset();
    const HarmonicRows packed = arrays_->view.sh_rest;
    for_each_array(
        [](const char*, std::size_t, const auto& values, auto& rows) { rows.data = values.data(); },
        arrays_->own, arrays_->view);
    if (packed.is_packed()) arrays_->view.sh_rest = packed, arrays_->own.sh_rest = std::vector<float>();
  }

  template <class B>
  static void require_finite(const B& backend, std::size_t first, const SceneArrays& arrays) {
    if (would_be_finite(backend, arrays)) return;
    SceneArrays given = arrays;
    if (!given.sh_rest.data) given.sh_degree = 0;
    if (!given.features.data) given.feature_channels = 0;
    Scene scene;
    copy_scene(backend, given, scene);
    validate_numbers(scene, first);
  }

  std::shared_ptr<Arrays> arrays_;
};

}  // namespace swiftgs
