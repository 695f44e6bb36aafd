// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <type_traits>

#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/float_pair.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/view_constants.hpp>
#include <swiftgs/lens/point.hpp>
#include <swiftgs/project/sh.hpp>

namespace swiftgs {

/// All of a Gaussian but its colour.
struct Gaussian {
  vec3 mean, scale;
  Quaternion rotation;
  float opacity;
};
/// `loaded` sees it as it is stored.
template <class Loaded>
SWIFTGS_HD Gaussian gaussian(const SceneView& scene, std::size_t i, const Loaded& loaded) {
  Gaussian g{scene.means[i], scene.scales[i], scene.rotations[i], scene.opacities[i]};
  loaded(g);
  if (scene.any_rotations) g.rotation = normalised(g.rotation);
  return g;
}
SWIFTGS_HD inline Gaussian gaussian(const SceneView& scene, std::size_t i) {
  return gaussian(scene, i, [](Gaussian&) {});
}

/// A splat without its colour.
struct ProjectedShape {
  SplatShape shape;
  float depth = 0;
  bool visible = false;
};

/// Columns of the rotation matrix of `q` as it is given, unit or not.
template <class Real>
struct LocalAxes {
  Vector3<Real> column[3];

  SWIFTGS_HD explicit LocalAxes(Quaternion q) {
    const Real w = q.w, x = q.x, y = q.y, z = q.z, x2 = 2 * x, y2 = 2 * y, z2 = 2 * z;
    const Real wx = w * x2, wy = w * y2, wz = w * z2;
    column[0] =
        Vector3<Real>(std::fma(-y2, y, std::fma(-z2, z, Real(1))), std::fma(x2, y, wz), std::fma(x2, z, -wy));
    column[1] =
        Vector3<Real>(std::fma(x2, y, -wz), std::fma(-x2, x, std::fma(-z2, z, Real(1))), std::fma(y2, z, wx));
    column[2] =
        Vector3<Real>(std::fma(x2, z, wy), std::fma(y2, z, -wx), std::fma(-x2, x, std::fma(-y2, y, Real(1))));
  }
};

/// Where a projection is linearised (Zwicker et al. 2001, EWA splatting, equation 29): at the camera-space
/// direction (tx, ty, 1). `x` and `y` are the focal lengths divided by the depth.
template <class Real>
struct Linearisation {
  Real tx, ty;
  Real x, y;  ///< @units{pixels per unit of the scene}
};

/// Where a lens linearises: the derivatives of its plane by camera space, and the focal lengths.
struct LensSlopes {
  dvec3 u, v;
  double x, y;  ///< @units{pixels}
};

/// Rows of J W R S: how a Gaussian's own unit sphere maps to the image. @units{pixels}
template <class Real>
struct ImageAxes {
  Vector3<Real> x, y;

  SWIFTGS_HD ImageAxes(const ViewConstants& v, const Linearisation<Real>& at, vec3 scale, Quaternion q) {
    const LocalAxes<Real> axes(q);
    const Vector3<Real> ahead = camera_axis(v, 2);
    const auto seen = [&](int row, Real tangent) {
      const Vector3<Real> across = camera_axis(v, row);
      return Vector3<Real>{std::fma(-tangent, ahead.x, across.x), std::fma(-tangent, ahead.y, across.y),
                           std::fma(-tangent, ahead.z, across.z)};
    };
    x = image_row(seen(0, at.tx), at.x, scale, axes), y = image_row(seen(1, at.ty), at.y, scale, axes);
  }

  SWIFTGS_HD ImageAxes(const ViewConstants& v, const LensSlopes& by, vec3 scale, Quaternion q) {
    const LocalAxes<Real> axes(q);
    const Vector3<Real> right = camera_axis(v, 0), down = camera_axis(v, 1), ahead = camera_axis(v, 2);
    const auto seen = [&](const Vector3<Real>& d) {
      Vector3<Real> row;
      for (int k = 0; k < 3; ++k) row[k] = std::fma(d.x, right[k], std::fma(d.y, down[k], d.z * ahead[k]));
      return row;
    };
    x = image_row(seen(by.u), by.x, scale, axes), y = image_row(seen(by.v), by.y, scale, axes);
  }

 private:
  SWIFTGS_HD static Vector3<Real> camera_axis(const ViewConstants& v, int row) {
    if constexpr (std::is_same_v<Real, float>)
      return {v.axes[row][0], v.axes[row][1], v.axes[row][2]};
    else
      return {v.rotation[row][0], v.rotation[row][1], v.rotation[row][2]};
  }
  SWIFTGS_HD static Vector3<Real> image_row(const Vector3<Real>& seen, Real pixels, vec3 scale,
                                            const LocalAxes<Real>& axes) {
    return {pixels * scale.x * dot(seen, axes.column[0]), pixels * scale.y * dot(seen, axes.column[1]),
            pixels * scale.z * dot(seen, axes.column[2])};
  }
};

/// What a splat keeps of its blurred covariance.
struct SplatFactor {
  float l0, l1, l2;    ///< as in `SplatShape`
  float var_x, var_y;  ///< @units{pixels^2}
  float sharpness;     ///< determinant without blur over that with it, if asked for
  bool valid;          ///< the covariance is positive and within `largest_variance`
};

inline constexpr double to_base_2 = 0.84932180028801904272;  ///< sqrt(log2(e) / 2)

/// Factors the covariance of `m`. The determinant is |m.x cross m.y|^2 + blur (trace + blur), a sum of
/// squares (Lagrange's identity); the textbook xx yy - xy^2 loses all digits of a needle's. Its
/// sharpness is found for `antialiased` views alone.
template <class Real>
SWIFTGS_HD SplatFactor factor(const ImageAxes<Real>& m, Real blur, bool antialiased) {
  const Real xx = dot(m.x, m.x), yy = dot(m.y, m.y), xy = dot(m.x, m.y);
  const Real var_x = xx + blur, var_y = yy + blur;
  const Real inv_sigma_y = inverse_sqrt(var_y), inv_var_y = inv_sigma_y * inv_sigma_y;
  // Divide before squaring, so that no square leaves the range of float.
  const Vector3<Real> c = cross(m.x, m.y);
  const Vector3<Real> narrow = c * inv_sigma_y;
  const Real sharp = dot(narrow, narrow);
  const Real var_x_given_y = std::fma(blur, (xx + var_y) * inv_var_y, sharp);
  const Real l0 = Real(to_base_2) * inverse_sqrt(var_x_given_y);
  SplatFactor out;
  out.l0 = float(l0), out.l1 = float(-l0 * (xy * inv_var_y)), out.l2 = float(Real(to_base_2) * inv_sigma_y);
  out.var_x = float(var_x), out.var_y = float(var_y);
  out.sharpness = antialiased ? float(sharp / var_x_given_y) : 1.0f;
  // In double, the factor may leave the range of float where the variances do not.
  out.valid = var_x_given_y > 0 && var_y > 0 && var_x <= Real(largest_variance) &&
              var_y <= Real(largest_variance) && var_x_given_y < Real(INFINITY) &&
              std::fabs(out.l0) < INFINITY && std::fabs(out.l1) < INFINITY && out.l2 < INFINITY;
  return out;
}

/// Limits of splats that GPUs with few units for double factor in float. @see needs_double
inline constexpr float float_length_squared = 512;  ///< of a Gaussian seen from its side @units{pixels^2}
inline constexpr float float_lengths_per_mean = 4;  ///< as much more for each pixel^2 of the mean
inline constexpr float float_tangent_squared = 16;  ///< of the direction to the Gaussian

/// Whether rows of `ImageAxes` in float would be far worse than the rest of a splat. A row errs by about
/// 2^-22 of the Gaussian's length seen from the side: needles that point at the camera, and needles beside
/// the image's first row or column. Far off the axis rows are nearly parallel: their minors cancel, and with
/// them the determinant that compensates opacities. In captures 0.04 % to 0.7 % of the visible splats need
/// double.
SWIFTGS_HD inline bool needs_double(const Linearisation<float>& at, vec3 scale, float mean_x, float mean_y) {
  const float xx = at.tx * at.tx, yy = at.ty * at.ty;
  const float length = dot(scale, scale) * std::fma(at.x * at.x, 1 + xx, at.y * at.y * (1 + yy));
  const float near = std::fmin(std::fabs(mean_x), std::fabs(mean_y));
  return !(length <= std::fma(float_lengths_per_mean * near, near, float_length_squared) &&
           xx + yy <= float_tangent_squared);
}

/// How far beyond its box a splat counts as visible in a part of an image. Rounding may keep a pixel outside
/// of the box, and parts must show it too. Twice the slack of bounds, so visible wherever they list the splat
/// for such a pixel. @units{pixels}
SWIFTGS_HD inline float part_slack(float half_width, float half_height) {
  return 2 * bounds_slack(half_width, half_height);
}

/// Camera-space position of a Gaussian, in double or pairs of floats, so that distant worlds and long focal
/// lengths keep their pixels.
template <class Real = double>
struct CameraPoint {
  Real p[3];

  SWIFTGS_HD CameraPoint(const ViewConstants& view, vec3 mean) {
    const ProjectingConstants<Real> v(view);
    const Real d[3] = {mean.x - v.centre(0), mean.y - v.centre(1), mean.z - v.centre(2)};
    for (int row = 0; row < 3; ++row)
      p[row] = multiply_add(v.rotation(row, 0), d[0],
                            multiply_add(v.rotation(row, 1), d[1], v.rotation(row, 2) * d[2]));
  }
};

/// The splat with this factor and mean, if it can be seen. `Real` as of `SplatShape::set_mean`.
template <class Real>
SWIFTGS_HD ProjectedShape visible_shape(const ViewConstants& v, const Real& mean_x, const Real& mean_y,
                                        const SplatFactor& f, float opacity, float depth) {
  ProjectedShape out;
  if (!f.valid) return out;
  if (v.antialiased) {
    opacity *= std::sqrt(f.sharpness > v.min_compensation ? f.sharpness : v.min_compensation);
    if (!(opacity >= v.alpha_min)) return out;
  }

  SplatShape& s = out.shape;
  s.set_mean(mean_x, mean_y);
  s.l0 = f.l0, s.l1 = f.l1, s.l2 = f.l2;
  s.opacity = opacity;
  s.cutoff = std::log2(opacity / v.alpha_min);
  const float extent = near_sqrt(s.cutoff) * float(1 / to_base_2);
  const float half_width = extent * near_sqrt(f.var_x), half_height = extent * near_sqrt(f.var_y);

  out.depth = depth;
  const vec2 mean = s.mean, to_first = s.from_mean(vec2(0.5f)),
             to_last = s.from_mean(vec2(v.width - 0.5f, v.height - 0.5f));
  out.visible = to_first.x <= half_width && -to_last.x <= half_width && to_first.y <= half_height &&
                -to_last.y <= half_height;
  const float slack = part_slack(half_width, half_height);
  const float x = half_width + slack, y = half_height + slack;
  out.visible = out.visible && mean.x + x >= v.left + 0.5f && mean.x - x <= v.right - 0.5f &&
                mean.y + y >= v.top + 0.5f && mean.y - y <= v.bottom - 0.5f;
  return out;
}

/// Whether a Gaussian of this opacity is drawn at all.
SWIFTGS_HD inline bool is_opaque_enough(const ViewConstants& v, float opacity) {
  return opacity >= v.alpha_min && opacity < INFINITY;
}

/// Depth of a point in camera space.
SWIFTGS_HD inline float depth_of(const ViewConstants& v, const dvec3& p) {
  return float(v.depth_scale * (v.depth_is_distance ? std::sqrt(dot(p, p)) : p.z));
}

/// Drawn depth of a splat whose order is by `order`.
SWIFTGS_HD SWIFTGS_NOINLINE inline float depth_beside_order(const ViewConstants& v, vec3 mean) {
  const CameraPoint at(v, mean);
  return depth_of(v, {at.p[0], at.p[1], at.p[2]});
}
SWIFTGS_HD inline float drawn_depth(const ViewConstants& v, const SceneView& scene, std::size_t i,
                                    float order) {
  return v.order_is_distance ? depth_beside_order(v, scene.means[i]) : order;
}

/// `project_shape` of views that are `through_lens`.
SWIFTGS_HD inline ProjectedShape project_through_lens(const ViewConstants& v, const Gaussian& g) {
  const float opacity = v.opacity * g.opacity;
  if (!is_opaque_enough(v, opacity)) return {};
  const CameraPoint at_mean(v, g.mean);
  const dvec3 p(at_mean.p[0], at_mean.p[1], at_mean.p[2]);
  const float depth = depth_of(v, p);
  if (!(depth > v.near_plane && depth <= v.far_plane)) return {};
  const LensPoint at = point_through(v.lens, v.limits, p);
  if (!at.inside) return {};

  const double x = v.nearest_copy(std::fma(v.fx, at.u, v.cx)), y = std::fma(v.fy, at.v, v.cy);
  const LensSlopes by{at.du, at.dv, v.fx, v.fy};
  const SplatFactor f = factor(ImageAxes<double>(v, by, g.scale, g.rotation), double(v.blur), v.antialiased);
  const float order = v.order_is_distance ? float(v.depth_scale * std::sqrt(dot(p, p))) : depth;
  return visible_shape(v, x, y, f, opacity, order);
}

/// The factor of a splat through a pinhole. Computed in float, it would err by three times what storing it
/// rounds, and pixels would cross `alpha_min`.
SWIFTGS_HD inline SplatFactor pinhole_factor(const ViewConstants& v, double x_over_z, double y_over_z,
                                             double inverse_z, const Gaussian& g) {
  // Linearise within the limits of the conventions.
  const Linearisation<double> at{v.clamped_x(x_over_z), v.clamped_y(y_over_z), v.fx * inverse_z,
                                 v.fy * inverse_z};
  return factor(ImageAxes<double>(v, at, g.scale, g.rotation), double(v.blur), v.antialiased);
}

/// Not inlined: few splats call it, and inlined it would raise the registers of all.
SWIFTGS_HD SWIFTGS_NOINLINE inline SplatFactor factor_in_double(const ViewConstants& v, double x_over_z,
                                                                double y_over_z, double inverse_z,
                                                                const Gaussian& g) {
  return pinhole_factor(v, x_over_z, y_over_z, inverse_z, g);
}

/// `pinhole_factor` of GPUs that project in pairs of floats: they have few units for double, and take them
/// where float is far worse.
SWIFTGS_HD inline SplatFactor pinhole_factor(const ViewConstants& v, FloatPair x_over_z, FloatPair y_over_z,
                                             FloatPair inverse_z, const Gaussian& g) {
  const float over_z = float(inverse_z);
  const Linearisation<float> at{v.clamped_x(float(x_over_z)), v.clamped_y(float(y_over_z)),
                                v.focal_x * over_z, v.focal_y * over_z};
  const float mean_x = std::fma(v.focal_x, float(x_over_z), v.pairs.cx.high);
  const float mean_y = std::fma(v.focal_y, float(y_over_z), v.pairs.cy.high);
  return needs_double(at, g.scale, mean_x, mean_y)
             ? factor_in_double(v, double(x_over_z), double(y_over_z), double(inverse_z), g)
             : factor(ImageAxes<float>(v, at, g.scale, g.rotation), v.blur, v.antialiased);
}

/// `project_shape` of other views.
template <class Real = ProjectingReal>
SWIFTGS_HD ProjectedShape project_through_pinhole(const ViewConstants& v, const Gaussian& g) {
  const float opacity = v.opacity * g.opacity;
  if (!is_opaque_enough(v, opacity)) return {};
  const ProjectingConstants<Real> constants(v);
  const CameraPoint<Real> at_mean(v, g.mean);
  const Real* const p = at_mean.p;
  const float z = float(constants.depth_scale() * p[2]);
  if (!(z > v.near_plane && z <= v.far_plane)) return {};
  const Real inverse_z = inverse(p[2]), x_over_z = p[0] * inverse_z, y_over_z = p[1] * inverse_z;

  // Linearise within the limits of the conventions.
  const Real x = multiply_add(constants.fx(), x_over_z, constants.cx());
  const Real y = multiply_add(constants.fy(), y_over_z, constants.cy());
  const SplatFactor f = pinhole_factor(v, x_over_z, y_over_z, inverse_z, g);
  return visible_shape(v, x, y, f, opacity, z);
}

/// Projects a Gaussian. `visible` is false where no shown pixel can keep it: too near or far, too
/// faint, or the box of its ellipse s <= cutoff holds no pixel centre. Spherical harmonics are not looked at.
SWIFTGS_HD inline ProjectedShape project_shape(const ViewConstants& v, const Gaussian& g) {
  return v.through_lens ? project_through_lens(v, g) : project_through_pinhole(v, g);
}

}  // namespace swiftgs
