// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <swiftgs/conventions.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/placed_scene.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/srgb.hpp>
#include <swiftgs/views.hpp>

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
/// `eye` finds. Throws `InvalidArgument` as `ModelledViews`.
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

/// Views as their scenes were trained to be drawn, where conventions leave it to them.
class ModelledViews {
 public:
  /// Copies of `views`, which hold until the next call. Throws `InvalidArgument` if a view leaves the
  /// kind of colours to scenes of both kinds, and if one with an occluder is ordered by distance.
  Span<const View> of(Span<const View> views, const auto& scenes) {
    views_.clear();
    for (std::size_t v = 0; v < views.size; ++v)
      views_.push_back(detail::modelled(views[v], scenes.shown(views[v]), v));
    return {views_.data(), views_.size()};
  }

 private:
  std::vector<View> views_;
};

}  // namespace swiftgs
