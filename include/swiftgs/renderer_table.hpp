// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Rows of the table of renderers.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/api.hpp>
#include <swiftgs/bound_renderer.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/placed_scene.hpp>
#include <swiftgs/scene_arrays.hpp>
#include <swiftgs/stage_table.hpp>
#include <swiftgs/type_list.hpp>

namespace swiftgs {

/// `AnyRenderer` on backend `B`: a `BoundRenderer` with its name and scene.
template <class B>
class SWIFTGS_API AnyRendererOn final : public AnyRenderer {
 public:
  AnyRendererOn(std::string name, const BackendOptions& options, const StageTable<B>& table,
                std::unique_ptr<SortStage<B>> sort)
      : name_(std::move(name)),
        renderer_(make_backend(std::type_identity<B>(), options), table, std::move(sort)) {}

  std::string_view name() const override { return name_; }
  void set_scene(std::shared_ptr<const Scene> scene, HarmonicsKept kept) override {
    scene_.emplace(renderer_.backend().upload(std::move(scene), kept));
    show_alone();
  }
  void set_scene(const SceneArrays& arrays) override {
    scene_.emplace(renderer_.backend().upload(arrays, scene_));
    show_alone();
  }
  void borrow_scene(const SceneArrays& arrays) override {
    scene_.emplace(SceneOn::borrow(view(arrays)));
    show_alone();
  }
  std::size_t add_scene(std::shared_ptr<const Scene> scene, HarmonicsKept kept) override {
    if (!scene_) {
      set_scene(std::move(scene), kept);
      return 0;
    }
    more_.push_back(renderer_.backend().upload(std::move(scene), kept));
    add(placed_, {.scene = more_.size()});
    return more_.size();
  }
  const char* harmonics(std::size_t scene) const override {
    require_known("harmonics", scene);
    return name_of((scene == 0 ? *scene_ : more_[scene - 1]).view().sh_rest);
  }
  void update_scene(std::size_t scene, std::size_t first, const SceneArrays& arrays) override {
    require_known("update_scene", scene);
    renderer_.backend().update(numbered(scene), first, arrays);
  }
  void place(Span<const Placement> placements) override {
    if (placements.empty()) throw InvalidArgument("place: expected one placement or more");
    Placed placed;
    for (const Placement& p : placements) {
      require_known("place", p.scene);
      require_range(placed.each.size(), p);
      add(placed, p);
      validate(placed.each.back());
    }
    placed_ = std::move(placed);
  }
  bool share_scene(const AnyRenderer& other) override {
    const auto* like = dynamic_cast<const AnyRendererOn*>(&other);
    if (!like || !like->scene_) return false;
    scene_ = like->scene_, more_ = like->more_, placed_ = like->placed_, recorded_.reset();
    return true;
  }
  void render(Span<const Camera> cameras, const RenderSettings& settings, Span<Frame> frames) override {
    renderer_.render(scenes(), cameras, settings, frames);
  }
  Span<const FrameView> render_resident(Span<const Camera> cameras, const RenderSettings& settings) override {
    const Span<const FrameView> frames = renderer_.render_resident(scenes(), cameras, settings);
    renderer_.backend().wait();
    return frames;
  }
  void render_into(Span<const View> views, Measures measures) override {
    renderer_.render_into(scenes(), views, measures);
  }
  void reserve(Span<const View> views, Capacity capacity) override {
    const PlacedScenes now = scenes();
    recorded_.reset();  // for good if this throws
    renderer_.reserve(now, views, capacity);
    recorded_ = placed_, recorded_alone_ = now.is_alone();
  }
  void set_views(Span<const View> views) override { renderer_.set_views(views); }
  void record(FrameReport* report) override {
    if (!recorded_ || recorded_alone_) {
      const PlacedScenes now = scenes();
      detail::require_for_render(now.is_alone(),
                                 "reserve or set_recorded_scenes after other scenes were set");
      return renderer_.record(now.each()[0].scene, report);
    }
    if constexpr (B::reaches_host_memory) update_views(*recorded_, renderer_.recorded_scenes());
    renderer_.record(report);
  }
  void set_recorded_scenes() override {
    renderer_.set_scenes(scenes());
    recorded_ = placed_;
  }
  Span<PlacedScene> recorded_scenes() override {
    if (!recorded_ || recorded_alone_)
      throw OrderError("recorded_scenes: expected reserve of placed scenes before");
    return {renderer_.recorded_scenes(), recorded_->each.size()};
  }
  std::vector<std::size_t> refused_scenes() const override { return renderer_.refused_scenes(); }
  void wait() override { renderer_.backend().wait(); }
  std::vector<PickedPixel> pick(const PickRectangle& rectangle) override { return renderer_.pick(rectangle); }
  StageTimes times() override { return renderer_.times(); }
  Statistics statistics() const override { return renderer_.statistics(); }
  std::vector<std::size_t> visible_by_scene() const override { return renderer_.visible_by_scene(); }
  StageMemory memory() const override { return renderer_.memory(); }
  void trim() override {
    renderer_.trim();
    recorded_.reset();
  }
  std::string device_name() const override { return renderer_.backend().device_name(); }
  bool sort_decided() override { return renderer_.stages().sort().decided(); }
  std::optional<MemoryUse> device_memory() const override {
    if constexpr (B::reaches_host_memory)
      return std::nullopt;
    else
      return B::memory_use();
  }

 private:
  using SceneOn = typename B::SceneOn;

  /// Placed scenes, and the placement of each.
  struct Placed {
    std::vector<PlacedScene> each;
    std::vector<Placement> placements;
  };
  void add(Placed& placed, const Placement& p) {
    placed.each.push_back({view_of(p), p.world_from_scene, p.opacity, p.clip, p.tint});
    placed.placements.push_back(p);
  }

  /// The first scene, where it stands by itself.
  void show_alone() {
    more_.clear(), placed_ = {}, recorded_.reset();
    add(placed_, {});
  }

  void require_known(const char* call, std::size_t scene) const {
    const std::size_t known = scene_ ? 1 + more_.size() : 0;
    if (scene >= known) detail::refuse(call, ": the scene is number ", scene, ", expected less than ", known);
  }
  void require_range(std::size_t number, const Placement& p) {
    const std::size_t size = numbered(p.scene).view().size();
    if (p.first <= size && (p.count == Placement::all || p.count <= size - p.first)) return;
    detail::refuse("place: placement ", number, " shows ",
                   p.count == Placement::all ? "all" : std::to_string(p.count), " Gaussians from number ",
                   p.first, " on, expected some of the ", size, " of scene ", p.scene);
  }
  SceneOn& numbered(std::size_t scene) { return scene == 0 ? *scene_ : more_[scene - 1]; }
  SceneView view_of(const Placement& p) {
    const SceneView whole = numbered(p.scene).view();
    return range_of(whole, p.first, std::min(p.count, whole.size() - p.first));
  }

  PlacedScenes scenes() {
    if (!scene_) throw OrderError("render: expected a scene before the first frame");
    update_views(placed_, placed_.each.data());
    return placed_.each;
  }
  /// Gives `each` of `placed` the view that its scene has now: a host's first update of a scene moves it.
  void update_views(const Placed& placed, PlacedScene* each) {
    for (std::size_t i = 0; i < placed.each.size(); ++i) each[i].scene = view_of(placed.placements[i]);
  }

  std::string name_;
  BoundRenderer<B> renderer_;
  std::optional<SceneOn> scene_{};  ///< copies share the memory
  std::vector<SceneOn> more_{};     ///< after it
  Placed placed_{};
  std::optional<Placed> recorded_{};  ///< of `reserve` or `set_recorded_scenes`, while those are uploaded
  bool recorded_alone_ = false;       ///< whether `reserve` was for a scene alone
};

namespace detail {
template <class B, class Sort, class Bounds>
std::unique_ptr<SortStage<B>> make_sort() {
  return std::make_unique<SortStageOf<B, Sort, Bounds>>();
}
}  // namespace detail

/// Appends every combination of backend `B` with the given sorts, rasterizers and bounds to `table`.
/// backends/table.cpp holds the library's lists. A policy on a device also needs code that its compiler
/// makes.
template <class B, class... Sorts, class... Rasters, class... Bounds>
void append_renderers(std::vector<RendererEntry>& table, TypeList<Sorts...>, TypeList<Rasters...>,
                      TypeList<Bounds...>) {
  using MakeSort = std::unique_ptr<SortStage<B>> (*)();
  const std::vector<BoundsStages<B>> all_bounds{bounds_stages<B, Bounds>()...};
  const std::vector<RasterStage<B>> all_rasters{raster_stage<B, Rasters>()...};
  const auto append = [&](std::string_view sort, const std::vector<MakeSort>& within) {
    for (const RasterStage<B>& raster : all_rasters)
      for (std::size_t k = 0; k < all_bounds.size(); ++k) {
        const BoundsStages<B>& bounds = all_bounds[k];
        std::string name{B::name};
        for (const std::string_view word : {sort, raster.name, bounds.name}) name.append("/").append(word);
        const auto make = [=, make_sort = within[k]](const BackendOptions& options) {
          return std::unique_ptr<AnyRenderer>(std::make_unique<AnyRendererOn<B>>(
              name, options, StageTable<B>{bounds, raster, common_stages<B>()}, make_sort()));
        };
        table.push_back({name, B::usable(), !B::reaches_host_memory, make});
      }
  };
  const auto append_sort = [&]<class Sort>() {
    append(Sort::name, {&detail::make_sort<B, Sort, Bounds>...});
  };
  (append_sort.template operator()<Sorts>(), ...);
}

}  // namespace swiftgs
