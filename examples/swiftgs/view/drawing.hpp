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
#include <swiftgs/pick.hpp>
#include <swiftgs/reference/placed.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs::cli {

/// A placed scene of the viewer's list.
struct ShownScene {
  std::string name;
  std::shared_ptr<const Scene> gaussians;
  Placement placement{};  ///< `scene` is set by `Drawing`
  bool visible = true;
};

/// What shows at a pixel: the Gaussian of the largest weight, by its number in its scene.
struct Picked {
  std::size_t scene;  ///< in the list
  std::size_t gaussian;
  float weight, depth;
};

/// The scenes of the viewer, and frames of them by a renderer that may change.
class Drawing {
 public:
  /// Throws as `make_renderer`, and `std::invalid_argument` for a scene without Gaussians.
  Drawing(const std::string& renderer, const RenderSettings& settings, std::vector<ShownScene> scenes);

  /// Draws with the renderer of this name from now on. Throws as `make_renderer`, and changes nothing then.
  void use(const std::string& renderer);
  /// Adds a scene. Throws `std::invalid_argument` if it has no Gaussian.
  void add(ShownScene scene);
  /// Places `scenes` as they are now. Throws as `AnyRenderer::place`, and changes nothing then.
  void place();
  /// Shows this plane in false colours in place of colour; colour where the name is empty.
  void show_plane(std::string_view name);

  /// Draws what `camera` sees, counted if wanted.
  void draw(const Camera& camera, bool count);
  /// The last frame as it shows: its colours, or those of its plane.
  const Frame& picture() const { return plane_.empty() ? frame_ : plane_picture_; }
  /// At a pixel of the last frame, where a Gaussian shows.
  std::optional<Picked> pick(int x, int y);
  /// A frame beside the last one, which stays.
  std::vector<float> draw_apart(const Camera& camera);

  const AnyRenderer& renderer() const { return *renderer_; }
  StageTimes times() { return renderer_->times(); }
  const RenderSettings& settings() const { return settings_; }
  /// What shows, for the reference, which must not outlive `scenes`.
  std::vector<ShownScene> visible() const;
  /// Grows when scenes change.
  std::size_t version() const { return version_; }

  std::vector<ShownScene> scenes;  ///< to change before `place`

 private:
  std::vector<Placement> placements() const;

  std::unique_ptr<AnyRenderer> renderer_, apart_;
  RenderSettings settings_;
  std::vector<std::shared_ptr<const Scene>> uploaded_;  ///< each once, by `Placement::scene`
  std::string plane_;
  Frame frame_, plane_picture_;
  std::size_t version_ = 0;
};

}  // namespace swiftgs::cli
