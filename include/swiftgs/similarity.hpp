// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include <glm/matrix.hpp>

#include <swiftgs/camera.hpp>
#include <swiftgs/edit/finite.hpp>
#include <swiftgs/math.hpp>

namespace swiftgs {

/// A movement that keeps shapes: p becomes scale * rotation p + translation.
struct Similarity {
  dmat3 rotation{1.0};  ///< orthonormal, of determinant 1; GLM stores it by columns: rotation[column][row]
  double scale = 1;     ///< above 0
  dvec3 translation{0.0};

  dvec3 operator()(const dvec3& p) const { return scale * (rotation * p) + translation; }

  /// As `validate` has it: finite, orthonormal, no mirror.
  SWIFTGS_HD bool is_valid() const {
    const dvec3 &x = rotation[0], &y = rotation[1], &z = rotation[2];
    const auto near = [](double value, double wanted) { return std::fabs(value - wanted) < 1e-6; };
    const double determinant =
        x.x * (y.y * z.z - y.z * z.y) - y.x * (x.y * z.z - x.z * z.y) + z.x * (x.y * y.z - x.z * y.y);
    return near(dot(x, x), 1) && near(dot(y, y), 1) && near(dot(z, z), 1) && near(dot(x, y), 0) &&
           near(dot(x, z), 0) && near(dot(y, z), 0) && determinant > 0 && scale > 0 && scale < INFINITY &&
           std::fabs(translation.x) < INFINITY && std::fabs(translation.y) < INFINITY &&
           std::fabs(translation.z) < INFINITY;
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

/// Throws `std::invalid_argument` that names the first invalid member of what `what` says.
inline void validate(const Similarity& by, const char* what = "transform") {
  const auto require = [&](bool holds, const char* expected) {
    if (!holds) throw std::invalid_argument(std::string(what) + ": expected " + expected);
  };
  require(detail::is_finite(by.scale) && by.scale > 0, "a finite scale above 0");
  for (int i = 0; i < 3; ++i) {
    require(detail::is_finite(by.translation[i]), "a finite translation");
    for (int j = 0; j < 3; ++j)
      require(std::abs(detail::dot(by.rotation[i], by.rotation[j]) - (i == j ? 1.0 : 0.0)) < 1e-6,
              "a rotation with orthonormal columns");
  }
  require(detail::dot(detail::cross(by.rotation[0], by.rotation[1]), by.rotation[2]) > 0,
          "a rotation, not a mirror");
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
