// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/render_input.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// Throws `Unavailable`: backend `B` has no function `what`.
template <class B>
[[noreturn]] void refuse_missing(const char* what) {
  throw Unavailable("backend " + std::string(B::name) + ": expected a function " + what);
}

/// The scenes that a renderer on backend `B` keeps by number, their placing in its frames, and its recorded
/// scenes. It has the functions of `AnyRenderer`, which throw `Unavailable` where the backend lacks one.
template <class B>
class KeptScenes {
 public:
  using SceneOn = typename B::SceneOn;

  template <class... Given>
  static SceneOn upload(B& b, Given&&... given) {
    if constexpr (requires { b.upload(std::forward<Given>(given)...); })
      return b.upload(std::forward<Given>(given)...);
    else
      refuse_missing<B>("upload of scenes to keep");
  }

  void set(B& b, std::shared_ptr<const Scene> scene, HarmonicsKept kept) {
    scene_.emplace(upload(b, std::move(scene), kept));
    show_alone();
  }
  void set(B& b, const SceneArrays& arrays) {
    scene_.emplace(upload(b, arrays, scene_));
    show_alone();
  }
  void borrow(const SceneArrays& arrays) {
    if constexpr (requires(SceneView view) { SceneOn::borrow(view); })
      scene_.emplace(SceneOn::borrow(view(arrays)));
    else
      refuse_missing<B>("SceneOn::borrow");
    show_alone();
  }
  std::size_t add(B& b, std::shared_ptr<const Scene> scene, HarmonicsKept kept) {
    if (!scene_) {
      set(b, std::move(scene), kept);
      return 0;
    }
    more_.push_back(upload(b, std::move(scene), kept));
    show(placed_, {.scene = more_.size()}), of_caller_.reset();
    return more_.size();
  }
  const char* harmonics(std::size_t scene) const {
    require_known("harmonics", scene);
    return name_of(numbered(scene).view().sh_rest);
  }
  void update(B& b, std::size_t scene, std::size_t first, const SceneArrays& arrays) {
    require_known("update_scene", scene);
    SceneOn& on = scene == 0 ? *scene_ : more_[scene - 1];
    if constexpr (requires { b.update(on, first, arrays); })
      b.update(on, first, arrays);
    else
      refuse_missing<B>("update");
  }
  void place(Span<const Placement> placements) {
    if (placements.empty()) throw InvalidArgument("place: expected one placement or more");
    Placed placed;
    for (const Placement& p : placements) {
      require_known("place", p.scene);
      require_range(placed.each.size(), p);
      show(placed, p);
      validate(placed.each.back());
    }
    placed_ = std::move(placed), of_caller_.reset();
  }
  void show(Span<const PlacedScene> scenes) {
    for (const PlacedScene& each : scenes) validate(each);
    of_caller_.emplace(scenes.begin(), scenes.end());
  }
  bool share(const KeptScenes& other) {
    if (!other.scene_) return false;
    scene_ = other.scene_, more_ = other.more_, placed_ = other.placed_, of_caller_.reset();
    recorded_.reset();
    return true;
  }

  /// What frames show. Throws `OrderError` before a scene is set.
  PlacedScenes scenes() {
    if (of_caller_) return *of_caller_;
    if (!scene_) throw OrderError("render: expected a scene before the first frame");
    update_views(placed_, placed_.each.data());
    return placed_.each;
  }

  /// Tells that recorded frames show what is placed now; `alone`: a scene alone, which may change.
  void note_recorded(bool alone) {
    recorded_.reset();
    if (!alone) recorded_ = of_caller_ ? Placed{*of_caller_, {}} : placed_;
  }
  /// Whether recorded frames show placed scenes, and those are still there.
  bool records_placed() const { return recorded_.has_value(); }
  /// The scene alone that they show otherwise. Throws `InvalidArgument` if others are placed now.
  SceneView recorded_alone() {
    const PlacedScenes now = scenes();
    detail::require_for_render(now.is_alone(), "reserve or set_recorded_scenes after other scenes were set");
    return now.each()[0].scene;
  }
  /// Gives the placed scenes of recorded frames, which lie in `stored`, the views that their scenes have now.
  void update_recorded(StoredScene* stored) const { update_views(*recorded_, stored); }

 private:
  /// Placed scenes, and the placement of each.
  struct Placed {
    std::vector<PlacedScene> each;
    std::vector<Placement> placements;
  };

  void show(Placed& placed, const Placement& p) const {
    placed.each.push_back({view_of(p), p.world_from_scene, p.opacity, p.clip, p.tint});
    placed.placements.push_back(p);
  }
  /// The first scene, where it stands by itself.
  void show_alone() {
    more_.clear(), placed_ = {}, of_caller_.reset(), recorded_.reset();
    show(placed_, {});
  }

  void require_known(const char* call, std::size_t scene) const {
    const std::size_t known = scene_ ? 1 + more_.size() : 0;
    if (scene >= known) detail::refuse(call, ": the scene is number ", scene, ", expected less than ", known);
  }
  void require_range(std::size_t number, const Placement& p) const {
    const std::size_t size = numbered(p.scene).view().size();
    if (p.first <= size && (p.count == Placement::all || p.count <= size - p.first)) return;
    detail::refuse("place: placement ", number, " shows ",
                   p.count == Placement::all ? "all" : std::to_string(p.count), " Gaussians from number ",
                   p.first, " on, expected some of the ", size, " of scene ", p.scene);
  }
  const SceneOn& numbered(std::size_t scene) const { return scene == 0 ? *scene_ : more_[scene - 1]; }
  SceneView view_of(const Placement& p) const {
    const SceneView whole = numbered(p.scene).view();
    return range_of(whole, p.first, std::min(p.count, whole.size() - p.first));
  }
  /// Gives `each` of `placed` the view that its scene has now: a host's first update of a scene moves it.
  void update_views(const Placed& placed, auto* each) const {
    for (std::size_t i = 0; i < placed.placements.size(); ++i) each[i].scene = view_of(placed.placements[i]);
  }

  std::optional<SceneOn> scene_{};  ///< copies share the memory
  std::vector<SceneOn> more_{};     ///< after it
  Placed placed_{};
  std::optional<std::vector<PlacedScene>> of_caller_{};  ///< shown in place of `placed_`
  std::optional<Placed> recorded_{};  ///< none for a scene alone; of the caller: no placements
};

}  // namespace swiftgs
