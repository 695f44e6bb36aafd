// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <glm/matrix.hpp>

#include <swiftgs/finite.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/message.hpp>

namespace swiftgs {

/// A movement that keeps shapes: p becomes scale * rotation p + translation.
struct Similarity {
  dmat3 rotation{1.0};  ///< orthonormal, of determinant 1; GLM stores it by columns: rotation[column][row]
  double scale = 1;     ///< above 0
  dvec3 translation{0.0};

  dvec3 operator()(const dvec3& p) const { return scale * (rotation * p) + translation; }

  /// Says what was expected, or is null if it is valid.
  SWIFTGS_HD const char* unmet() const {
    if (!(detail::is_finite(scale) && scale > 0)) return "a finite scale above 0";
    if (!detail::is_finite(translation)) return "a finite translation";
    const dvec3 &x = rotation[0], &y = rotation[1], &z = rotation[2];
    const auto near = [](double value, double wanted) { return std::fabs(value - wanted) < 1e-6; };
    if (!(near(dot(x, x), 1) && near(dot(y, y), 1) && near(dot(z, z), 1) && near(dot(x, y), 0) &&
          near(dot(x, z), 0) && near(dot(y, z), 0)))
      return "a rotation with orthonormal columns";
    return dot(cross(x, y), z) > 0 ? nullptr : "a rotation, not a mirror";
  }

  SWIFTGS_HD bool is_identity() const {
    bool same = scale == 1;
    for (int i = 0; i < 3; ++i) {
      same = same && translation[i] == 0;
      for (int j = 0; j < 3; ++j) same = same && rotation[i][j] == (i == j ? 1 : 0);
    }
    return same;
  }
};

/// Throws `InvalidArgument` that names the first invalid member of what `what` says.
inline void validate(const Similarity& by, const char* what = "transform") {
  if (const char* const expected = by.unmet()) detail::refuse(what, ": expected ", expected);
}

/// The movement that undoes `by`. Throws as `validate` does.
inline Similarity inverse(const Similarity& by) {
  validate(by);
  Similarity back;
  back.rotation = glm::transpose(by.rotation), back.scale = 1 / by.scale;
  back.translation = -back.scale * (back.rotation * by.translation);
  return back;
}

}  // namespace swiftgs
