// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Projection in long double, from the floats and doubles that the float stages get.

#include <algorithm>
#include <array>
#include <cmath>

#include <swiftgs/project/project.hpp>

#include "reference/oracle_projection.hpp"
#include "stability/ulps.hpp"

namespace swiftgs::test {

using Rotation = std::array<Real3, 3>;

/// v turned by q as it is stored, unit or not: v + 2 w (u x v) + 2 u x (u x v).
inline Real3 turned(const Real* q, const Real3& v) {
  const Real3 u{q[1], q[2], q[3]}, once = cross(u, v), twice = cross(u, once);
  return {v[0] + 2 * (q[0] * once[0] + twice[0]), v[1] + 2 * (q[0] * once[1] + twice[1]),
          v[2] + 2 * (q[0] * once[2] + twice[2])};
}

/// Rows of J W R S at camera-space direction (tx, ty, 1) and depth z.
struct ExactAxes {
  Real3 x, y;

  ExactAxes(const Rotation& w, Real fx, Real fy, Real tx, Real ty, Real z, const Real* scale, const Real* q) {
    for (std::size_t k = 0; k < 3; ++k) {
      Real3 axis{};
      axis[k] = 1;
      axis = turned(q, axis);
      const Real ahead = dot(w[2], axis);
      x[k] = fx / z * scale[k] * (dot(w[0], axis) - tx * ahead);
      y[k] = fy / z * scale[k] * (dot(w[1], axis) - ty * ahead);
    }
  }
};

/// Inputs of projection in this order: mean, scale, quaternion, opacity, the camera's rotation by rows.
using ProjectionInputs = std::array<Real, 20>;

inline ProjectionInputs inputs_of(const ViewConstants& v, const Gaussian& g) {
  ProjectionInputs in{g.mean.x,     g.mean.y,     g.mean.z,     g.scale.x,    g.scale.y, g.scale.z,
                      g.rotation.w, g.rotation.x, g.rotation.y, g.rotation.z, g.opacity};
  for (std::size_t i = 0; i < 9; ++i) in[11 + i] = v.rotation[i / 3][i % 3];
  return in;
}

/// Indices of the results.
namespace result {
enum Index : std::size_t {
  mean_x,
  mean_y,
  depth,
  determinant,
  l0,
  l1,
  l2,
  opacity,
  cutoff,
  half_width,
  l1_scale,
  blurred,
  var_y,
  xy,
  count
};
}
using ProjectionResults = std::array<Real, result::count>;

/// sqrt(log2(e) / 2)
inline const Real exact_base_2 = std::sqrt(1 / (2 * std::log(Real(2))));

/// All of `project_shape`, each number before it is rounded. The determinant is that of the two rows, by
/// minors. `l1_scale` is l0 times the product of the rows' lengths over the variance of y.
inline ProjectionResults project_exactly(const ViewConstants& v, const ProjectionInputs& in) {
  const Rotation w{Real3{in[11], in[12], in[13]}, Real3{in[14], in[15], in[16]},
                   Real3{in[17], in[18], in[19]}};
  const Real3 d{in[0] - Real(v.centre[0]), in[1] - Real(v.centre[1]), in[2] - Real(v.centre[2])};
  const Real3 p{dot(w[0], d), dot(w[1], d), dot(w[2], d)};
  using namespace result;
  ProjectionResults out{};
  out[mean_x] = Real(v.fx) * p[0] / p[2] + Real(v.cx);
  out[mean_y] = Real(v.fy) * p[1] / p[2] + Real(v.cy);
  out[depth] = p[2];
  const Real tx = std::clamp(p[0] / p[2], Real(v.limits.least_u), Real(v.limits.most_u));
  const Real ty = std::clamp(p[1] / p[2], Real(v.limits.least_v), Real(v.limits.most_v));
  const ExactAxes m(w, Real(v.fx), Real(v.fy), tx, ty, p[2], &in[3], &in[6]);

  const Real3 c = cross(m.x, m.y);
  const Real xx = dot(m.x, m.x), yy = dot(m.y, m.y), blur = v.blur;
  out[determinant] = dot(c, c), out[xy] = dot(m.x, m.y);
  out[var_y] = yy + blur, out[blurred] = out[determinant] + blur * (xx + yy + blur);
  out[l0] = exact_base_2 / std::sqrt(out[blurred] / out[var_y]);
  out[l1] = -out[l0] * out[xy] / out[var_y];
  out[l1_scale] = out[l0] * std::sqrt(xx * yy) / out[var_y];
  out[l2] = exact_base_2 / std::sqrt(out[var_y]);
  out[opacity] = in[10];
  if (v.antialiased)
    out[opacity] *= std::sqrt(std::max(Real(v.min_compensation), out[determinant] / out[blurred]));
  out[cutoff] = std::log2(out[opacity] / Real(v.alpha_min));
  out[half_width] = std::sqrt(std::max(Real(0), out[cutoff]) * (xx + blur)) / exact_base_2;
  return out;
}

}  // namespace swiftgs::test
