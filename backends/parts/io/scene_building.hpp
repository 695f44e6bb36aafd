// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What every scene reader does with decoded numbers: widen and flip them, activate them, and
/// leave out what no scene should have.

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/project/sh.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs::io {

/// The value of an IEEE half, which every float can hold.
inline float half_to_float(std::uint16_t half) {
  const std::uint32_t sign = std::uint32_t(half & 0x8000) << 16, exponent = half >> 10 & 31;
  const std::uint32_t mantissa = half & 1023;
  if (exponent == 0) return (sign ? -0x1p-24f : 0x1p-24f) * float(mantissa);
  const std::uint32_t widened = exponent == 31 ? 255 : exponent + 127 - 15;
  return std::bit_cast<float>(sign | widened << 23 | mantissa << 13);
}

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

/// Takes scales below 0, which linear formats can hold, without their sign, and counts their
/// Gaussians.
void drop_signs_of_scales(SceneFile& file);

/// Removes the Gaussians with a fault and keeps the order of the others. `faults` has one entry for each
/// Gaussian.
LeftOut leave_out(Scene& scene, const std::vector<Fault>& faults);

/// The same of the faults that `fault_of` finds.
LeftOut leave_out_invalid(Scene& scene);

/// An origin as text: three numbers with commas between, as many digits as tell them apart.
std::string text_of(const dvec3& origin);

/// Adds a note for each reason for which Gaussians were left out.
SWIFTGS_API void note_left_out(const LeftOut& left_out, std::vector<std::string>& notes);

/// Adds a note if scales of some Gaussians are `done`, such as "taken", without their sign.
SWIFTGS_API void note_dropped_signs(std::uint64_t count, const char* done, std::vector<std::string>& notes);

}  // namespace swiftgs::io
