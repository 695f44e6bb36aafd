// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Gaussians in arrays of the caller, and how they become a scene.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include <swiftgs/activation.hpp>
#include <swiftgs/count.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// One array of floats. The floats of one Gaussian lie side by side.
struct FloatArray {
  const float* data = nullptr;
  std::ptrdiff_t stride = 0;  ///< from a Gaussian to the next, at least what one takes; 0: that @units{bytes}
};

/// Gaussians in arrays of the caller, in memory that a backend's loops reach.
struct SceneArrays {
  std::size_t count = 0;  ///< N, less than 2^32
  FloatArray means;       ///< @shape{N, 3} world position
  FloatArray scales;      ///< @shape{N, 3} standard deviation along each local axis, 0 or more
  FloatArray rotations;   ///< @shape{N, 4} unit quaternions w, x, y, z, local axes to world
  FloatArray opacities;   ///< @shape{N} 0 to 1
  FloatArray sh0;         ///< @shape{N, 3} SH coefficient of band 0, RGB
  FloatArray sh_rest;     ///< @shape{N, (sh_degree + 1)^2 - 1, 3} bands 1 and up, RGB innermost
  int sh_degree = 0;      ///< 0 to 3

  bool log_scales = false;       ///< `scales` are natural logarithms
  bool logit_opacities = false;  ///< `opacities` are before the sigmoid
  bool any_rotations = false;    ///< quaternions of any length, which are normalised; zeros are the identity
  bool plain_colours = false;    ///< `sh0` holds colours in place of coefficients
};

/// Throws `std::invalid_argument` for arrays that are missing, or whose count, degree or strides are not as
/// `SceneArrays` says.
inline void validate(const SceneArrays& arrays) {
  if (arrays.count > std::numeric_limits<std::uint32_t>::max())
    throw std::invalid_argument("scene: " + std::to_string(arrays.count) +
                                " Gaussians, expected fewer than 2^32");
  if (arrays.sh_degree < 0 || arrays.sh_degree > max_sh_degree)
    throw std::invalid_argument("scene: sh_degree is " + std::to_string(arrays.sh_degree) +
                                ", expected 0 to 3");
  const auto check = [&](const char* name, const FloatArray& array, std::size_t floats) {
    if (arrays.count == 0 || floats == 0) return;
    const std::string what = std::string("scene: ") + name;
    if (!array.data) throw std::invalid_argument(what + " is null, expected a pointer");
    if (reinterpret_cast<std::uintptr_t>(array.data) % alignof(float) != 0)
      throw std::invalid_argument(what + ": expected an address that is a multiple of 4");
    const auto row = std::ptrdiff_t(floats * sizeof(float));
    const auto most = std::numeric_limits<std::ptrdiff_t>::max() / std::ptrdiff_t(arrays.count);
    if (array.stride != 0 &&
        (array.stride < row || array.stride > most || array.stride % std::ptrdiff_t(sizeof(float)) != 0))
      throw std::invalid_argument(what + ": stride is " + std::to_string(array.stride) +
                                  " bytes, expected 0 or a multiple of 4 from " + std::to_string(row) +
                                  " to " + std::to_string(most));
  };
  check("means", arrays.means, 3);
  check("scales", arrays.scales, 3);
  check("rotations", arrays.rotations, 4);
  check("opacities", arrays.opacities, 1);
  check("sh0", arrays.sh0, 3);
  check("sh_rest", arrays.sh_rest, 3 * std::size_t(sh_rest_count(arrays.sh_degree)));
}

/// Dense arrays that Gaussians are copied to.
struct SceneRoom {
  vec3* means = nullptr;
  vec3* scales = nullptr;
  Quaternion* rotations = nullptr;
  float* opacities = nullptr;
  vec3* sh0 = nullptr;
  float* sh_rest = nullptr;
  int sh_stride = 0;  ///< floats a Gaussian in `sh_rest`: a multiple of 3, and 0 behind what is copied
};

namespace detail {

/// `width` floats of Gaussian `i`.
SWIFTGS_HD inline const float* row_of(const FloatArray& array, std::size_t i, std::size_t width) {
  const std::size_t stride = array.stride != 0 ? std::size_t(array.stride) : width * sizeof(float);
  return reinterpret_cast<const float*>(reinterpret_cast<const unsigned char*>(array.data) + i * stride);
}

/// Copies vectors, `kept` of each Gaussian, `stored` of which are in the array; the others become 0.
struct CopyVectors {
  enum class Turn { none, from_log, from_colour };
  FloatArray from;
  vec3* to = nullptr;
  std::uint32_t stored = 1, kept = 1;
  Turn turn = Turn::none;

  SWIFTGS_HD void operator()(std::size_t at) const {
    // Division in 64 bits would cost a device more than the copy.
    const std::size_t i = kept == 1 ? at : at >> 32 == 0 ? std::uint32_t(at) / kept : at / kept;
    const auto vector = std::uint32_t(at - i * kept);
    vec3 value(0);
    if (vector < stored) {
      const float* const row = row_of(from, i, 3 * stored) + 3 * vector;
      value = {row[0], row[1], row[2]};
      if (turn == Turn::from_log) value = {std::exp(value.x), std::exp(value.y), std::exp(value.z)};
      if (turn == Turn::from_colour) value = sh0_of(value);
    }
    to[at] = value;
  }
};

/// Copies rows of `stored` floats, one a Gaussian, to rows of `kept`; what is left of those becomes 0.
struct CopyRows {
  FloatArray from;
  float* to = nullptr;
  std::size_t stored = 0, kept = 0;

  void operator()(std::size_t i) const {
    float* const row = to + i * kept;
    std::copy_n(row_of(from, i, stored), stored, row);
    std::fill(row + stored, row + kept, 0.0f);
  }
};

struct CopyRotations {
  FloatArray from;
  Quaternion* to = nullptr;
  bool any_length = false;

  SWIFTGS_HD void operator()(std::size_t i) const {
    const float* const q = row_of(from, i, 4);
    to[i] = any_length ? normalised(q[0], q[1], q[2], q[3]) : Quaternion{q[0], q[1], q[2], q[3]};
  }
};

struct CopyOpacities {
  FloatArray from;
  float* to = nullptr;
  bool from_logit = false;

  SWIFTGS_HD void operator()(std::size_t i) const {
    const float value = *row_of(from, i, 1);
    to[i] = from_logit ? sigmoid(value) : value;
  }
};

}  // namespace detail

/// Copies arrays that were validated by loops of `backend`, which reach both sides, and activates numbers.
template <class B>
void copy_arrays(const B& backend, const SceneArrays& from, const SceneRoom& to) {
  using detail::CopyVectors;
  using Turn = CopyVectors::Turn;
  const Count n{from.count};
  backend.for_each(n, CopyVectors{from.means, to.means});
  backend.for_each(n,
                   CopyVectors{from.scales, to.scales, 1, 1, from.log_scales ? Turn::from_log : Turn::none});
  backend.for_each(n, detail::CopyRotations{from.rotations, to.rotations, from.any_rotations});
  backend.for_each(n, detail::CopyOpacities{from.opacities, to.opacities, from.logit_opacities});
  backend.for_each(n,
                   CopyVectors{from.sh0, to.sh0, 1, 1, from.plain_colours ? Turn::from_colour : Turn::none});
  const auto stored = std::uint32_t(sh_rest_count(from.sh_degree)), kept = std::uint32_t(to.sh_stride) / 3;
  if (kept == 0) return;
  if constexpr (B::reaches_host_memory)
    backend.for_each(n, detail::CopyRows{from.sh_rest, to.sh_rest, 3 * stored, 3 * kept});
  else
    backend.for_each(Count{from.count * kept},
                     CopyVectors{from.sh_rest, reinterpret_cast<vec3*>(to.sh_rest), stored, kept});
}

/// Makes `scene` a copy of arrays on the host that were validated; takes its memory again.
template <class B>
void copy_scene(const B& backend, const SceneArrays& arrays, Scene& scene) {
  const int stride = 3 * sh_rest_count(arrays.sh_degree);
  scene.sh_degree = arrays.sh_degree;
  scene.means.resize(arrays.count), scene.scales.resize(arrays.count);
  scene.rotations.resize(arrays.count), scene.opacities.resize(arrays.count);
  scene.sh0.resize(arrays.count), scene.sh_rest.resize(arrays.count * std::size_t(stride));
  copy_arrays(backend, arrays,
              {scene.means.data(), scene.scales.data(), scene.rotations.data(), scene.opacities.data(),
               scene.sh0.data(), scene.sh_rest.data(), stride});
}

/// A scene of its own of arrays on the host. Throws as `validate`.
template <class B>
Scene to_scene(const B& backend, const SceneArrays& arrays) {
  validate(arrays);
  Scene scene;
  copy_scene(backend, arrays, scene);
  return scene;
}

}  // namespace swiftgs
