// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Gaussians in arrays of the caller, and how they become a scene.

#include <algorithm>
#include <atomic>
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
  FloatArray features{};  ///< @shape{N, feature_channels} whatever else is drawn of a Gaussian
  int feature_channels = 0;

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
  if (arrays.feature_channels < 0)
    throw std::invalid_argument("scene: feature_channels is " + std::to_string(arrays.feature_channels) +
                                ", expected 0 or more");
  const auto check = [&](const char* name, std::size_t floats, const FloatArray& array) {
    if (arrays.count == 0 || floats == 0) return;
    const std::string what = std::string("scene: ") + name;
    if (!array.data) throw std::invalid_argument(what + " is null, expected a pointer");
    if (reinterpret_cast<std::uintptr_t>(array.data) % alignof(float) != 0)
      throw std::invalid_argument(what + ": expected an address that is a multiple of 4");
    const auto row = std::ptrdiff_t(floats * sizeof(float));
    const auto most = std::numeric_limits<std::ptrdiff_t>::max() / std::ptrdiff_t(arrays.count);
    if (row > most)
      throw std::invalid_argument(what + ": " + std::to_string(floats) + " floats a Gaussian of " +
                                  std::to_string(arrays.count) + ", expected what fits into memory");
    if (array.stride != 0 &&
        (array.stride < row || array.stride > most || array.stride % std::ptrdiff_t(sizeof(float)) != 0))
      throw std::invalid_argument(what + ": stride is " + std::to_string(array.stride) +
                                  " bytes, expected 0 or a multiple of 4 from " + std::to_string(row) +
                                  " to " + std::to_string(most));
  };
  for_each_array(check, arrays);
}

/// Dense arrays that Gaussians are copied to.
struct SceneCapacity {
  vec3* means = nullptr;
  vec3* scales = nullptr;
  Quaternion* rotations = nullptr;
  float* opacities = nullptr;
  vec3* sh0 = nullptr;
  float* sh_rest = nullptr;
  int sh_stride = 0;  ///< floats a Gaussian in `sh_rest`: a multiple of 3, and 0 behind what is copied
  float* features = nullptr;
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

  SWIFTGS_HD vec3 value(std::size_t at) const {
    // Division in 64 bits would cost a device more than the copy.
    const std::size_t i = kept == 1 ? at : at >> 32 == 0 ? std::uint32_t(at) / kept : at / kept;
    const auto vector = std::uint32_t(at - i * kept);
    if (vector >= stored) return vec3(0);
    const float* const row = row_of(from, i, 3 * stored) + 3 * vector;
    const vec3 found(row[0], row[1], row[2]);
    if (turn == Turn::from_log) return {std::exp(found.x), std::exp(found.y), std::exp(found.z)};
    return turn == Turn::from_colour ? sh0_of(found) : found;
  }
  SWIFTGS_HD void operator()(std::size_t at) const { to[at] = value(at); }
};

/// Copies rows of `width` floats, one a Gaussian.
struct CopyRows {
  FloatArray from;
  float* to = nullptr;
  std::size_t width = 0;

  const float* row(std::size_t i) const { return row_of(from, i, width); }
  void operator()(std::size_t i) const { std::copy_n(row(i), width, to + i * width); }
};

/// The same, one float of `width` a Gaussian at a time, for backends that load neighbours together.
struct CopyFloats {
  FloatArray from;
  float* to = nullptr;
  std::uint32_t width = 1;

  SWIFTGS_HD void operator()(std::size_t at) const {
    const std::size_t i = at >> 32 == 0 ? std::uint32_t(at) / width : at / width;
    to[at] = row_of(from, i, width)[at - i * width];
  }
};

struct CopyRotations {
  FloatArray from;
  Quaternion* to = nullptr;
  bool any_length = false;

  SWIFTGS_HD Quaternion value(std::size_t i) const {
    const float* const q = row_of(from, i, 4);
    return any_length ? normalised(q[0], q[1], q[2], q[3]) : Quaternion{q[0], q[1], q[2], q[3]};
  }
  SWIFTGS_HD void operator()(std::size_t i) const { to[i] = value(i); }
};

struct CopyOpacities {
  FloatArray from;
  float* to = nullptr;
  bool from_logit = false;

  SWIFTGS_HD float value(std::size_t i) const {
    const float found = *row_of(from, i, 1);
    return from_logit ? sigmoid(found) : found;
  }
  SWIFTGS_HD void operator()(std::size_t i) const { to[i] = value(i); }
};

/// The loops that copy each array.
struct ArrayCopies {
  CopyVectors means, scales, sh0;
  CopyRotations rotations;
  CopyOpacities opacities;
  CopyRows sh_rest, features;

  ArrayCopies(const SceneArrays& from, const SceneCapacity& to) {
    using Turn = CopyVectors::Turn;
    means = {from.means, to.means};
    scales = {from.scales, to.scales, 1, 1, from.log_scales ? Turn::from_log : Turn::none};
    sh0 = {from.sh0, to.sh0, 1, 1, from.plain_colours ? Turn::from_colour : Turn::none};
    rotations = {from.rotations, to.rotations, from.any_rotations};
    opacities = {from.opacities, to.opacities, from.logit_opacities};
    sh_rest = {from.sh_rest, to.sh_rest, 3 * std::size_t(sh_rest_count(from.sh_degree))};
    features = {from.features, to.features, std::size_t(from.feature_channels)};
  }
};

/// What `copy_arrays` would write of Gaussian i: notes in `found` whether it has a number that is not finite.
struct FindNotFiniteValue {
  ArrayCopies copies;
  std::atomic<bool>* found;

  void operator()(std::size_t i) const {
    const auto finite = [](const auto& value) {
      return are_finite(reinterpret_cast<const float*>(&value), sizeof value / sizeof(float));
    };
    if (!finite(copies.means.value(i)) || !finite(copies.scales.value(i)) || !finite(copies.sh0.value(i)) ||
        !finite(copies.rotations.value(i)) || !finite(copies.opacities.value(i)) ||
        !are_finite(copies.sh_rest.row(i), copies.sh_rest.width) ||
        !are_finite(copies.features.row(i), copies.features.width))
      found->store(true, std::memory_order_relaxed);
  }
};

}  // namespace detail

/// Copies arrays that were validated by loops of `backend`, which reach both sides, and activates numbers.
template <class B>
void copy_arrays(const B& backend, const SceneArrays& from, const SceneCapacity& to) {
  const detail::ArrayCopies copies(from, to);
  const Count n{from.count};
  backend.for_each(n, copies.means), backend.for_each(n, copies.scales);
  backend.for_each(n, copies.rotations), backend.for_each(n, copies.opacities);
  backend.for_each(n, copies.sh0);
  const auto stored = std::uint32_t(sh_rest_count(from.sh_degree)), kept = std::uint32_t(to.sh_stride) / 3;
  const auto channels = std::uint32_t(from.feature_channels);
  if constexpr (B::reaches_host_memory) {
    if (kept != 0) backend.for_each(n, copies.sh_rest);
    if (channels != 0) backend.for_each(n, copies.features);
  } else {
    if (kept != 0)
      backend.for_each(Count{from.count * kept},
                       detail::CopyVectors{from.sh_rest, reinterpret_cast<vec3*>(to.sh_rest), stored, kept});
    if (channels != 0)
      backend.for_each(Count{from.count * channels},
                       detail::CopyFloats{from.features, to.features, channels});
  }
}

/// Whether a copy of arrays on the host that were validated would have finite numbers alone.
template <class B>
bool would_be_finite(const B& backend, const SceneArrays& arrays) {
  std::atomic<bool> found = false;
  backend.for_each(Count{arrays.count}, detail::FindNotFiniteValue{{arrays, {}}, &found});
  return !found;
}

/// Makes `scene` a copy of arrays on the host that were validated; takes its memory again.
template <class B>
void copy_scene(const B& backend, const SceneArrays& arrays, Scene& scene) {
  scene.sh_degree = arrays.sh_degree, scene.feature_channels = arrays.feature_channels;
  for_each_array([&](const char*, std::size_t each, auto& values) { values.resize(each * arrays.count); },
                 scene);
  copy_arrays(
      backend, arrays,
      {scene.means.data(), scene.scales.data(), scene.rotations.data(), scene.opacities.data(),
       scene.sh0.data(), scene.sh_rest.data(), 3 * sh_rest_count(arrays.sh_degree), scene.features.data()});
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
