// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How Gaussians in arrays of the caller become a scene.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/project/sh.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

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

  /// Pointers into `arrays`, a `Scene` or the like, from Gaussian `first` on, with so many floats a Gaussian.
  template <class Arrays>
  static SceneCapacity of(Arrays& arrays, std::size_t first, int sh_stride, int feature_channels) {
    return {arrays.means.data() + first,
            arrays.scales.data() + first,
            arrays.rotations.data() + first,
            arrays.opacities.data() + first,
            arrays.sh0.data() + first,
            arrays.sh_rest.data() + first * std::size_t(sh_stride),
            sh_stride,
            arrays.features.data() + first * std::size_t(feature_channels)};
  }
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

/// Copies one float of `width` a Gaussian at a time, for backends that load neighbours together.
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

/// Notes in `found` whether a number that `copy_arrays` would write of Gaussian i is not finite.
struct FindNotFiniteValue {
  ArrayCopies copies;
  std::atomic<bool>* found;

  void operator()(std::size_t i) const {
    const auto finite = [&](const auto& copy) {
      if (!copy.from.data) return true;
      if constexpr (requires { copy.row(i); }) {
        return are_finite(copy.row(i), copy.width);
      } else {
        const auto value = copy.value(i);
        return are_finite(reinterpret_cast<const float*>(&value), sizeof value / sizeof(float));
      }
    };
    if (!finite(copies.means) || !finite(copies.scales) || !finite(copies.sh0) || !finite(copies.rotations) ||
        !finite(copies.opacities) || !finite(copies.sh_rest) || !finite(copies.features))
      found->store(true, std::memory_order_relaxed);
  }
};

}  // namespace detail

/// Copies arrays that were validated by loops of `backend`, which reach both sides, and activates numbers.
/// Arrays that are null are left out.
template <class B>
void copy_arrays(const B& backend, const SceneArrays& from, const SceneCapacity& to) {
  const detail::ArrayCopies copies(from, to);
  const auto run = [&](std::size_t each, const auto& loop) {
    if (loop.from.data && each != 0) backend.for_each(Count{from.count * each}, loop);
  };
  run(1, copies.means), run(1, copies.scales), run(1, copies.rotations), run(1, copies.opacities);
  run(1, copies.sh0);
  const auto stored = std::uint32_t(sh_rest_count(from.sh_degree)), kept = std::uint32_t(to.sh_stride) / 3;
  const auto channels = std::uint32_t(from.feature_channels);
  if constexpr (B::reaches_host_memory) {
    run(kept != 0, copies.sh_rest), run(channels != 0, copies.features);
  } else {
    run(kept, detail::CopyVectors{from.sh_rest, reinterpret_cast<vec3*>(to.sh_rest), stored, kept});
    run(channels, detail::CopyFloats{from.features, to.features, channels});
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
  scene.model = arrays.model;
  for_each_array([&](const char*, std::size_t each, auto& values) { values.resize(each * arrays.count); },
                 scene);
  copy_arrays(backend, arrays,
              SceneCapacity::of(scene, 0, 3 * sh_rest_count(arrays.sh_degree), arrays.feature_channels));
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
