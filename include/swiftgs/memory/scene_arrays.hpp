// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Gaussians in arrays of the caller.

#include <cstddef>
#include <cstdint>
#include <limits>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/frame/rendering_model.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/frame/span.hpp>

namespace swiftgs {

/// One array of floats. The floats of one Gaussian lie side by side.
struct FloatArray {
  const float* data = nullptr;
  std::ptrdiff_t stride = 0;  ///< from a Gaussian to the next, at least what one takes; 0: that @units{bytes}
};

/// Gaussians in arrays of the caller, in memory that a backend's loops reach. An upload needs all arrays of
/// floats; an update keeps the scene's values where an array is null.
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

}  // namespace swiftgs
