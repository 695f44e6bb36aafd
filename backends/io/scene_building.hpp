// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/scene.hpp>

/// @file
/// What every scene reader does with decoded numbers: activate them, and drop what cannot be rendered.

namespace swiftgs::io {

inline constexpr double sh_c0 = 0.28209479177387814;  ///< the basis function of band 0

/// Gives `scene` the arrays of `count` Gaussians.
void allocate(Scene& scene, std::size_t count, int sh_degree);

/// Whether all numbers of Gaussian `i` are finite.
bool renderable(const Scene& scene, std::size_t i);

/// Takes scales below 0, which linear formats can hold, without their sign, and notes of how many Gaussians.
void drop_signs_of_scales(SceneFile& file);

/// Removes the Gaussians with a value that cannot be rendered, keeping the order. Returns how many.
std::uint64_t drop_nonfinite(Scene& scene);

inline float sigmoid(float logit) { return 1 / (1 + std::exp(-logit)); }

/// Zero, which has no direction, becomes the identity; a quaternion that is not finite becomes NaN.
inline Quaternion normalised(float w, float x, float y, float z) {
  const double squared = double(w) * w + double(x) * x + double(y) * y + double(z) * z;
  if (squared == 0) return {};
  if (!std::isfinite(squared)) return {.w = std::numeric_limits<float>::quiet_NaN()};
  const double inverse = 1 / std::sqrt(squared);
  return {float(w * inverse), float(x * inverse), float(y * inverse), float(z * inverse)};
}

}  // namespace swiftgs::io
