// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/drivers/pick.hpp>
#include <swiftgs/io/scene_list.hpp>
#include <swiftgs/scene.hpp>

#include "draw/page_frames.hpp"
#include "draw/plane_pictures.hpp"

namespace swiftgs::cli {

/// A placed scene of the viewer's list. Its numbers are those of lists of scenes, so that a saved list draws
/// the same bits.
struct ShownScene {
  ListedScene listed;
  std::shared_ptr<const Scene> gaussians;  ///< of pages those of the root
  std::optional<PagedScene> pages;

  std::string name() const;  ///< of the file, without its folders
};

/// What shows of `gaussians` in a frame.
struct PlacedGaussians {
  std::shared_ptr<const Scene> gaussians;
  Placement placement;
};

/// What shows at a pixel: the Gaussian of the largest weight, or the node of a page.
struct Picked {
  std::size_t scene;  ///< in the list
  std::string name;   ///< with its number in its scene
  dvec3 position{};   ///< as its file has it
  vec3 scale{};
  float opacity = 0, weight = 0, depth = 0;
};

/// The scenes of the viewer, and frames of them by a renderer that may change.
class Drawing {
 public:
  /// Throws as `make_renderer`, and `InvalidArgument` for a scene without Gaussians.
  Drawing(const std::string& renderer, const RenderSettings& settings, const PageOptions& pages,
          std::vector<ShownScene> scenes);

  /// Draws with the renderer of this name from now on. Throws as `make_renderer`, and changes nothing then.
  void use(const std::string& renderer);
  /// Adds all of these scenes. Throws `InvalidArgument` if one has no Gaussian, and as
  /// `AnyRenderer::place` and `PageFrames`; adds none then.
  void add(std::vector<ShownScene> scenes);
  /// Places scene `number` as `listed` says. Throws as `AnyRenderer::place`, and changes nothing then.
  void change(std::size_t number, ListedScene listed);
  /// Shows this plane in false colours in place of colour; colour where the name is empty.
  void show_plane(std::string_view name);

  /// Which pages frames show from now on.
  void set_goal(const CutGoal& goal) { goal_ = goal; }
  const CutGoal& goal() const { return goal_; }
  /// Pages of the last frame; null if no scene has pages.
  const PageFrames* pages() const { return pages_.get(); }
  /// Whether another frame may show more pages.
  bool is_loading() const { return pages_ && !pages_->cut().is_settled(); }

  /// Draws what `camera` sees, counted if wanted.
  void draw(const Camera& camera, bool count);
  /// The picture of the last frame: its colours, or its plane in false colours.
  const Frame& picture() const { return plane_.empty() ? frame_ : plane_picture_; }
  /// Depths that the false colours of the last frame stand for; nothing for other planes.
  const std::optional<DepthRange>& depth_range() const { return depth_range_; }
  /// At a pixel of the last frame, where a Gaussian shows.
  std::optional<Picked> pick(int x, int y);
  /// A frame beside the last one, which stays.
  std::vector<float> draw_apart(const Camera& camera);

  const AnyRenderer& renderer() const { return *renderer_; }
  StageTimes times() { return renderer_->times(); }
  const RenderSettings& settings() const { return settings_; }
  const std::vector<ShownScene>& scenes() const { return scenes_; }
  /// Position of the scene's file in the world of the first scene, whose origin is 0 there.
  dvec3 in_world(std::size_t scene, const dvec3& position) const;
  /// What shows, for the reference. Not of pages.
  std::vector<PlacedGaussians> visible() const;
  /// Grows when scenes change.
  std::size_t version() const { return version_; }

 private:
  /// Prepares `drawn`, which has pages, for frames of `renderer`.
  std::unique_ptr<PageFrames> page_frames(AnyRenderer& renderer, DrawnScenes drawn,
                                          std::vector<Placement> placements) const;
  /// Makes `scenes` those of the list. Throws as `AnyRenderer::place`, and changes nothing then.
  void place(std::vector<ShownScene> scenes);

  std::unique_ptr<AnyRenderer> renderer_, apart_;
  RenderSettings settings_;
  PagePoolOptions pool_options_;
  CutGoal goal_;
  DrawnScenes known_;                  ///< without placements: each scene once, by `Placement::scene`
  std::unique_ptr<PageFrames> pages_;  ///< of all of `known_` if one has pages
  std::vector<ShownScene> scenes_;
  std::string plane_;
  Frame frame_, plane_picture_;
  std::optional<DepthRange> depth_range_;
  std::size_t version_ = 0;
};

}  // namespace swiftgs::cli
