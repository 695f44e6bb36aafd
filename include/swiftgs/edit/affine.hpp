// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <swiftgs/edit/rotation.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/placing.hpp>

namespace swiftgs {

/// A movement that may stretch and shear: p becomes linear p + translation.
struct Affine {
  dmat3 linear{1.0};  ///< of determinant above 0; GLM stores it by columns: linear[column][row]
  dvec3 translation{0.0};

  dvec3 operator()(const dvec3& p) const { return linear * p + translation; }

  /// Says what was expected, or is null if it is valid.
  const char* unmet() const {
    if (!detail::is_finite(translation)) return "a finite translation";
    double volume = glm::determinant(linear);
    for (int axis = 0; axis < 3; ++axis) {
      // Floats hold no more, and products of three such lengths stay in the range of double.
      const double length = glm::length(linear[axis]);
      if (!(length >= 1e-60 && length <= 1e60)) return "a matrix of columns with lengths of 1e-60 to 1e60";
      volume /= length;
    }
    constexpr double flat = 1e-9;
    if (volume < -flat) return "a matrix that does not mirror";
    return volume > flat ? nullptr : "a matrix that does not flatten";
  }
};

/// Throws `InvalidArgument` that names the first invalid member of what `what` says.
inline void validate(const Affine& by, const char* what = "stretch") {
  if (const char* const expected = by.unmet()) detail::refuse(what, ": expected ", expected);
}

/// The movement by b, then by a.
inline Affine operator*(const Affine& a, const Affine& b) { return {a.linear * b.linear, a(b.translation)}; }

/// The same movement as a similarity, if it is one up to the tolerance of `Similarity::unmet`.
inline std::optional<Similarity> similarity_of(const Affine& by) {
  Similarity similar{.scale = glm::length(by.linear[0]), .translation = by.translation};
  similar.rotation = by.linear / similar.scale;
  if (similar.unmet() != nullptr) return std::nullopt;
  similar.rotation = matrix_of(quaternion_of(similar.rotation));
  return similar;
}

/// The rotation R in linear = R P, where P stretches along directions at right angles: the polar
/// decomposition. Of a rotation after a stretch along the axes it is that rotation. Throws as `validate`
/// does.
inline dmat3 rotation_of(const Affine& by) {
  validate(by, "rotation_of");
  const auto largest = [](const dmat3& m) {
    double most = 0;
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 3; ++row) most = std::max(most, std::abs(m[column][row]));
    return most;
  };
  // Newton's iteration on the singular values, which all tend to 1; they start balanced around it.
  dmat3 matrix = by.linear;
  constexpr int most_steps = 100;  // a dozen suffices
  for (int step = 0; step < most_steps; ++step) {
    const dmat3 inverse = glm::inverse(glm::transpose(matrix));
    const double balance = std::sqrt(largest(inverse) / largest(matrix));
    const dmat3 next = 0.5 * (balance * matrix + inverse / balance);
    const bool near = largest(next - matrix) < 1e-9;  // the square of it is left
    matrix = next;
    if (near) break;
  }
  return matrix_of(quaternion_of(matrix));
}

}  // namespace swiftgs
