// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <iterator>
#include <string>
#include <string_view>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>

namespace swiftgs {

/// How directions map to a plane, before distortion and focal lengths. With (x, y, z) in camera space, the
/// plane's point (u, v) is
enum class LensModel {
  perspective,      ///< (x / z, y / z), for z > 0
  fisheye,          ///< the angle to the axis times (x, y) / |(x, y)|: equidistant, to beyond 180 degrees
  orthographic,     ///< (x, y): parallel rays, focal lengths in pixels per unit of the scene
  equirectangular,  ///< azimuth atan2(x, z) and elevation atan2(y, |(x, z)|) @units{radians}
};

/// What models differ in beside their formulas. Code that runs on devices compares with `LensModel` itself.
struct LensTraits {
  const char* name;
  bool takes_distortion = false;
  bool sees_behind = false;    ///< the camera, so `Conventions::Depth::of_lens` is the distance
  bool parallel_rays = false;  ///< so focal lengths are in pixels per unit of the scene
  bool shows_sphere = false;   ///< by angles in both directions: a row has a full turn at most
};

/// In the order of `LensModel`.
inline constexpr LensTraits lens_traits[] = {
    {.name = "perspective", .takes_distortion = true},
    {.name = "fisheye", .takes_distortion = true, .sees_behind = true},
    {.name = "orthographic", .parallel_rays = true},
    {.name = "equirectangular", .sees_behind = true, .shows_sphere = true}};

inline constexpr const LensTraits& traits_of(LensModel model) { return lens_traits[int(model)]; }

/// Moves (u, v) in its plane; with r^2 = u^2 + v^2 to
///   u R + 2 p0 u v + p1 (r^2 + 2 u^2) + s0 r^2,  v R + p0 (r^2 + 2 v^2) + 2 p1 u v + s1 r^2,
///   R = (1 + k0 r^2 + k1 r^4 + k2 r^6 + k3 r^8) / (1 + q0 r^2 + q1 r^4 + q2 r^6).
/// This is OpenCV's model of a perspective (k1, k2, k3 | k4, k5, k6) and of a fisheye lens (k1 to k4), and
/// COLMAP's of a thin prism.
struct Distortion {
  double radial[4] = {};      ///< k
  double rational[3] = {};    ///< q
  double tangential[2] = {};  ///< p
  double prism[2] = {};       ///< s

  bool operator==(const Distortion&) const = default;
};

/// How directions become points of the image plane.
struct Lens {
  LensModel model = LensModel::perspective;
  Distortion distortion;  ///< of models that take one alone

  bool is_distorted() const { return distortion != Distortion(); }
  /// A pinhole: perspective without distortion.
  bool is_pinhole() const { return model == LensModel::perspective && !is_distorted(); }
  bool operator==(const Lens&) const = default;
};

/// What a lens keeps of its points, found once a frame.
struct LensLimits {
  /// Points whose undistorted r^2 is not below are beyond the fold-over of the distortion.
  double fold_squared = INFINITY;
  /// The derivatives of a perspective lens are taken within these tangents.
  double least_u = -INFINITY, most_u = INFINITY, least_v = -INFINITY, most_v = INFINITY;
  /// Near the poles of an equirectangular lens, its derivatives take 1 / sin(angle to the pole) as this.
  double most_cosecant = INFINITY;

  bool operator==(const LensLimits&) const = default;
};

inline std::string_view name_of(LensModel model) { return traits_of(model).name; }

/// "perspective, fisheye, orthographic or equirectangular".
inline std::string lens_model_names() {
  std::string names;
  constexpr std::size_t count = std::size(lens_traits);
  for (std::size_t i = 0; i < count; ++i)
    names.append(i == 0 ? "" : i + 1 < count ? ", " : " or ").append(lens_traits[i].name);
  return names;
}

/// The model called `name`. Throws `InvalidArgument` with the valid names for any other.
inline LensModel lens_model_named(std::string_view name) {
  for (std::size_t i = 0; i < std::size(lens_traits); ++i)
    if (name == lens_traits[i].name) return LensModel(i);
  detail::refuse("lens '", name, "' is not known; expected ", lens_model_names());
}

/// Throws `InvalidArgument` for a distortion that is not finite, or of a lens that has none.
inline void validate(const Lens& lens) {
  const Distortion& d = lens.distortion;
  for (const double number :
       {d.radial[0], d.radial[1], d.radial[2], d.radial[3], d.rational[0], d.rational[1], d.rational[2],
        d.tangential[0], d.tangential[1], d.prism[0], d.prism[1]})
    if (!detail::is_finite(number) || std::fabs(number) > 1e6)
      throw InvalidArgument("camera: expected distortion coefficients of at most 1e6 in magnitude");
  if (!traits_of(lens.model).takes_distortion && lens.is_distorted())
    detail::refuse("camera: expected no distortion of an ", name_of(lens.model), " lens");
}

}  // namespace swiftgs
