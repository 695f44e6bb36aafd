// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/tiles.hpp>
#include <swiftgs/view_constants.hpp>

namespace swiftgs {

/// The thresholds of blending, from `Conventions`.
struct BlendRules {
  float alpha_min = 0;   ///< less alpha is skipped
  float alpha_max = 0;   ///< more is cut
  float stop_below = 0;  ///< a pixel ends before the splat that would bring its transmittance below this

  static BlendRules from(const Conventions& c) {
    return {c.alpha_min, c.alpha_max, c.stop_at_equal ? std::nextafter(c.stop, 1.0f) : c.stop};
  }
};

/// One image of a frame: from where, by which rules, and where to.
struct View {
  ViewConstants camera{};
  BlendRules rules{};
  vec3 background{0};  ///< RGB in the scene's own values
  TileGrid grid{};     ///< covers `frame`
  FrameView frame{};
};

/// A view through `camera` into `frame`, with tiles of the usual side. Throws as `view_constants`.
inline View make_view(const Camera& camera, const Conventions& conventions, const FrameView& frame,
                      vec3 background = vec3(0)) {
  return {view_constants(camera, conventions), BlendRules::from(conventions), background,
          TileGrid::covering(frame.width, frame.height), frame};
}

/// A scene as it appears in a frame.
struct PlacedScene {
  SceneView scene;
};

/// What is projected and shaded. Stages read both spans before they return.
struct FrameInput {
  Span<const View> views;
  Span<const PlacedScene> scenes;
};

/// The squares that cover an image, numbered by rows.
struct Squares {
  int columns, rows;

  SWIFTGS_HD explicit Squares(const FrameView& frame)
      : columns((frame.width + square_side - 1) / square_side),
        rows((frame.height + square_side - 1) / square_side) {}
  SWIFTGS_HD std::size_t size() const { return std::size_t(columns) * std::size_t(rows); }

  /// First pixel of a square.
  SWIFTGS_HD int x(std::size_t square) const {
    return int(std::uint32_t(square) % std::uint32_t(columns)) * square_side;
  }
  SWIFTGS_HD int y(std::size_t square) const {
    return int(std::uint32_t(square) / std::uint32_t(columns)) * square_side;
  }
};

namespace detail {
[[noreturn]] inline void refuse(const char* what, std::size_t found, const std::string& expected) {
  throw std::invalid_argument(std::string(what) + " is " + std::to_string(found) + ", expected " + expected);
}
}  // namespace detail

/// The one view of a frame. Throws `std::invalid_argument` if there is another number of views, or if the
/// frame has no pixels or too many, or if the view's tiles do not cover it.
inline const View& only_view(Span<const View> views) {
  if (views.size != 1) detail::refuse("frame: the number of views", views.size, "1");
  const View& view = views[0];
  const auto side_fits = [](int side) { return side > 0 && side <= max_image_side; };
  if (!side_fits(view.frame.width) || !side_fits(view.frame.height))
    throw std::invalid_argument("frame: " + std::to_string(view.frame.width) + " x " +
                                std::to_string(view.frame.height) + " pixels, expected 1 to " +
                                std::to_string(max_image_side) + " a side");
  const TileGrid& grid = view.grid;
  if (grid.side < square_side || (grid.side & (grid.side - 1)) != 0)
    detail::refuse("tiles: the side", std::size_t(grid.side),
                   "a power of two of at least " + std::to_string(square_side) + " pixels");
  const TileGrid needed = TileGrid::covering(view.frame.width, view.frame.height, grid.side);
  if (grid.columns != needed.columns)
    detail::refuse("tiles: the number of columns", std::size_t(grid.columns), std::to_string(needed.columns));
  if (grid.rows != needed.rows)
    detail::refuse("tiles: the number of rows", std::size_t(grid.rows), std::to_string(needed.rows));
  return view;
}

/// The one scene of a frame. Throws `std::invalid_argument` if there is another number of scenes.
inline const SceneView& only_scene(Span<const PlacedScene> scenes) {
  if (scenes.size != 1) detail::refuse("frame: the number of scenes", scenes.size, "1");
  return scenes[0].scene;
}

}  // namespace swiftgs
