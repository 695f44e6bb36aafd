// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <swiftgs/activation.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/sh.hpp>

/// @file
/// What every scene reader does with decoded numbers: activate them, and drop what cannot be rendered.

namespace swiftgs::io {

inline constexpr double sh_c0 = sh::c0;  ///< the basis function of band 0

/// Gives `scene` the arrays of `count` Gaussians.
void allocate(Scene& scene, std::size_t count, int sh_degree);

/// Whether all numbers of Gaussian `i` are finite.
bool renderable(const Scene& scene, std::size_t i);

/// Takes scales below 0, which linear formats can hold, without their sign, and notes of how many Gaussians.
void drop_signs_of_scales(SceneFile& file);

/// Removes the Gaussians with a value that cannot be rendered, and their `exact_means` unless these are
/// empty, keeping the order. Returns how many.
std::uint64_t drop_nonfinite(Scene& scene, std::vector<dvec3>& exact_means);
std::uint64_t drop_nonfinite(Scene& scene);

/// How far `rounded` is from `exact` along an axis.
inline double distance_to_float(const dvec3& exact, const vec3& rounded) {
  const dvec3 moved = glm::abs(exact - dvec3(rounded));
  return std::max({moved.x, moved.y, moved.z});
}

/// Notes that rounding has moved means by up to `most`, if that can be seen: if it is more than a millionth of
/// the scene's size. Returns whether it is.
bool note_rounded_means(SceneFile& file, double most);

/// Sets `file.exact_means` and notes it, if it can be seen that the scene has them rounded.
void keep_exact_means(SceneFile& file, std::vector<dvec3> exact_means);

/// Adds a note of so many Gaussians that `drop_nonfinite` removed, unless they are none.
void note_dropped(std::uint64_t dropped, std::vector<std::string>& notes);

}  // namespace swiftgs::io
