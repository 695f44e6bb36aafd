// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include <swiftgs/backend.hpp>
#include <swiftgs/count.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/modelled_views.hpp>
#include <swiftgs/placed_scene.hpp>
#include <swiftgs/raster/passes.hpp>
#include <swiftgs/render_input.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

/// Scenes and the sizes of the images that show them. What one frame teaches holds for frames of the same
/// key.
struct FrameKey {
  std::uint64_t scene = 0;  ///< `StoredScenes::identity`
  std::size_t gaussians = 0;
  /// Of all views, one below the other. @units{pixels}
  std::int64_t width = 0, height = 0;
  std::size_t views = 1;

  static FrameKey of(const StoredScenes& scenes, Span<const View> views) {
    FrameKey key{.scene = scenes.identity(), .gaussians = scenes.gaussians(), .views = views.size};
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

/// Throws `InvalidArgument` if `view` shows scenes that a frame of `scenes` does not have, or features
/// that these do not have.
inline void check_shown(const auto& scenes, const View& view) {
  const auto [first, count] = view.shows;
  const bool all = count == ShownScenes().count;
  if (first > scenes.size() || (!all && count > scenes.size() - first))
    detail::refuse("render: a view shows ", all ? "all" : std::to_string(count),
                   " placed scenes from number ", first, " on, expected some of the frame's ", scenes.size());
  if (!view.request.features) return;
  for (const PlacedScene& placed : scenes.shown(view))
    require_features(placed.scene, view.frame.feature_channels);
}

/// One frame, as all stages see it. What it points to lives until the last stage has been started.
///
///     cameras, conventions, memory --make_view--> View --store_views--> Views --+
///                                                              placed scenes ---+--> FramePlan --> stages
///                                                                      limits --+
///
/// Whoever makes one has checked its input: `Views` its views and tiles, this constructor the placed scenes.
/// Stages trust it.
struct FramePlan {
  Views views;
  StoredScenes scenes;
  Limits limits;
  RasterPasses passes;

  /// Throws `InvalidArgument` as `validate` does of each placed scene, as `require_features`, and for a
  /// view that shows scenes which the frame does not have.
  FramePlan(const Views& of_views, const StoredScenes& of_scenes, const Limits& within = {})
      : views(of_views), scenes(of_scenes), limits(within), passes(attribute_count(of_views.each)) {
    for (const PlacedScene& placed : scenes.each()) validate(placed);
    for (const View& view : views) check_shown(scenes, view);
  }

  FrameKey key() const { return FrameKey::of(scenes, views.each); }
  FrameUse use() const {
    return !limits.draw ? FrameUse::rehearsed : limits.report ? FrameUse::recorded : FrameUse::drawn;
  }

  /// Pairs of a view and a Gaussian that it may show.
  std::size_t candidates() const {
    std::size_t all = 0;
    for (const View& view : views) all += scenes.gaussians_of(view);
    return all;
  }
};

/// Memory of plans. What a plan points to holds until the next plan that uses the same memory.
template <class B>
struct PlanMemory {
  PanoramaParts parts;
  ModelledViews modelled;  ///< of the views in `parts`
  ViewStorage<B> views;
  SceneStorage<B> scenes;
};

/// Plans a frame of valid views: cuts panoramas, gives views their requests and the models of their scenes,
/// lets `choose(scenes, views)` choose tiles, and stores all where loops of the backend read it. Throws
/// `InvalidArgument` where nothing can be rendered, and `CapacityError` beyond the limits of a frame.
template <class B, class Choose>
FramePlan plan_frame(B& b, const PlacedScenes& scenes, Span<const View> views, PlanMemory<B>& memory,
                     const Choose& choose) {
  views = memory.modelled.of(memory.parts.of(views), scenes);
  check_ready(b);
  const StoredScenes stored = store_scenes(b, scenes, views, memory.scenes);
  return FramePlan(store_views(b, choose(stored, views), memory.views), stored);
}

}  // namespace swiftgs
