// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <swiftgs/reference.hpp>

#include "reference/oracle_lens.hpp"
#include "reference/oracle_projection.hpp"

namespace swiftgs::test {

/// Above this, a variance in the image leaves a Gaussian out @units{pixels^2}.
inline constexpr Real largest_variance = 1e36L;

/// Whether every number of Gaussian `i` is finite.
inline bool all_finite(const Scene& scene, std::size_t i) {
  const Quaternion q = scene.rotations[i];
  bool finite = std::isfinite(scene.opacities[i]) && std::isfinite(q.w) && std::isfinite(q.x) &&
                std::isfinite(q.y) && std::isfinite(q.z);
  for (int k = 0; k < 3; ++k)
    finite = finite && std::isfinite(scene.means[i][k]) && std::isfinite(scene.scales[i][k]) &&
             std::isfinite(scene.sh0[i][k]);
  const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  for (std::size_t k = 0; k < rest; ++k) finite = finite && std::isfinite(scene.sh_rest[i * rest + k]);
  return finite;
}

/// The camera's place in the world: the solution of rotation * centre = -translation by Cramer's rule.
inline Real3 centre_of(const Camera& camera) {
  const Real3 a = row_of(camera, 0), b = row_of(camera, 1), c = row_of(camera, 2);
  const Real3 bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
  const dvec3 t = camera.translation;
  Real3 centre;
  for (std::size_t k = 0; k < 3; ++k)
    centre[k] = -(Real(t.x) * bc[k] + Real(t.y) * ca[k] + Real(t.z) * ab[k]) / dot(a, bc);
  return centre;
}

/// A Gaussian where its scene is placed in the world.
struct WorldGaussian {
  const ReferenceScene& placed;
  std::size_t i;             ///< in its scene
  Real3 mean, mean_sizes{};  ///< and the magnitudes that it sums
  Real3 scale;
  Real3 axes[3], axis_sizes[3]{};  ///< where its local axes point, likewise

  WorldGaussian(const ReferenceScene& from, std::size_t number) : placed(from), i(number) {
    const Scene& scene = placed.scene;
    const Similarity& pose = placed.world_from_scene;
    const Real3 local{scene.means[i].x, scene.means[i].y, scene.means[i].z};
    mean = Real3{pose.translation.x, pose.translation.y, pose.translation.z};
    mean_sizes = magnitudes(mean);
    for (std::size_t k = 0; k < 3; ++k) {
      const Real3 row = row_of(pose.rotation, int(k));
      mean[k] += pose.scale * dot(row, local);
      mean_sizes[k] += pose.scale * dot(magnitudes(row), magnitudes(local));
      scale[k] = Real(pose.scale) * scene.scales[i][int(k)];
      Real3 axis{};
      axis[k] = 1;
      axis = turn(scene.rotations[i], axis);
      for (std::size_t to = 0; to < 3; ++to) {
        const Real3 turned = row_of(pose.rotation, int(to));
        axes[k][to] = dot(turned, axis), axis_sizes[k][to] = dot(magnitudes(turned), magnitudes(axis));
      }
    }
  }
  bool is_shown() const {
    const Clip& clip = placed.clip;
    const vec3 m = placed.scene.means[i];
    Real off = 0;
    for (int k = 0; k < 3; ++k) off += (Real(m[k]) - clip.centre[k]) * (Real(m[k]) - clip.centre[k]);
    bool inside = off <= Real(clip.radius) * clip.radius;
    for (int h = 0; h < clip.half_space_count; ++h) {
      const vec4 p = clip.half_spaces[h];
      inside = inside && Real(p.x) * m.x + Real(p.y) * m.y + Real(p.z) * m.z + p.w >= 0;
    }
    return inside;
  }
};

/// Colour of a Gaussian as the camera sees it, in a direction of its scene.
inline void set_colour(OracleSplat& s, const WorldGaussian& g, const Camera& camera) {
  const Real3 centre = centre_of(camera);
  const Scene& scene = g.placed.scene;
  const Real3 to{g.mean[0] - centre[0], g.mean[1] - centre[1], g.mean[2] - centre[2]};
  const Real length = std::hypot(to[0], to[1], to[2]);
  Real size = 0;
  Real3 d{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t row = 0; row < 3; ++row)
      d[k] += g.placed.world_from_scene.rotation[int(k)][int(row)] * to[row] / length;
    size += g.mean_sizes[k] + std::abs(centre[k]);
  }
  const std::array<Real, 16> basis = oracle_harmonics(d[0], d[1], d[2]);
  // The gradient of a band l <= 3 is at most 4 on the unit sphere. A translation of double has its own
  // error, which the inverse of the rotation spreads to all members.
  const Real direction = 32 * unit * size / length;
  const std::size_t rest = std::size_t(sh_rest_count(scene.sh_degree));
  for (std::size_t c = 0; c < 3; ++c) {
    Real sum = 0.5L, sizes = 0.5L;
    for (std::size_t k = 0; k <= rest; ++k) {
      const Real v = k == 0 ? scene.sh0[g.i][int(c)] : scene.sh_rest[3 * (g.i * rest + k - 1) + c];
      sum += basis[k] * v, sizes += std::abs(v);
    }
    const Tint& tint = g.placed.tint;
    const Real amount = tint.amount, tinting = amount * tint.colour[int(c)];
    s.colour[c] = (1 - amount) * std::max(Real(0), sum) + tinting;
    s.doubt.colour[c] = sizes * (4 * direction + 32 * unit) + tinting * 4 * unit;
  }
}

/// Normal of the Gaussian at `p` in camera space.
inline void set_normal(OracleSplat& s, const WorldGaussian& g, const Real3& p, const Real3& p_error,
                       const Camera& camera) {
  const auto& [x, y, z] = g.scale;
  const std::size_t shortest = x <= y && x <= z ? 0 : y <= z ? 1 : 2;
  const Real3 &world = g.axes[shortest], &sizes = g.axis_sizes[shortest];
  const bool parallel = camera.lens.model == LensModel::orthographic;
  const Real3 ray = parallel ? Real3{0, 0, 1} : p, off = parallel ? Real3{} : p_error;
  Real towards = 0, doubt = 0;
  for (std::size_t r = 0; r < 3; ++r) {
    s.normal[r] = dot(row_of(camera, int(r)), world);
    s.doubt.normal += 32 * unit * dot(magnitudes(row_of(camera, int(r))), sizes);
    towards += s.normal[r] * ray[r], doubt += 2 * off[r] + 32 * unit * std::abs(ray[r]);
  }
  if (towards > 0)
    for (Real& component : s.normal) component = -component;
  if (std::abs(towards) <= doubt) s.doubt.normal = 2;
}

/// Slope of depth along the ray, C^-1 of the covariance of depth with the place in the image, by the Cholesky
/// factor `l` of C. Errors are bounded as those of a least-squares problem: the smallest variance of C is
/// more than its determinant over its trace.
inline void set_slope(OracleSplat& s, const WorldGaussian& g, const ImageFactor& f, const Triangle& l,
                      const Real3& p, const Real3& p_error, const Camera& camera, const Conventions& k) {
  const auto length = [](const Real3& a) { return std::hypot(a[0], a[1], a[2]); };
  const Real3 unit_ray{p[0] / length(p), p[1] / length(p), p[2] / length(p)};
  const Real3 ahead = by_distance(camera, k) ? unit_ray : Real3{0, 0, 1};
  Real3 depth{};
  Real sizes = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Real3& world = g.axes[axis];
    const Real scale = g.scale[axis];
    for (std::size_t r = 0; r < 3; ++r) depth[axis] += scale * ahead[r] * dot(row_of(camera, int(r)), world);
    sizes += scale * length(g.axis_sizes[axis]);
  }
  const Real x = dot(f.x, depth) / l.l00, y = (dot(f.y, depth) - l.l10 * x) / l.l11;
  s.slope_y = y / l.l11, s.slope_x = (x - l.l10 * s.slope_y) / l.l00;

  const Real trace = l.xx() + l.yy(), narrowest = l.determinant() / trace;
  const Real places = length(f.x_error) + length(f.y_error) + 64 * unit * std::sqrt(trace);
  const Real depths = sizes * (64 * unit + (by_distance(camera, k) ? length(p_error) / length(p) : 0));
  s.doubt.slope = 2 * (places * std::hypot(s.slope_x, s.slope_y) + depths) / std::sqrt(narrowest) +
                  2 * places * length(depth) / narrowest;
}

/// Whether the planes keep a depth that is already rounded.
inline bool between_planes(float z, const Conventions& k) {
  return (k.cull_at_near ? z > k.near_plane : z >= k.near_plane) && z <= k.far_plane && std::isfinite(z);
}

/// Sets the mean and its errors from `p`, the Gaussian's place in camera space.
inline void set_position(OracleSplat& s, const Real3& p, const Real3& p_error, const Camera& camera) {
  s.x = camera.fx * p[0] / p[2] + camera.cx, s.y = camera.fy * p[1] / p[2] + camera.cy;
  const auto error = [&](std::size_t k, Real focal, Real principal) {
    const Real tangent = p[k] / p[2], offset = std::abs(focal * tangent);
    return focal / std::abs(p[2]) * (p_error[k] + std::abs(tangent) * p_error[2]) +
           4 * unit * (offset + std::abs(principal));
  };
  s.doubt.position_x = error(0, camera.fx, camera.cx), s.doubt.position_y = error(1, camera.fy, camera.cy);
}

/// Sets the mean of a pinhole's splat and maps the Gaussian's axes to the image.
inline std::optional<ImageFactor> through_pinhole(OracleSplat& s, const WorldGaussian& g, const Real3& p,
                                                  const Real3& p_error, const Camera& camera,
                                                  const Conventions& k) {
  if (p[2] == 0) return {};
  const Real3 rows[3] = {row_of(camera, 0), row_of(camera, 1), row_of(camera, 2)};
  set_position(s, p, p_error, camera);
  Real tx = p[0] / p[2], ty = p[1] / p[2];
  limit(tx, ty, camera, k.clamp);
  const Real jx = camera.fx / p[2], jy = camera.fy / p[2];
  const Real relative = 32 * unit + p_error[2] / std::abs(p[2]);
  ImageFactor f;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Real3& world = g.axes[axis];
    const Real scale = g.scale[axis], ahead = dot(rows[2], world);
    f.x[axis] = jx * scale * (dot(rows[0], world) - tx * ahead);
    f.y[axis] = jy * scale * (dot(rows[1], world) - ty * ahead);
    const Real3& sizes = g.axis_sizes[axis];
    const Real x = dot(magnitudes(rows[0]), sizes), y = dot(magnitudes(rows[1]), sizes);
    const Real z = dot(magnitudes(rows[2]), sizes);
    f.x_error[axis] = scale * std::abs(jx) * (x + std::abs(tx) * z) * relative +
                      scale * z * s.doubt.position_x / std::abs(p[2]);
    f.y_error[axis] = scale * std::abs(jy) * (y + std::abs(ty) * z) * relative +
                      scale * z * s.doubt.position_y / std::abs(p[2]);
  }
  return f;
}

/// The same of other lenses. Their derivatives err by some hundred units: a point's error bends them as much
/// as the point's angle, and polynomials add tens of roundings of terms about as large as their sum.
inline std::optional<ImageFactor> through_lens(OracleSplat& s, const WorldGaussian& g, const Real3& p,
                                               const Real3& p_error, const Camera& camera,
                                               const Conventions& k) {
  const Sight seen = sight(camera, k, p);
  if (!seen.inside) return {};
  const Real off = std::hypot(p_error[0], p_error[1], p_error[2]);
  const Real relative = 128 * unit + 16 * off / std::hypot(p[0], p[1], p[2]);
  const auto length = [](const Real3& a) { return std::hypot(a[0], a[1], a[2]); };
  const auto place = [&](const Dual& at, Real focal, Real principal, Real& pixel, Real& error) {
    pixel = focal * at.value + principal;
    error =
        focal * (length(at.by) * off + 64 * unit * (1 + std::abs(at.value))) + 4 * unit * std::abs(principal);
  };
  place(seen.u, camera.fx, camera.cx, s.x, s.doubt.position_x);
  place(seen.v, camera.fy, camera.cy, s.y, s.doubt.position_y);
  ImageFactor f;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Real3& world = g.axes[axis];
    const Real3 at{dot(row_of(camera, 0), world), dot(row_of(camera, 1), world),
                   dot(row_of(camera, 2), world)};
    const Real scale = g.scale[axis];
    f.x[axis] = camera.fx * scale * dot(seen.u.by, at), f.y[axis] = camera.fy * scale * dot(seen.v.by, at);
    const Real size = scale * length(g.axis_sizes[axis]);
    f.x_error[axis] = camera.fx * size * length(seen.u.by) * relative;
    f.y_error[axis] = camera.fy * size * length(seen.v.by) * relative;
  }
  return f;
}

/// Projects a Gaussian, the frame's `number`; nothing where it is surely not drawn.
inline std::optional<OracleSplat> project_gaussian(const WorldGaussian& g, std::size_t number,
                                                   const Camera& camera, const Conventions& k) {
  const Scene& scene = g.placed.scene;
  if (!all_finite(scene, g.i) || !g.is_shown()) return {};
  OracleSplat s;
  s.index = number;

  // Camera space. A row of double arithmetic errs by at most four units of the sum of its magnitudes, and a
  // placed one by twice as many.
  const Real units = g.placed.world_from_scene.is_identity() ? 4 : 8;
  const Real3 rows[3] = {row_of(camera, 0), row_of(camera, 1), row_of(camera, 2)};
  Real3 p, p_error;
  for (std::size_t r = 0; r < 3; ++r) {
    p[r] = dot(rows[r], g.mean) + Real(camera.translation[int(r)]);
    const Real sizes = dot(magnitudes(rows[r]), g.mean_sizes) + std::abs(camera.translation[int(r)]);
    p_error[r] = units * unit * sizes;
  }
  s.z = p[2], s.doubt.z = p_error[2];
  if (by_distance(camera, k)) {
    s.z = std::hypot(p[0], p[1], p[2]);
    s.doubt.z = std::hypot(p_error[0], p_error[1], p_error[2]) + 8 * unit * s.z;
  }
  s.depth = s.order = float(s.z);
  s.doubt.nearest = float(s.z - s.doubt.z), s.doubt.furthest = float(s.z + s.doubt.z);
  s.drawn = between_planes(s.depth, k);
  s.doubt.drawn =
      s.drawn != between_planes(s.doubt.nearest, k) || s.drawn != between_planes(s.doubt.furthest, k);
  if (!s.drawn && !s.doubt.drawn) return {};
  if (k.order == SplatOrder::distance) {
    const Real distance = std::hypot(p[0], p[1], p[2]);
    const Real error = std::hypot(p_error[0], p_error[1], p_error[2]) + 8 * unit * distance;
    s.order = float(distance);
    s.doubt.nearest = float(distance - error), s.doubt.furthest = float(distance + error);
  }
  const std::optional<ImageFactor> found = camera.lens.is_pinhole()
                                               ? through_pinhole(s, g, p, p_error, camera, k)
                                               : through_lens(s, g, p, p_error, camera, k);
  if (!found) return {};
  const ImageFactor& f = *found;

  const Triangle l(f, k.blur.value_or(0.3f)), sharp(f, 0);
  if (!(l.determinant() > 0) || l.xx() > largest_variance || l.yy() > largest_variance) return {};
  s.l00 = l.l00, s.l10 = l.l10, s.l11 = l.l11;
  s.opacity = Real(scene.opacities[g.i]) * g.placed.opacity;
  if (k.antialiased.value_or(false))
    s.opacity *= std::sqrt(std::max(Real(k.min_compensation), sharp.determinant() / l.determinant()));
  bound_shape(f, l, sharp, k, s);
  set_footprint(s, l, camera, k);
  if (k.depth_at == Conventions::DepthAt::ray) set_slope(s, g, f, l, p, p_error, camera, k);
  set_colour(s, g, camera);
  set_normal(s, g, p, p_error, camera);
  const std::size_t channels = std::size_t(scene.feature_channels);
  s.features = {scene.features.data() + channels * g.i, channels};
  return s;
}

}  // namespace swiftgs::test
