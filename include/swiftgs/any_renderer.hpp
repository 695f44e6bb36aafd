// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <swiftgs/renderer.hpp>

namespace swiftgs {

/// A renderer whose policies are chosen at run time.
class AnyRenderer {
 public:
  virtual ~AnyRenderer() = default;
  virtual std::string_view name() const = 0;

  /// Uploads `scene` for the frames that follow; host backends share it.
  virtual void set_scene(std::shared_ptr<const Scene> scene) = 0;

  /// As `Renderer::render`. Throws `std::logic_error` before a scene is set.
  virtual void render(const Camera& camera, const RenderSettings& settings, Frame& frame) = 0;
  virtual StageTimes times() = 0;
  virtual Statistics statistics() const = 0;
};

/// One row of the table of renderers.
struct RendererEntry {
  std::string_view name;  ///< BACKEND/SORT/RASTER/BOUNDS
  bool usable = false;    ///< whether it can run on this machine
  std::unique_ptr<AnyRenderer> (*make)() = nullptr;
};

/// `AnyRenderer` of one combination.
template <class R, class B>
class RendererOf final : public AnyRenderer {
 public:
  std::string_view name() const override { return R::name; }
  void set_scene(std::shared_ptr<const Scene> scene) override {
    scene_.emplace(renderer_.backend().upload(std::move(scene)));
  }
  void render(const Camera& camera, const RenderSettings& settings, Frame& frame) override {
    if (!scene_) throw std::logic_error("render: expected set_scene before the first frame");
    renderer_.render(*scene_, camera, settings, frame);
  }
  StageTimes times() override { return renderer_.times(); }
  Statistics statistics() const override { return renderer_.statistics(); }

 private:
  R renderer_;
  std::optional<typename B::SceneOn> scene_;
};

/// Types to combine.
template <class... Policies>
struct TypeList {};

/// Appends every combination of `backend` with the given sorts, rasterizers and bounds to `table`.
/// A policy is added to the library by one word in one of these lists.
template <class B, class... Sorts, class... Rasters, class... Bounds>
void append_renderers(std::vector<RendererEntry>& table, TypeList<Sorts...>, TypeList<Rasters...>,
                      TypeList<Bounds...>) {
  const auto add = [&]<class S, class R, class Bd>() {
    using Combination = Renderer<B, S, R, Bd>;
    table.push_back({Combination::name, B::usable(), []() -> std::unique_ptr<AnyRenderer> {
                       return std::make_unique<RendererOf<Combination, B>>();
                     }});
  };
  const auto each_bounds = [&]<class S, class R>() { (add.template operator()<S, R, Bounds>(), ...); };
  const auto each_raster = [&]<class S>() { (each_bounds.template operator()<S, Rasters>(), ...); };
  (each_raster.template operator()<Sorts>(), ...);
}

/// Every renderer of this build, whether or not it can run here. Defined in the library that joins the
/// backends.
const std::vector<RendererEntry>& renderers();

/// Makes the renderer called `name`. Throws `std::invalid_argument`, naming the valid words, where there is
/// none, and `std::runtime_error` where it cannot run here.
std::unique_ptr<AnyRenderer> make_renderer(std::string_view name);

}  // namespace swiftgs
