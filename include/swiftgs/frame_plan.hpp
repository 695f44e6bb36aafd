// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <swiftgs/count.hpp>
#include <swiftgs/render_input.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

/// A scene and the sizes of the images that show it. What one frame teaches holds for frames of the same key.
struct FrameKey {
  std::uint64_t scene = 0;  ///< `SceneView::identity`
  std::size_t gaussians = 0;
  /// Of all views, one below the other. @units{pixels}
  std::int64_t width = 0, height = 0;
  std::size_t views = 1;

  static FrameKey of(const SceneView& scene, Span<const View> views) {
    FrameKey key{.scene = scene.identity, .gaussians = scene.size(), .views = views.size};
    for (const View& view : views)
      key.width = std::max<std::int64_t>(key.width, view.frame.width), key.height += view.frame.height;
    return key;
  }

  bool operator==(const FrameKey&) const = default;
};

/// What a frame is for.
enum class FrameUse {
  drawn,
  recorded,  ///< may run again, and asks the backend for nothing
  rehearsed  ///< draws nothing: a sort takes all memory that later frames of this capacity may need
};

/// One frame, as all stages see it. What it points to lives until the last stage has been started.
///
///     cameras, conventions, memory --make_view--> View --store_views--> Views --+
///                                                                       scene --+--> FramePlan --> stages
///                                                                      limits --+
///
/// Whoever makes one has checked its input: `Views` its views and tiles, this constructor the scene. Stages
/// trust it.
struct FramePlan {
  Views views;
  SceneView scene;
  Limits limits;

  /// Throws `std::invalid_argument` as `validate` does of the scene, and as `require_features`.
  FramePlan(const Views& of_views, const SceneView& of_scene, const Limits& within = {})
      : views(of_views), scene(of_scene), limits(within) {
    validate(scene);
    require_features(scene, views.each);
  }

  FrameKey key() const { return FrameKey::of(scene, views.each); }
  FrameUse use() const {
    return !limits.draw ? FrameUse::rehearsed : limits.report ? FrameUse::recorded : FrameUse::drawn;
  }
};

}  // namespace swiftgs
