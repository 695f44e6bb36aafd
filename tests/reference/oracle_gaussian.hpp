// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

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

/// Colour of Gaussian `i` as seen from `centre`.
inline void set_colour(OracleSplat& s, const Scene& scene, const Real3& mean, const Camera& camera) {
  const Real3 centre = centre_of(camera);
  Real3 d{mean[0] - centre[0], mean[1] - centre[1], mean[2] - centre[2]};
  const Real length = std::hypot(d[0], d[1], d[2]);
  Real size = 0;
  for (std::size_t k = 0; k < 3; ++k) d[k] /= length, size += std::abs(mean[k]) + std::abs(centre[k]);
  const std::array<Real, 16> basis = oracle_harmonics(d[0], d[1], d[2]);
  // The gradient of a band l <= 3 is at most 4 on the unit sphere. A translation of double has its own
  // error, which the inverse of the rotation spreads to all members.
  const Real direction = 32 * unit * size / length;
  const std::size_t rest = std::size_t(sh_rest_count(scene.sh_degree));
  for (std::size_t c = 0; c < 3; ++c) {
    Real sum = 0.5L, sizes = 0.5L;
    for (std::size_t k = 0; k <= rest; ++k) {
      const Real v = k == 0 ? scene.sh0[s.index][int(c)] : scene.sh_rest[3 * (s.index * rest + k - 1) + c];
      sum += basis[k] * v, sizes += std::abs(v);
    }
    s.colour[c] = std::max(Real(0), sum);
    s.doubt.colour[c] = sizes * (4 * direction + 32 * unit);
  }
}

/// Normal of the Gaussian at `p` in camera space.
inline void set_normal(OracleSplat& s, const Scene& scene, const Real3& p, const Real3& p_error,
                       const Camera& camera) {
  const vec3 scale = scene.scales[s.index];
  Real3 local{};
  if (scale.x <= scale.y && scale.x <= scale.z)
    local[0] = 1;
  else
    local[scale.y <= scale.z ? 1 : 2] = 1;
  const Real3 world = turn(scene.rotations[s.index], local);
  const bool parallel = camera.lens.model == LensModel::orthographic;
  const Real3 ray = parallel ? Real3{0, 0, 1} : p, off = parallel ? Real3{} : p_error;
  Real towards = 0, doubt = 0;
  for (std::size_t r = 0; r < 3; ++r) {
    s.normal[r] = dot(row_of(camera, int(r)), world);
    s.doubt.normal += 32 * unit * dot(magnitudes(row_of(camera, int(r))), magnitudes(world));
    towards += s.normal[r] * ray[r], doubt += 2 * off[r] + 32 * unit * std::abs(ray[r]);
  }
  if (towards > 0)
    for (Real& component : s.normal) component = -component;
  if (std::abs(towards) <= doubt) s.doubt.normal = 2;
}

/// Slope of depth along the ray, C^-1 of the covariance of depth with the place in the image, by the Cholesky
/// factor `l` of C. Errors are bounded as those of a least-squares problem: the smallest variance of C is
/// more than its determinant over its trace.
inline void set_slope(OracleSplat& s, const Scene& scene, const ImageFactor& f, const Triangle& l,
                      const Real3& p, const Real3& p_error, const Camera& camera, const Conventions& k) {
  const auto length = [](const Real3& a) { return std::hypot(a[0], a[1], a[2]); };
  const Real3 unit_ray{p[0] / length(p), p[1] / length(p), p[2] / length(p)};
  const Real3 ahead = by_distance(camera, k) ? unit_ray : Real3{0, 0, 1};
  Real3 depth{};
  Real sizes = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Real3 local{};
    local[axis] = 1;
    const Real3 world = turn(scene.rotations[s.index], local);
    const Real scale = scene.scales[s.index][int(axis)];
    for (std::size_t r = 0; r < 3; ++r) depth[axis] += scale * ahead[r] * dot(row_of(camera, int(r)), world);
    sizes += scale * length(world);
  }
  const Real x = dot(f.x, depth) / l.l00, y = (dot(f.y, depth) - l.l10 * x) / l.l11;
  s.slope_y = y / l.l11, s.slope_x = (x - l.l10 * s.slope_y) / l.l00;

  const Real trace = l.xx() + l.yy(), narrowest = l.determinant() / trace;
  const Real places = length(f.x_error) + length(f.y_error) + 64 * unit * std::sqrt(trace);
  const Real depths = sizes * (64 * unit + (by_distance(camera, k) ? length(p_error) / length(p) : 0));
  s.doubt.slope = 2 * (places * std::hypot(s.slope_x, s.slope_y) + depths) / std::sqrt(narrowest) +
                  2 * places * length(depth) / narrowest;
}

/// Limits of x/z or y/z in the linearised projection.
inline Real limited(Real tangent, Real side, Real focal, Real principal, Conventions::JacobianClamp clamp) {
  const Real half = side / (2 * focal);
  const bool image = clamp == Conventions::JacobianClamp::around_image;
  const Real low = image ? -principal / focal - 0.3L * half : -1.3L * half;
  const Real high = image ? (side - principal) / focal + 0.3L * half : 1.3L * half;
  return std::min(high, std::max(low, tangent));
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
inline std::optional<ImageFactor> through_pinhole(OracleSplat& s, const Scene& scene, const Real3& p,
                                                  const Real3& p_error, const Camera& camera,
                                                  const Conventions& k) {
  if (p[2] == 0) return {};
  const Real3 rows[3] = {row_of(camera, 0), row_of(camera, 1), row_of(camera, 2)};
  set_position(s, p, p_error, camera);
  const Real tx = limited(p[0] / p[2], camera.width, camera.fx, camera.cx, k.clamp);
  const Real ty = limited(p[1] / p[2], camera.height, camera.fy, camera.cy, k.clamp);
  const Real jx = camera.fx / p[2], jy = camera.fy / p[2];
  const Real relative = 32 * unit + p_error[2] / std::abs(p[2]);
  ImageFactor f;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Real3 local{};
    local[axis] = 1;
    const Real3 world = turn(scene.rotations[s.index], local);
    const Real scale = scene.scales[s.index][int(axis)], ahead = dot(rows[2], world);
    f.x[axis] = jx * scale * (dot(rows[0], world) - tx * ahead);
    f.y[axis] = jy * scale * (dot(rows[1], world) - ty * ahead);
    const Real3 sizes = magnitudes(world);
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
inline std::optional<ImageFactor> through_lens(OracleSplat& s, const Scene& scene, const Real3& p,
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
    Real3 local{};
    local[axis] = 1;
    const Real3 world = turn(scene.rotations[s.index], local);
    const Real3 at{dot(row_of(camera, 0), world), dot(row_of(camera, 1), world),
                   dot(row_of(camera, 2), world)};
    const Real scale = scene.scales[s.index][int(axis)];
    f.x[axis] = camera.fx * scale * dot(seen.u.by, at), f.y[axis] = camera.fy * scale * dot(seen.v.by, at);
    f.x_error[axis] = camera.fx * scale * length(seen.u.by) * length(world) * relative;
    f.y_error[axis] = camera.fy * scale * length(seen.v.by) * length(world) * relative;
  }
  return f;
}

/// Projects Gaussian `i`; nothing where it is surely not drawn.
inline std::optional<OracleSplat> project_gaussian(const Scene& scene, std::size_t i, const Camera& camera,
                                                   const Conventions& k) {
  if (!all_finite(scene, i)) return {};
  OracleSplat s;
  s.index = i;

  // Camera space. A row of double arithmetic errs by at most four units of the sum of its magnitudes.
  const Real3 mean{scene.means[i].x, scene.means[i].y, scene.means[i].z};
  const Real3 rows[3] = {row_of(camera, 0), row_of(camera, 1), row_of(camera, 2)};
  Real3 p, p_error;
  for (std::size_t r = 0; r < 3; ++r) {
    p[r] = dot(rows[r], mean) + Real(camera.translation[int(r)]);
    const Real sizes = dot(magnitudes(rows[r]), magnitudes(mean)) + std::abs(camera.translation[int(r)]);
    p_error[r] = 4 * unit * sizes;
  }
  s.z = p[2], s.doubt.z = p_error[2];
  if (by_distance(camera, k)) {
    s.z = std::hypot(p[0], p[1], p[2]);
    s.doubt.z = std::hypot(p_error[0], p_error[1], p_error[2]) + 8 * unit * s.z;
  }
  s.depth = float(s.z);
  s.doubt.nearest = float(s.z - s.doubt.z), s.doubt.furthest = float(s.z + s.doubt.z);
  s.drawn = between_planes(s.depth, k);
  s.doubt.drawn =
      s.drawn != between_planes(s.doubt.nearest, k) || s.drawn != between_planes(s.doubt.furthest, k);
  if (!s.drawn && !s.doubt.drawn) return {};
  const std::optional<ImageFactor> found = camera.lens.is_pinhole()
                                               ? through_pinhole(s, scene, p, p_error, camera, k)
                                               : through_lens(s, scene, p, p_error, camera, k);
  if (!found) return {};
  const ImageFactor& f = *found;

  const Triangle l(f, k.blur), sharp(f, 0);
  if (!(l.determinant() > 0) || l.xx() > largest_variance || l.yy() > largest_variance) return {};
  s.l00 = l.l00, s.l10 = l.l10, s.l11 = l.l11;
  s.opacity = scene.opacities[i];
  if (k.antialiased)
    s.opacity *= std::sqrt(std::max(Real(k.min_compensation), sharp.determinant() / l.determinant()));
  bound_shape(f, l, sharp, k, s);
  set_footprint(s, l, camera, k);
  if (k.depth_at == Conventions::DepthAt::ray) set_slope(s, scene, f, l, p, p_error, camera, k);
  set_colour(s, scene, mean, camera);
  set_normal(s, scene, p, p_error, camera);
  const std::size_t channels = std::size_t(scene.feature_channels);
  s.features = {scene.features.data() + channels * i, channels};
  return s;
}

}  // namespace swiftgs::test
