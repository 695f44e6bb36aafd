// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Placed scenes as the stages of a frame read them: stored in the renderer's memory, their Gaussians and
/// chunks numbered, each seen from its own space.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/view_constants.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// A placed scene in a frame's own memory, and what the library keeps beside it.
struct StoredScene : PlacedScene {
  std::uint32_t first_gaussian = 0;  ///< Gaussians of the placed scenes before it
  std::uint32_t first_chunk = 0;     ///< chunks of the placed scenes before it
  /// 1: a device did not draw the scene, since its pose, opacity, clip or tint is not valid. Kernels of the
  /// program may have written them.
  mutable std::uint32_t refused = 0;
};

/// An element of the rotation from the space of a placed scene to that of a camera.
SWIFTGS_HD inline double eye_rotation(const ViewConstants& camera, const Similarity& world_from_scene,
                                      int row, int column) {
  const dvec3& axis = world_from_scene.rotation[column];
  const double* of = camera.rotation[row];
  return std::fma(of[0], axis.x, std::fma(of[1], axis.y, of[2] * axis.z));
}
/// A coordinate of the camera's centre in the space of a placed scene, by Cramer's rule: to take a rotation's
/// transpose for its inverse would move the scene by as much as the rotation may be off.
SWIFTGS_HD inline double eye_centre(const ViewConstants& camera, const Similarity& world_from_scene, int k) {
  const dmat3& rotation = world_from_scene.rotation;
  const dvec3 &axis = rotation[k], &a = rotation[(k + 1) % 3], &b = rotation[(k + 2) % 3];
  const dvec3 across = cross(a, b);
  const dvec3& to = world_from_scene.translation;
  const double x = camera.centre[0] - to.x, y = camera.centre[1] - to.y, z = camera.centre[2] - to.z;
  const double along = std::fma(across.x, x, std::fma(across.y, y, across.z * z));
  return along / (world_from_scene.scale * dot(across, axis));
}
/// The focal length `of_camera` in the space of a placed scene. Only parallel rays tell lengths.
SWIFTGS_HD inline double eye_focal(const ViewConstants& camera, const Similarity& world_from_scene,
                                   double of_camera) {
  return camera.lens.model == LensModel::orthographic ? of_camera * world_from_scene.scale : of_camera;
}

/// The camera in the space of a placed scene. An image stays as it is when the camera and what it sees are
/// moved and scaled together, so the eye sees the scene's own numbers as the camera sees the placed ones.
/// Only parallel rays need other focal lengths. Harmonics turn with the scene: directions are in its own
/// space. Depths are those of the world.
/// Only devices that project by `pairs` set them: a host whose eye goes to a device calls
/// `set_pairs`.
SWIFTGS_HD inline ViewConstants eye(const ViewConstants& camera, const PlacedScene& placed) {
  ViewConstants out = camera;
  out.opacity = placed.opacity, out.follow(placed.scene.model);
  const Similarity& pose = placed.world_from_scene;
  if (pose.is_identity()) return out;  // to the sign of its zeros
  for (int row = 0; row < 3; ++row) {
    out.centre[row] = eye_centre(camera, pose, row);
    for (int column = 0; column < 3; ++column) {
      out.rotation[row][column] = eye_rotation(camera, pose, row, column);
      out.axes[row][column] = float(out.rotation[row][column]);
    }
  }
  out.fx = eye_focal(camera, pose, camera.fx), out.fy = eye_focal(camera, pose, camera.fy);
  out.focal_x = float(out.fx), out.focal_y = float(out.fy);
  out.depth_scale = pose.scale;
  if constexpr (projects_in_pairs) out.set_pairs();
  return out;
}

/// A Gaussian, and the camera that sees it in its scene's space.
template <class Camera>
struct SeenGaussian {
  Camera camera;
  const SceneView& scene;
  std::size_t i;  ///< in the scene
  Tint tint{};
};

/// The only scene of a frame, where it stands by itself. Loops read scenes as this or as `SeveralScenes`.
struct OneScene {
  static constexpr bool only = true;
  SceneView scene;

  SWIFTGS_HD SeenGaussian<const ViewConstants&> see(const ViewConstants& camera, std::uint32_t number) const {
    return {camera, scene, number};
  }
};

/// Placed scenes in memory of the backend.
struct SeveralScenes {
  static constexpr bool only = false;
  const StoredScene* each;
  std::uint32_t count;  ///< 1 or more

  /// The placed scene of a Gaussian.
  SWIFTGS_HD const StoredScene& of_gaussian(std::uint32_t number) const {
    return last_from(&StoredScene::first_gaussian, number);
  }
  /// The placed scene of a chunk.
  SWIFTGS_HD const StoredScene& of_chunk(std::uint32_t chunk) const {
    return last_from(&StoredScene::first_chunk, chunk);
  }
  SWIFTGS_HD SeenGaussian<ViewConstants> see(const ViewConstants& camera, std::uint32_t number) const {
    const StoredScene& placed = of_gaussian(number);
    return {eye(camera, placed), placed.scene, number - placed.first_gaussian, placed.tint};
  }

 private:
  /// The last whose first is at most `number`: it is not empty if any has that number.
  SWIFTGS_HD const StoredScene& last_from(std::uint32_t StoredScene::*first, std::uint32_t number) const {
    std::uint32_t low = 0, high = count;
    while (high - low > 1) {
      const std::uint32_t middle = low + (high - low) / 2;
      (each[middle].*first <= number ? low : high) = middle;
    }
    return each[low];
  }
};

/// Sets `stored` to copies of `scenes` with numbered Gaussians and chunks. Throws `CapacityError` for 2^32
/// Gaussians or more.
inline void number_gaussians(Span<const PlacedScene> scenes, std::vector<StoredScene>& stored) {
  const std::size_t most = std::numeric_limits<std::uint32_t>::max();
  std::size_t gaussians = 0;
  std::uint32_t chunks = 0;
  stored.clear();
  for (const PlacedScene& placed : scenes) {
    stored.push_back({placed, std::uint32_t(gaussians), chunks});
    gaussians += placed.size(), chunks += placed.chunks();
    if (gaussians > most) throw CapacityError("Gaussians in all placed scenes", gaussians, most);
  }
}

/// The scenes of a frame, as its stages read them: a scene alone, or the renderer's stored scenes, whose
/// Gaussians and chunks are numbered.
class StoredScenes : public ScenesOf<StoredScene> {
 public:
  StoredScenes(const SceneView& scene = {}) : StoredScenes(PlacedScene{scene}) {}
  explicit StoredScenes(const PlacedScene& one) : ScenesOf(StoredScene{one}) {}
  /// `on_device`: the same where a device's loops read them.
  explicit StoredScenes(const std::vector<StoredScene>& scenes, const StoredScene* on_device = nullptr)
      : ScenesOf(Span{scenes.data(), scenes.size()}), on_device_(on_device) {}

  /// Address at which loops of the backend read the scenes.
  const StoredScene* reachable() const { return on_device_ ? on_device_ : each().data; }
  bool is_on_device() const { return on_device_ != nullptr; }

  std::size_t gaussians() const { return gaussians_in(each()); }
  std::size_t gaussians_of(const View& view) const { return gaussians_in(shown(view)); }
  std::size_t chunks() const { return chunks_in(each()).end; }
  ChunkRange chunks_of(const View& view) const { return chunks_in(shown(view)); }

  /// Identity of what learns from frames; 0 if some scene has none.
  std::uint64_t identity() const {
    std::uint64_t all = 0;
    for (const StoredScene& stored : each()) {
      if (stored.scene.identity == 0) return 0;
      all = all * 0x9e3779b97f4a7c15 + stored.scene.identity;
    }
    return all;
  }

 private:
  static std::size_t gaussians_in(Span<const StoredScene> some) {
    const std::size_t last = some.size - 1;
    return some.empty() ? 0 : some[last].first_gaussian - some[0].first_gaussian + some[last].size();
  }
  static ChunkRange chunks_in(Span<const StoredScene> some) {
    if (some.empty()) return {};
    const StoredScene& last = some[some.size - 1];
    return {some[0].first_chunk, std::size_t(last.first_chunk) + last.chunks()};
  }

  const StoredScene* on_device_ = nullptr;
};

/// f(source) with the scenes as loops read them.
template <class F>
void with_scenes(const StoredScenes& scenes, const F& f) {
  if (!scenes.is_on_device() && scenes.is_alone())
    f(OneScene{scenes.each()[0].scene});
  else
    f(SeveralScenes{scenes.reachable(), std::uint32_t(scenes.size())});
}

/// A renderer's own copy of the placed scenes of a frame.
template <class B>
struct SceneStorage {
  std::vector<StoredScene> each;

  static std::tuple<> buffers(auto&) { return {}; }  ///< none in the backend's own memory
};

/// Copies and numbers placed scenes; each view shows some of them. The result holds until the next
/// call. Throws as `number_gaussians`. Backends that do not reach the host's memory overload this.
template <class B>
StoredScenes store_scenes(B&, const PlacedScenes& scenes, Span<const View>, SceneStorage<B>& storage,
                          ViewAccess = ViewAccess::any) {
  if (scenes.size() == 1) return StoredScenes(scenes.each()[0]);
  number_gaussians(scenes.each(), storage.each);
  return StoredScenes(storage.each);
}

}  // namespace swiftgs
