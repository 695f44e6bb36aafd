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

#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/project/sh.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// One array of floats. The floats of one Gaussian lie side by side.
struct FloatArray {
  const float* data = nullptr;
  std::ptrdiff_t stride = 0;  ///< from a Gaussian to the next, at least what one takes; 0: that @units{bytes}
};

/// Gaussians in arrays of the caller, in memory that a backend's loops reach. An upload needs all that have
/// floats; an update leaves those that are null as they are.
struct SceneArrays {
  std::size_t count = 0;   ///< N, less than 2^32
  FloatArray means{};      ///< @shape{N, 3} world position
  FloatArray scales{};     ///< @shape{N, 3} standard deviation along each local axis, 0 or more
  FloatArray rotations{};  ///< @shape{N, 4} unit quaternions w, x, y, z, local axes to world
  FloatArray opacities{};  ///< @shape{N} 0 to 1
  FloatArray sh0{};        ///< @shape{N, 3} SH coefficient of band 0, RGB
  FloatArray sh_rest{};    ///< @shape{N, (sh_degree + 1)^2 - 1, 3} bands 1 and up, RGB innermost
  int sh_degree = 0;       ///< 0 to 3
  FloatArray features{};   ///< @shape{N, feature_channels} whatever else is drawn of a Gaussian
  int feature_channels = 0;

  bool log_scales = false;       ///< `scales` are natural logarithms
  bool logit_opacities = false;  ///< `opacities` are before the sigmoid
  bool any_rotations = false;    ///< quaternions of any length, which are normalised; zeros are the identity
  bool plain_colours = false;    ///< `sh0` holds colours in place of coefficients
  RenderingModel model{};        ///< how they were trained to be drawn; updates do not look at it
};

namespace detail {
inline void validate_shape(const SceneArrays& arrays) {
  if (arrays.count > std::numeric_limits<std::uint32_t>::max())
    refuse("scene: ", arrays.count, " Gaussians, expected fewer than 2^32");
  validate(arrays.model);
  if (arrays.sh_degree < 0 || arrays.sh_degree > max_sh_degree)
    refuse("scene: sh_degree is ", arrays.sh_degree, ", expected 0 to 3");
  if (arrays.feature_channels < 0)
    refuse("scene: feature_channels is ", arrays.feature_channels, ", expected 0 or more");
}

/// Throws `InvalidArgument` unless `array` may hold `floats` floats for each of `count` Gaussians.
inline void validate_array(const char* name, std::size_t floats, const FloatArray& array, std::size_t count) {
  if (reinterpret_cast<std::uintptr_t>(array.data) % alignof(float) != 0)
    refuse("scene: ", name, ": expected an address that is a multiple of 4");
  const auto row = std::ptrdiff_t(floats * sizeof(float));
  const auto most = std::numeric_limits<std::ptrdiff_t>::max() / std::ptrdiff_t(count);
  if (row > most)
    refuse("scene: ", name, ": ", floats, " floats a Gaussian of ", count,
           ", expected what fits into memory");
  if (array.stride != 0 &&
      (array.stride < row || array.stride > most || array.stride % std::ptrdiff_t(sizeof(float)) != 0))
    refuse("scene: ", name, ": stride is ", array.stride, " bytes, expected 0 or a multiple of 4 from ", row,
           " to ", most);
}
}  // namespace detail

/// Throws `InvalidArgument` for arrays that are missing, or whose count, degree or strides are not as
/// `SceneArrays` says.
inline void validate(const SceneArrays& arrays) {
  detail::validate_shape(arrays);
  const auto check = [&](const char* name, std::size_t floats, const FloatArray& array) {
    if (arrays.count == 0 || floats == 0) return;
    if (!array.data) detail::refuse("scene: ", name, " is null, expected a pointer");
    detail::validate_array(name, floats, array, arrays.count);
  };
  for_each_array(check, arrays);
}

/// A view of `arrays` where they lie, for frames that read them there. Throws `InvalidArgument` as
/// `validate`, and for what frames do not read: logarithms, logits, strides of 4 GiB and more.
inline SceneView view(const SceneArrays& arrays) {
  validate(arrays);
  if (arrays.log_scales || arrays.logit_opacities)
    throw InvalidArgument(
        "scene: log_scales or logit_opacities is set, expected neither of arrays that are drawn where they "
        "lie");
  SceneView out{.sh_degree = arrays.sh_degree,
                .feature_channels = arrays.feature_channels,
                .any_rotations = arrays.any_rotations,
                .plain_colours = arrays.plain_colours,
                .model = arrays.model};
  const auto look = [&](const char* name, std::size_t floats, const FloatArray& array, auto& rows) {
    const std::size_t stride = array.stride != 0 ? std::size_t(array.stride) : floats * sizeof(float);
    if (stride > std::numeric_limits<std::uint32_t>::max())
      detail::refuse("scene: ", name, ": stride is ", stride, " bytes, expected less than 2^32");
    const void* const first = array.data;
    if (arrays.count != 0 && floats != 0)
      rows = {static_cast<decltype(rows.data)>(first), arrays.count, stride};
  };
  for_each_array(look, arrays, out);
  return out;
}

/// Throws `InvalidArgument` unless `arrays` may replace Gaussians of `scene`, a `Scene` or `SceneView`,
/// from number `first` on. Arrays that are null stay: their degree or channels need not be the scene's.
template <class SceneLike>
void validate_update(const SceneLike& scene, std::size_t first, const SceneArrays& arrays) {
  detail::validate_shape(arrays);
  if (first > scene.size() || arrays.count > scene.size() - first)
    detail::refuse("update: ", arrays.count, " Gaussians from number ", first,
                   " on, expected some of the scene's ", scene.size());
  const auto require_same = [](const char* name, const FloatArray& array, int found, int expected) {
    if (array.data && found != expected)
      detail::refuse("update: ", name, " is ", found, ", expected ", expected, " as in the scene");
  };
  require_same("sh_degree", arrays.sh_rest, arrays.sh_degree, scene.sh_degree);
  require_same("feature_channels", arrays.features, arrays.feature_channels, scene.feature_channels);
  const auto check = [&](const char* name, std::size_t floats, const FloatArray& array) {
    if (arrays.count != 0 && array.data) detail::validate_array(name, floats, array, arrays.count);
  };
  for_each_array(check, arrays);
}

/// Error of an update of a scene that frames read from the caller's arrays.
inline constexpr const char* update_of_borrowed =
    "update: the scene's arrays are the caller's, expected a scene that was uploaded: write to the arrays";

/// Throws `InvalidArgument` where `arrays` would replace harmonics that are not kept as floats: views
/// hold the address and format of their rows.
inline void require_replaceable(const HarmonicRows& rows, const SceneArrays& arrays) {
  if (arrays.sh_rest.data && rows.is_packed())
    detail::refuse("update: the scene keeps sh_rest as ", name_of(rows),
                   ", expected floats: upload it with HarmonicsKept::floats; renderers of C and Python take "
                   "SWIFTGS_HARMONICS_FLOAT and harmonics=\"float\"");
}

/// The chunks whose bounds may change when `arrays` replace Gaussians from number `first` on.
inline ChunkRange chunks_to_bound(std::size_t first, const SceneArrays& arrays) {
  const bool bounds =
      arrays.means.data || arrays.scales.data || arrays.rotations.data || arrays.opacities.data;
  if (arrays.count == 0 || !bounds) return {};
  return {first / chunk_size, (first + arrays.count - 1) / chunk_size + 1};
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
