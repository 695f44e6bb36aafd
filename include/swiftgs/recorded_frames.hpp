// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <swiftgs/backend.hpp>
#include <swiftgs/frame_plan.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/modelled_views.hpp>
#include <swiftgs/placed_scene.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/tiles.hpp>
#include <swiftgs/view.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

/// Views and placed scenes of recorded frames on backend `B`, and their reservation. Until the next
/// reservation, only data that replayed work reads from memory may change.
template <class B>
class RecordedFrames {
 public:
  const Views& views() const { return views_; }
  const PanoramaParts& parts() const { return parts_; }
  const PlacedScenes& scenes() const { return scenes_; }

  /// Takes what to reserve for. Nothing is reserved until `reserve`.
  void prepare(B& b, const PlacedScenes& scenes, Span<const View> views) {
    reserved_.reset();
    for (const PlacedScene& placed : scenes.each()) validate(placed);
    take_views(b, views, scenes);
    scenes_ = {}, alone_ = scenes.is_alone();
    models_.clear();
    for (const PlacedScene& placed : scenes.each()) models_.push_back(placed.scene.model);
    scenes_ =
        store_scenes(b, scenes, views_.each, scene_storage_, alone_ ? ViewAccess::any : ViewAccess::stored);
  }
  Reservation reservation(const Capacity& capacity) const {
    return {scenes_.gaussians(), scenes_.chunks(), views_.size(), views_.tiles, capacity};
  }
  void reserve(const Reservation& reserved) { reserved_ = reserved; }
  /// Throws `std::invalid_argument`, and changes nothing, for invalid views and for views that differ from
  /// the reserved ones in more than may change.
  void set_views(B& b, Span<const View> views) { take_views(b, views, scenes_); }

  /// Takes placed scenes, and throws likewise.
  void set_scenes(B& b, const PlacedScenes& scenes) {
    for (const PlacedScene& placed : scenes.each()) validate(placed);
    detail::require_for_render(reserved_.has_value(), "reserve before set_scenes");
    if (alone_ || scenes.size() != scenes_.size())
      detail::refuse("set_scenes: the number of placed scenes is ", scenes.size(), ", expected ",
                     alone_ ? "a scene alone" : std::to_string(scenes_.size()), " as reserved");
    for (std::size_t i = 0; i < scenes.size(); ++i)
      if (scenes.each()[i].size() != scenes_.each()[i].size())
        detail::refuse("set_scenes: placed scene ", i, " has ", scenes.each()[i].size(),
                       " Gaussians, expected ", scenes_.each()[i].size(), " as reserved");
    check_models(scenes);
    for (const View& view : views_.each) check_shown(scenes, view);
    check_ready(b);
    if (scenes.each().data == scenes_.each().data) return;  // changed where they are
    scenes_ = store_scenes(b, scenes, views_.each, scene_storage_, ViewAccess::stored);
  }

  /// Placed scenes in memory of the backend; null on a device for a scene alone.
  PlacedScene* stored_scenes() {
    if (!B::reaches_host_memory && !scenes_.is_stored()) return nullptr;
    return const_cast<PlacedScene*>(scenes_.reachable());
  }
  /// Indices of placed scenes that the last frame refused to draw. Waits for the frame.
  std::vector<std::size_t> refused_scenes(const B& b) const {
    std::vector<std::size_t> refused;
    if (!scenes_.is_stored()) return refused;
    std::vector<PlacedScene> now(scenes_.size());
    b.download(Span<const PlacedScene>{scenes_.reachable(), now.size()}, now.data());
    for (std::size_t i = 0; i < now.size(); ++i)
      if (now[i].refused != 0) refused.push_back(i);
    return refused;
  }

  /// A frame of `scenes` that reports to `report`. Throws `std::invalid_argument` if nothing is reserved, and
  /// `CapacityError` if it was reserved for fewer Gaussians.
  FramePlan plan(const PlacedScenes& scenes, FrameReport* report) const {
    detail::require_for_render(reserved_ && views_.size() != 0, "reserve before record");
    detail::require_for_render(report != nullptr, "memory for the report");
    check_models(scenes);
    if (scenes.gaussians() > reserved_->gaussians)
      throw CapacityError("Gaussians in a recorded frame", scenes.gaussians(), reserved_->gaussians);
    return FramePlan(views_, scenes, {reserved_->capacity, true, report});
  }

  static auto buffers(auto& self) { return std::tie(self.view_storage_, self.scene_storage_); }

 private:
  void take_views(B& b, Span<const View> views, const PlacedScenes& scenes) {
    for (const View& view : views) validate(view), detail::check_tiles(view);
    PanoramaParts parts;
    ModelledViews modelled;
    views = modelled.of(parts.of(views), scenes);
    if (reserved_) check_suits(views);
    check_ready(b);
    const bool through_lens = reserved_ && views_.through_lens;
    views_ = {};
    views_ = store_views(b, views, view_storage_, ViewAccess::stored);
    views_.through_lens |= through_lens;
    parts_ = std::move(parts);
  }

  /// Stored views follow the models of the scenes that were reserved for.
  void check_models(const PlacedScenes& scenes) const {
    for (std::size_t i = 0; i < scenes.size() && i < models_.size(); ++i)
      if (scenes.each()[i].scene.model != models_[i])
        detail::refuse("render: placed scene ", i,
                       " was trained for another rendering model, expected that of the one reserved for");
  }

  void check_suits(Span<const View> views) const {
    if (views.size != views_.size())
      detail::refuse("set_views: the number of views is ", views.size, ", expected ", views_.size(),
                     " as reserved");
    for (std::size_t i = 0; i < views.size; ++i) {
      if (!same_shape(views[i], views_[i]))
        detail::refuse("set_views: the size, the planes or the conversion of colours of view ", i,
                       " changed, expected those that were reserved");
      if (views[i].camera.through_lens && !views_.through_lens)
        detail::refuse("set_views: view ", i,
                       " is no pinhole that takes depth z alone, by its lens, depth or order; expected those "
                       "as reserved");
    }
  }

  /// Whether frames of `a` and `b` have the same size, placed scenes and planes, and both or neither convert
  /// colours.
  static bool same_shape(const View& a, const View& b) {
    bool same = a.frame.width == b.frame.width && a.frame.height == b.frame.height &&
                a.grid.side == b.grid.side && !a.frame.occluder.data == !b.frame.occluder.data;
    for_each_plane([&](std::size_t, auto& of_a, auto& of_b) { same = same && !of_a.data == !of_b.data; },
                   a.frame, b.frame);
    same = same && a.frame.feature_channels == b.frame.feature_channels;
    same = same && (a.frame.conversion == Conversion::as_is) == (b.frame.conversion == Conversion::as_is);
    same = same && a.shows.first == b.shows.first && a.shows.count == b.shows.count;
    return same && attribute_count(a) == attribute_count(b);
  }

  ViewStorage<B> view_storage_;
  SceneStorage<B> scene_storage_;
  Views views_;          ///< in `view_storage_`
  PlacedScenes scenes_;  ///< in `scene_storage_`
  PanoramaParts parts_;
  bool alone_ = false;                  ///< whether the reservation was for a scene alone
  std::vector<RenderingModel> models_;  ///< of the scenes of the reservation
  std::optional<Reservation> reserved_;
};

}  // namespace swiftgs
