// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/frame/view_constants.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/lens/limits.hpp>
#if defined(__SSE2_MATH__)
#include <xmmintrin.h>
#else
#include <cfenv>
#endif

namespace swiftgs {

/// Until it is destroyed, this thread rounds floats to nearest, whatever mode the caller has set. On x86 it
/// keeps denormal numbers as well.
class RoundToNearest {
 public:
#if defined(__SSE2_MATH__)
  // Floats obey MXCSR, which a program may set alone. std::fegetround reads the word of the x87 instead.
  RoundToNearest() : saved_(_mm_getcsr()) {
    if ((saved_ & unusual) != 0) _mm_setcsr(saved_ & ~unusual);
  }
  ~RoundToNearest() {
    // Exceptions that were raised meanwhile stay flagged.
    if ((saved_ & unusual) != 0) _mm_setcsr((_mm_getcsr() & ~unusual) | (saved_ & unusual));
  }
#else
  RoundToNearest() : saved_(std::fegetround()) {
    if (saved_ != FE_TONEAREST) std::fesetround(FE_TONEAREST);
  }
  ~RoundToNearest() {
    if (saved_ != FE_TONEAREST) std::fesetround(saved_);
  }
#endif
  RoundToNearest(const RoundToNearest&) = delete;
  RoundToNearest& operator=(const RoundToNearest&) = delete;

 private:
#if defined(__SSE2_MATH__)
  /// The two bits of the mode, and those that take results and operands that are denormal for zero.
  static constexpr unsigned unusual = 0x6000 | 0x8000 | 0x0040;
  unsigned saved_;
#else
  int saved_;
#endif
};

/// The thresholds of blending by valid conventions.
inline BlendRules blend_rules(const Conventions& c) {
  const float stop = c.stop + 0.0f;  // never -0: backends look at its sign
  return {c.alpha_min,
          c.alpha_max,
          c.stop_at_equal ? std::nextafter(stop, 1.0f) : stop,
          std::log2(c.alpha_min),
          float(std::log2(double(c.alpha_min) / double(c.alpha_max))),
          1 - c.first_alpha};
}

inline bool depth_is_distance(LensModel model, const Conventions& conventions) {
  if (conventions.depth == Conventions::Depth::of_lens) return traits_of(model).sees_behind;
  return conventions.depth == Conventions::Depth::distance;
}

/// Throws `InvalidArgument` for an invalid `camera` or `conventions`. What `conventions` leave to the
/// scene is as of a scene that says nothing.
inline ViewConstants view_constants(const Camera& camera, const Conventions& conventions) {
  validate(camera);
  validate(conventions);
  ViewConstants v{};
  const dvec3 centre = camera.centre();
  for (int row = 0; row < 3; ++row) {
    v.centre[row] = centre[row];
    for (int column = 0; column < 3; ++column) {
      v.rotation[row][column] = camera.rotation[column][row];
      v.axes[row][column] = float(v.rotation[row][column]);
    }
  }
  v.depth_scale = 1, v.opacity = 1;
  v.fx = camera.fx, v.fy = camera.fy, v.cx = camera.cx, v.cy = camera.cy;
  v.focal_x = float(v.fx), v.focal_y = float(v.fy);
  v.set_pairs();
  v.width = float(camera.width), v.height = float(camera.height);
  v.left = v.top = 0, v.right = v.width, v.bottom = v.height;

  const double half_x = 0.5 * camera.width / camera.fx, half_y = 0.5 * camera.height / camera.fy;
  LensLimits tangents{.fold_squared = INFINITY};
  if (conventions.clamp == Conventions::JacobianClamp::around_image) {
    tangents.least_u = -(camera.cx / camera.fx + 0.3 * half_x);
    tangents.most_u = (camera.width - camera.cx) / camera.fx + 0.3 * half_x;
    tangents.least_v = -(camera.cy / camera.fy + 0.3 * half_y);
    tangents.most_v = (camera.height - camera.cy) / camera.fy + 0.3 * half_y;
  } else {
    tangents.most_u = 1.3 * half_x, tangents.least_u = -tangents.most_u;
    tangents.most_v = 1.3 * half_y, tangents.least_v = -tangents.most_v;
  }
  // A strict comparison serves both presets: z >= near is z > the float before near.
  const float near_plane = std::fmax(conventions.near_plane, least_depth);
  v.near_plane = conventions.cull_at_near ? near_plane : std::nextafter(near_plane, 0.0f);
  // A depth that no float holds would be infinite, and 0 * depth not a number.
  v.far_plane = std::fmin(conventions.far_plane, std::numeric_limits<float>::max());
  v.blur_of_scene = !conventions.blur, v.antialiased_of_scene = !conventions.antialiased;
  const Conventions whole = as_trained(conventions, {});
  v.blur = *whole.blur, v.antialiased = *whole.antialiased;
  v.min_compensation = conventions.min_compensation;
  v.alpha_min = conventions.alpha_min;
  v.lens = camera.lens;
  v.depth_is_distance = depth_is_distance(camera.lens.model, conventions);
  v.depth_along_ray = conventions.depth_at == Conventions::DepthAt::ray;
  v.through_lens = !camera.lens.is_pinhole() || v.depth_is_distance;
  v.limits = camera.lens.is_pinhole() ? tangents : lens_limits(camera, conventions);
  if (*whole.order == SplatOrder::distance && !v.depth_is_distance) v.order_by_distance();
  if (traits_of(camera.lens.model).shows_sphere) v.turn = turn_of(camera);
  v.panorama_middle = 0.5 * camera.width;
  return v;
}

/// Where a frame that shows a part of an image begins in it. A multiple of `default_tile_side`, so that the
/// part has the bits of the whole image. @units{pixels}
struct FirstPixel {
  int x = 0, y = 0;
};

/// A view through `camera` into `frame`, with tiles of the usual side. A frame smaller than the camera's
/// image shows the part of it that begins at `first`; the parts of several views make up one image, bit for
/// bit. Rounds to nearest. Throws as `view_constants`, and `InvalidArgument` if the frame does not lie
/// within the image.
inline View make_view(const Camera& camera, const Conventions& conventions, const FrameView& frame,
                      vec3 background = vec3(0), FirstPixel first = {}) {
  const RoundToNearest scope;
  View view{view_constants(camera, conventions), blend_rules(conventions), background, {}, frame};
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
