// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <swiftgs/math.hpp>

namespace swiftgs::io {

/// World axes of a file, as signs: what each coordinate is multiplied by to become RDF.
struct AxisFlip {
  float x = 1, y = 1, z = 1;

  bool operator==(const AxisFlip&) const = default;

  vec3 position(vec3 p) const { return {x * p.x, y * p.y, z * p.z}; }

  /// Conjugates the rotation with the flip, which is a rotation again even if the flip is a mirror.
  Quaternion rotation(Quaternion q) const { return {q.w, y * z * q.x, x * z * q.y, x * y * q.z}; }

  /// Sign of each SH basis function above band 0 under the flip, in the order of the coefficients.
  std::array<float, 15> sh_signs() const {
    return {y, z, x, x * y, y * z, 1, x * z, 1, y, x * y * z, y, z, x, z, x};
  }
};

inline constexpr AxisFlip rub_to_rdf{1, -1, -1};
inline constexpr AxisFlip luf_to_rdf{-1, -1, 1};

}  // namespace swiftgs::io
