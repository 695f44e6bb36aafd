// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/round_to_nearest.hpp>
#include <swiftgs/tiles.hpp>
#include <swiftgs/view_constants.hpp>

namespace swiftgs {

/// The thresholds of blending, from `Conventions`.
struct BlendRules {
  float alpha_min = 0;   ///< less alpha is skipped
  float alpha_max = 0;   ///< more is cut
  float stop_below = 0;  ///< a pixel ends before the splat that would bring its transmittance below this
  float log2_alpha_min = 0;
  float log2_relative_min = 0;  ///< log2(alpha_min / alpha_max)
  float first_below = 0;        ///< the first splat that shows takes the transmittance below this

  static BlendRules from(const Conventions& c) {
    const float stop = c.stop + 0.0f;  // never -0: backends look at its sign
    return {c.alpha_min,
            c.alpha_max,
            c.stop_at_equal ? std::nextafter(stop, 1.0f) : stop,
            std::log2(c.alpha_min),
            float(std::log2(double(c.alpha_min) / double(c.alpha_max))),
            1 - c.first_alpha};
  }
};

/// The placed scenes that a view shows: by default all of its frame.
struct ShownScenes {
  std::uint32_t first = 0, count = 0xffffffff;
};

/// One image of a frame, or a rectangle of one: from where, by which rules, and where to.
struct View {
  ViewConstants camera{};
  BlendRules rules{};
  vec3 background{0};  ///< as `RenderSettings::background`
  TileGrid grid{};     ///< covers `frame`
  FrameView frame{};
  ShownScenes shows{};
  // As of `Conventions`: `ModelledViews` takes what is left to the scenes from them.
  bool order_of_scenes = false, colours_of_scenes = false;
  ColourSpace colours = ColourSpace::srgb;
  int panorama_part = 0;  ///< as of its camera: a frame draws a view that spans several parts as several

  /// Pixel of the image that is the first of `frame`.
  SWIFTGS_HD int left() const { return grid.columns.begin * grid.side; }
  SWIFTGS_HD int top() const { return grid.rows.begin * grid.side; }
};

/// Where a frame that shows a part of an image begins in it. A multiple of `default_tile_side`, so that the
/// part has the bits of the whole image. @units{pixels}
struct FirstPixel {
  int x = 0, y = 0;
};

/// A view through `camera` into `frame`, with tiles of the usual side. A frame smaller than the camera's
/// image shows the part of it that begins at `first`; the parts of several views make up one image, bit for
/// bit. Rounds to nearest. Throws as `view_constants`, and `std::invalid_argument` if the frame does not lie
/// within the image.
inline View make_view(const Camera& camera, const Conventions& conventions, const FrameView& frame,
                      vec3 background = vec3(0), FirstPixel first = {}) {
  const RoundToNearest scope;
  View view{view_constants(camera, conventions), BlendRules::from(conventions), background, {}, frame};
  const auto run = [](const char* name, int begin, int size, int whole) {
    const int side = default_tile_side;
    if (begin < 0 || begin % side != 0)
      detail::refuse("view: the first pixel's ", name, " is ", begin, ", expected a multiple of ", side);
    if (size < 1 || size > whole - begin)
      detail::refuse("view: the frame has ", size, " pixels along ", name, " from ", begin,
                     " on, expected 1 or more within the camera's ", whole);
    return TileRun{begin / side, (begin + size + side - 1) / side};
  };
  view.grid.columns = run("x", first.x, frame.width, camera.width);
  view.grid.rows = run("y", first.y, frame.height, camera.height);
  view.grid.stride = std::uint32_t(view.grid.columns.size());
  view.camera.left = float(first.x), view.camera.right = float(first.x + frame.width);
  view.camera.top = float(first.y), view.camera.bottom = float(first.y + frame.height);
  view.order_of_scenes = !conventions.order, view.colours_of_scenes = !conventions.colours;
  view.colours = conventions.colours.value_or(ColourSpace::srgb);
  view.panorama_part = panorama_part(camera);
  if (view.panorama_part > 0)
    view.camera.panorama_middle = (first.x / view.panorama_part + 0.5) * view.panorama_part;
  return view;
}

}  // namespace swiftgs
