// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <swiftgs/activation.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/math.hpp>
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

/// Removes the Gaussians with a value that cannot be rendered, keeping the order. Returns how many.
std::uint64_t drop_nonfinite(Scene& scene);

/// An origin as text: three numbers with commas between, as many digits as tell them apart.
std::string text_of(const dvec3& origin);

/// Adds a note of so many Gaussians that `drop_nonfinite` removed, unless they are none.
void note_dropped(std::uint64_t dropped, std::vector<std::string>& notes);

}  // namespace swiftgs::io
