// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <string_view>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/rendering_model.hpp>

namespace swiftgs {

/// The numbers that define "the same image". `Conventions::gsplat()`, `Conventions::inria()` and
/// `Conventions::khronos()` are exact presets. What is optional is as the scene was trained unless it is set.
struct Conventions {
  /// Limits of x/z and y/z where the projection is linearised, in tangents.
  enum class JacobianClamp {
    around_image,   ///< 0.3 tan(fov/2) beyond each image border, wherever the principal point is
    around_centre,  ///< 1.3 tan(fov/2) to each side of the axis
  };
  /// The pixels that a Gaussian can reach in the reference image.
  enum class Footprint {
    alpha,                ///< every pixel where alpha is at least `alpha_min`
    three_sigma_square,   ///< only those in 16x16 tiles that the square of half side ceil(3 sqrt(lambda_max))
                          ///< touches
    three_sigma_ellipse,  ///< only those at most three standard deviations from the mean, with the blur
  };

  /// What is compared with the planes and with occluders, and is drawn as depth. Orders splats, unless
  /// `order` says otherwise.
  enum class Depth {
    of_lens,   ///< z of perspective and orthographic lenses, distance of those that see behind the camera
    z,         ///< along the camera's axis
    distance,  ///< from the camera's centre
  };

  /// A splat's depth at a pixel, for planes of depth and occluders. Order and culling take the mean's.
  enum class DepthAt {
    centre,  ///< its mean's, at every pixel
    ray,  ///< where the Gaussian is densest along the pixel's ray: it varies over the splat as a plane does
  };

  Depth depth = Depth::of_lens;
  DepthAt depth_at = DepthAt::centre;
  float near_plane = 0.01f;   ///< a Gaussian nearer than this is culled
  bool cull_at_near = false;  ///< so is one exactly on the near plane
  float far_plane = 1e10f;    ///< a Gaussian further than this is culled
  JacobianClamp clamp = JacobianClamp::around_image;
  std::optional<float> blur{};  ///< added to both variances of a splat @units{pixels^2}
  /// Scale opacity by sqrt(det without blur / det with blur), Mip-Splatting.
  std::optional<bool> antialiased{};
  /// A frame has one order: without one here, by distance if a scene that it shows was trained so. A view
  /// with an occluder is ordered by depth, since a list of splats ends at the occluder.
  std::optional<SplatOrder> order{};
  /// A frame has one kind of values to blend in: without one here, its scenes must agree.
  std::optional<ColourSpace> colours{};
  float min_compensation = 2.5e-5f;  ///< least ratio of determinants in that root
  float alpha_min = 1.0f / 255;      ///< a pixel skips a Gaussian with less alpha
  float alpha_max = 0.99f;           ///< alpha is cut here
  float stop = 1e-4f;         ///< a pixel ends before the Gaussian that would bring its transmittance below
  bool stop_at_equal = true;  ///< or exactly to `stop`
  float first_alpha = 0.05f;  ///< a pixel's first depth is of the Gaussian that takes its alpha above
  Footprint footprint = Footprint::alpha;  ///< of the reference; renderers use their Bounds

  /// gsplat 1.6.
  static constexpr Conventions gsplat() { return {}; }

  /// INRIA's rasterizer. A camera whose principal point is not centred is rendered as it is given.
  static constexpr Conventions inria() {
    Conventions c;
    c.near_plane = 0.2f;
    c.cull_at_near = true;
    c.far_plane = std::numeric_limits<float>::infinity();
    c.clamp = JacobianClamp::around_centre;
    c.stop_at_equal = false;
    c.footprint = Footprint::three_sigma_square;
    return c;
  }

  /// The text of KHR_gaussian_splatting. What it leaves open is as in `gsplat`.
  static constexpr Conventions khronos() {
    Conventions c;
    c.order = SplatOrder::distance;
    c.alpha_min = 0x1p-24f;  // the text has no limit; a transmittance of 1 as a float does not show less
    c.alpha_max = 1;
    c.stop = 0;
    c.stop_at_equal = false;
    c.footprint = Footprint::three_sigma_ellipse;
    return c;
  }

  bool operator==(const Conventions&) const = default;
};

/// Least depth of a Gaussian that is drawn, whatever the near plane: over less, the longest focal length is
/// more than a float holds.
inline constexpr float least_depth = 1e-26f;

/// `conventions` with nothing left to the scene, which was trained for `model`.
inline Conventions as_trained(Conventions conventions, const RenderingModel& model) {
  if (!conventions.blur) conventions.blur = model.blur;
  if (!conventions.antialiased) conventions.antialiased = model.antialiased;
  if (!conventions.order) conventions.order = model.order;
  if (!conventions.colours) conventions.colours = model.colours;
  return conventions;
}

/// Throws `InvalidArgument` that names the first invalid number.
inline void validate(const Conventions& c) {
  const auto require = [](bool holds, const char* expected) {
    if (!holds) detail::refuse("conventions: expected ", expected);
  };
  require(c.near_plane >= 0 && c.near_plane < c.far_plane, "a near plane of 0 or more before the far plane");
  require(!c.blur || detail::is_blur(*c.blur), "a blur of 0 or more");
  require(c.min_compensation >= 0 && c.min_compensation <= 1, "a least compensation of 0 to 1");
  // Exponentials in base 2 end where normal floats do.
  require(c.alpha_min >= std::numeric_limits<float>::min() && c.alpha_min <= c.alpha_max && c.alpha_max <= 1,
          "2^-126 <= alpha_min <= alpha_max <= 1");
  require(c.stop >= 0 && c.stop < 1, "a stop of 0 or more and below 1");
  require(c.first_alpha >= 0 && c.first_alpha < 1, "a first alpha of 0 or more and below 1");
}

/// The preset called `name`. Throws `InvalidArgument` with the valid names for any other.
inline Conventions conventions_named(std::string_view name) {
  if (name == "gsplat") return Conventions::gsplat();
  if (name == "inria") return Conventions::inria();
  if (name == "khronos") return Conventions::khronos();
  detail::refuse("conventions '", name, "' are not known; expected gsplat, inria or khronos");
}

}  // namespace swiftgs
