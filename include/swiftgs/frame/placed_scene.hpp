// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Placed scenes: the scenes of one frame, each at its pose in the world. Gaussians are numbered over the
/// frame, the first placed scene's first; ids and picks are these numbers.

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/frame/render_input.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// A scene in a frame, its placing, and which of its Gaussians show. To show a range of its Gaussians, place
/// a `SceneView` of that range (`range_of`).
struct PlacedScene {
  SceneView scene{};
  Similarity world_from_scene{};
  float opacity = 1;  ///< times the opacities of its Gaussians, 0 to 1
  Clip clip{};
  Tint tint{};

  SWIFTGS_HD std::size_t size() const { return scene.size(); }
  SWIFTGS_HD std::uint32_t chunks() const {
    return std::uint32_t((scene.size() + chunk_size - 1) / chunk_size);
  }
  /// Whether a frame can draw it.
  SWIFTGS_HD bool is_valid() const {
    return !detail::unmet_of_placing(world_from_scene, opacity, clip, tint);
  }
  /// Whether a frame shows it as it shows the scene alone.
  SWIFTGS_HD bool is_plain() const {
    return world_from_scene.is_identity() && opacity == 1 && clip.shows_all() && tint.is_none();
  }
};

/// Throws `InvalidArgument` where nothing can be rendered of `placed`. Reads no Gaussian.
inline void validate(const PlacedScene& placed) {
  validate(placed.scene);
  detail::validate_placing(placed.world_from_scene, placed.opacity, placed.clip, placed.tint);
}

/// Gaussians [first, first + count) of `scene`. Where `first` is no
/// multiple of `chunk_size`, no chunk of them is skipped. Throws `InvalidArgument` if the scene has
/// fewer.
inline SceneView range_of(const SceneView& scene, std::size_t first, std::size_t count) {
  if (first > scene.size() || count > scene.size() - first)
    detail::refuse("range_of: Gaussians ", first, " and ", count, " on, expected a range of the scene's ",
                   scene.size());
  SceneView range = scene;
  if (count != scene.size() && scene.identity != 0)
    range.identity = scene.identity * 0x9e3779b97f4a7c15 + first * 0xff51afd7ed558ccd + count;
  for_each_array([&](const char*, std::size_t, auto& array) { array = array.part(first, count); }, range);
  const std::size_t chunks = (count + chunk_size - 1) / chunk_size;
  if (range.chunks.size != 0)
    range.chunks = first % chunk_size == 0
                       ? Span<const ChunkBounds>{scene.chunks.data + first / chunk_size, chunks}
                       : Span<const ChunkBounds>{};
  return range;
}

/// Scenes of a frame, placed or stored: a copy of one, or several where they lie.
template <class Scene>
class ScenesOf {
 public:
  Span<const Scene> each() const { return is_one_ ? Span<const Scene>{&one_, 1} : each_; }
  std::size_t size() const { return each().size; }
  /// Whether the frame shows one scene alone, as it stands by itself.
  bool is_alone() const { return size() == 1 && each()[0].is_plain(); }
  /// The scenes that `view` shows.
  Span<const Scene> shown(const View& view) const {
    const std::size_t first = std::min(std::size_t(view.shows.first), size());
    return {each().data + first, std::min(std::size_t(view.shows.count), size() - first)};
  }

 protected:
  explicit ScenesOf(const Scene& one) : one_(one) {}
  explicit ScenesOf(Span<const Scene> several) : is_one_(false), each_(several) {}

 private:
  bool is_one_ = true;
  Scene one_{};
  Span<const Scene> each_{};
};

/// What a frame shows: a scene alone, or placed scenes of the caller; their arrays live until the frame is
/// finished. Where a function asks for this, give it either, or an uploaded scene.
class PlacedScenes : public ScenesOf<PlacedScene> {
 public:
  PlacedScenes(const SceneView& scene) : ScenesOf(PlacedScene{scene}) {}
  template <class Uploaded>
  requires requires(const Uploaded& scene) {
    { scene.view() } -> std::same_as<SceneView>;
  }
  PlacedScenes(const Uploaded& scene) : PlacedScenes(scene.view()) {}
  PlacedScenes(Span<const PlacedScene> scenes) : ScenesOf(scenes) {}
  PlacedScenes(const std::vector<PlacedScene>& scenes) : PlacedScenes(Span{scenes.data(), scenes.size()}) {}
};

/// Where a Gaussian of a frame comes from.
struct PlacedIndex {
  std::size_t scene, gaussian;  ///< index of the placed scene, and of the Gaussian in it
};

/// Finds the Gaussian with this number in a frame of `scenes`, as ids and picks tell it. Throws
/// `InvalidArgument` if no Gaussian has the number, such as `no_gaussian`.
inline PlacedIndex placed_index(const PlacedScenes& scenes, std::uint32_t number) {
  std::size_t first = 0;
  for (std::size_t i = 0; i < scenes.size(); first += scenes.each()[i].size(), ++i)
    if (number - first < scenes.each()[i].size()) return {i, number - first};
  detail::refuse("placed_index: the Gaussian is ", number, ", expected less than ", first);
}

/// Throws `InvalidArgument` where a frame asks for features that one of `scenes` does not have.
inline void require_features(const PlacedScenes& scenes, int channels) {
  for (const PlacedScene& placed : scenes.each()) require_features(placed.scene, channels);
}

}  // namespace swiftgs
