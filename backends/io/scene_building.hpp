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
/// What every scene reader does with decoded numbers: activate them, and leave out what no scene should have.

namespace swiftgs::io {

inline constexpr double sh_c0 = sh::c0;  ///< the basis function of band 0

/// Gives `scene` the arrays of `count` Gaussians.
void allocate(Scene& scene, std::size_t count, int sh_degree);

/// What a reader stores of a quaternion that is no rotation, so that `fault_of` finds its Gaussian.
inline constexpr Quaternion not_a_rotation{0, 0, 0, 0};

/// The rotation of a quaternion that a file holds. Zeros become `not_a_rotation`.
inline Quaternion rotation_of(float w, float x, float y, float z) {
  const Quaternion q{w, x, y, z};
  return q == not_a_rotation ? not_a_rotation : normalised(q);
}

/// Why readers and writers leave a Gaussian out; `LeftOut` explains it.
enum class Fault : std::uint8_t { none, not_finite, no_rotation };

/// The first fault of Gaussian `i`.
Fault fault_of(const Scene& scene, std::size_t i);

/// Takes scales below 0, which linear formats can hold, without their sign, and notes of how many Gaussians.
void drop_signs_of_scales(SceneFile& file);

/// Removes the Gaussians with a fault and keeps the order of the others. `faults` has one entry for each
/// Gaussian.
LeftOut leave_out(Scene& scene, const std::vector<Fault>& faults);

/// The same of the faults that `fault_of` finds.
LeftOut leave_out_invalid(Scene& scene);

/// An origin as text: three numbers with commas between, as many digits as tell them apart.
std::string text_of(const dvec3& origin);

/// Adds a note for each reason for which Gaussians were left out.
void note_left_out(const LeftOut& left_out, std::vector<std::string>& notes);

}  // namespace swiftgs::io
