// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/passes.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/render_input.hpp>
#include <swiftgs/frame/rendering_model.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/srgb.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

namespace detail {
/// The order and the colours that a view leaves to the scenes that it shows, empty ones apart; `v` is its
/// number in the frame.
inline RenderingModel common_model(const auto& shown, const View& view, std::size_t v) {
  RenderingModel common;
  bool some = false;
  for (const PlacedScene& placed : shown) {
    if (placed.size() == 0) continue;
    const RenderingModel& model = placed.scene.model;
    if (!some) some = true, common.colours = model.colours;
    if (view.colours_of_scenes && model.colours != common.colours)
      refuse("render: view ", v,
             " shows scenes of sRGB-encoded colours and of linear ones, expected one kind, ",
             "or conventions that name the colours to blend (--model colours=srgb of commands)");
    if (model.order == SplatOrder::distance) common.order = SplatOrder::distance;
  }
  return common;
}

/// Lets `view` blend in linear light, and have the same kind of values as before.
inline void blend_in_linear_light(View& view) {
  Conversion& conversion = view.frame.conversion;
  if (conversion == Conversion::linear_to_srgb) return;  // the caller's own way to say so
  conversion = conversion == Conversion::as_is ? Conversion::linear_to_srgb : Conversion::as_is;
  for (int c = 0; c < 3; ++c) view.background[c] = from_srgb(view.background[c]);
}

/// `view` with its request, and nothing left to the scenes of its frame but what may differ among them, which
/// `eye` finds. Throws `InvalidArgument` as `PlannedViews`.
inline View modelled(View view, const auto& shown, std::size_t v) {
  const RenderingModel common = common_model(shown, view, v);
  view.request = view.asked();
  const bool ends_at_occluder = view.request.occluder;
  if (view.order_of_scenes && common.order == SplatOrder::distance && !ends_at_occluder &&
      !view.camera.depth_is_distance)
    view.camera.order_by_distance();
  if (view.camera.order_is_distance && ends_at_occluder)
    refuse("render: view ", v, " has an occluder and is ordered by distance, expected order by depth");
  const ColourSpace colours = view.colours_of_scenes ? common.colours : view.colours;
  if (colours == ColourSpace::linear) blend_in_linear_light(view);
  if (shown.size == 1) view.camera.follow(shown[0].scene.model);
  view.order_of_scenes = view.colours_of_scenes = false, view.colours = ColourSpace::srgb;
  return view;
}
}  // namespace detail

/// Views as a frame draws them: panoramas in parts, and all as their scenes were trained to be drawn where
/// conventions leave it to them.
class PlannedViews {
 public:
  /// Copies of `views`, which hold until the next call. Throws `InvalidArgument` as `PanoramaParts`, if a
  /// view leaves the kind of colours to scenes of both kinds, and if one with an occluder is ordered by
  /// distance.
  Span<const View> of(Span<const View> views, const auto& scenes) {
    const Span<const View> parts = parts_.of(views);
    views_.clear();
    for (std::size_t v = 0; v < parts.size; ++v)
      views_.push_back(detail::modelled(parts[v], scenes.shown(parts[v]), v));
    return {views_.data(), views_.size()};
  }

  /// As `PanoramaParts::owners`.
  Span<const std::uint32_t> owners() const { return parts_.owners(); }

 private:
  PanoramaParts parts_;
  std::vector<View> views_;
};

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
  PlannedViews planned;
  ViewStorage<B> views;
  SceneStorage<B> scenes;

  static auto buffers(auto& self) { return std::tie(self.views, self.scenes); }
};

/// Plans a frame of valid views: cuts panoramas, gives views their requests and the models of their scenes,
/// lets `choose(scenes, views)` choose tiles, and stores all where loops of the backend read it. Throws
/// `InvalidArgument` where nothing can be rendered, and `CapacityError` beyond the limits of a frame.
template <class B, class Choose>
FramePlan plan_frame(B& b, const PlacedScenes& scenes, Span<const View> views, PlanMemory<B>& memory,
                     const Choose& choose) {
  views = memory.planned.of(views, scenes);
  check_ready(b);
  const StoredScenes stored = store_scenes(b, scenes, views, memory.scenes);
  return FramePlan(store_views(b, choose(stored, views), memory.views), stored);
}

}  // namespace swiftgs
