// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/rendering_model.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/frame/span.hpp>

namespace swiftgs {

/// Gaussians on the host, structure of arrays, activated: nothing is left to exponentiate or normalise.
/// World axes are those of the cameras; readers convert.
struct Scene {
  std::vector<vec3> means;            ///< @shape{N} world position less `origin`
  std::vector<vec3> scales;           ///< @shape{N} standard deviation along each local axis, >= 0
  std::vector<Quaternion> rotations;  ///< @shape{N} unit, local axes to world
  std::vector<float> opacities;       ///< @shape{N} in [0, 1]
  std::vector<vec3> sh0;              ///< @shape{N} SH coefficient of band 0, RGB
  std::vector<float> sh_rest;     ///< @shape{N, sh_rest_count(sh_degree), 3} bands 1 and up, RGB innermost
  int sh_degree = 0;              ///< 0 to 3: the bands that are stored
  RenderingModel model{};         ///< how it was trained to be drawn, which frames follow
  std::vector<float> features{};  ///< @shape{N, feature_channels} whatever else is drawn of a Gaussian
  int feature_channels = 0;
  /// Where the means' zero lies in the world: a Gaussian is at origin + mean. Other than 0 in scenes so far
  /// from the world's zero that float could not hold their positions. Frames know nothing of it: draw them
  /// with cameras moved by -origin, `transformed(camera, {.translation = -scene.origin})`.
  dvec3 origin{0.0};

  std::size_t size() const { return means.size(); }
};

/// A scene without Gaussians that is otherwise like `scene`.
inline Scene empty_like(const Scene& scene) {
  Scene out;
  out.sh_degree = scene.sh_degree, out.model = scene.model;
  out.feature_channels = scene.feature_channels, out.origin = scene.origin;
  return out;
}

/// A number for `SceneView::identity` that this process has not returned before.
SWIFTGS_API inline std::uint64_t new_scene_identity() {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

/// Throws `InvalidArgument` unless all arrays of `scene` have the lengths that its count and degree ask
/// for, its origin lies within the range of float, and frames can follow its model.
inline void validate(const Scene& scene) {
  validate(scene.model);
  if (scene.sh_degree < 0 || scene.sh_degree > max_sh_degree)
    detail::refuse("scene: sh_degree is ", scene.sh_degree, ", expected 0 to 3");
  if (scene.feature_channels < 0 || scene.feature_channels > max_feature_channels)
    detail::refuse("scene: feature_channels is ", scene.feature_channels, ", expected 0 to ",
                   max_feature_channels);
  for (int axis = 0; axis < 3; ++axis)
    if (!detail::is_finite(float(scene.origin[axis])))
      detail::refuse("scene: origin has ", scene.origin[axis],
                     ", expected finite numbers within the range of float");
  for_each_array(
      [&](const char* array, std::size_t each, const auto& values) {
        if (values.size() != scene.size() * each)
          detail::refuse("scene: ", array, " has ", values.size(), " elements, expected ",
                         scene.size() * each);
      },
      scene);
}

namespace detail {
/// Floats that are looked at before it is asked whether one was not finite.
inline constexpr std::size_t finite_block = 1 << 14;

/// Whether all of `count` floats are finite. The sum's sign bit is set where all bits of the exponent are,
/// which compilers work out for many floats at once.
inline bool are_finite(const float* values, std::size_t count) {
  std::uint32_t found = 0;
  for (std::size_t i = 0; i < count; ++i)
    found |= (__builtin_bit_cast(std::uint32_t, values[i]) & 0x7f800000u) + 0x00800000u;
  return (found & 0x80000000u) == 0;
}

/// Throws `InvalidArgument` at the first of `count` floats that is not finite. Gaussian `first` + i has
/// the `width` floats from `width` i on.
inline void require_finite(const char* array, const float* values, std::size_t count, std::size_t width,
                           std::size_t first) {
  for (std::size_t begin = 0; begin < count; begin += finite_block) {
    const std::size_t end = count - begin < finite_block ? count : begin + finite_block;
    if (are_finite(values + begin, end - begin)) continue;
    for (std::size_t i = begin; i < end; ++i)
      if (!is_finite(values[i]))
        refuse("scene: ", array, " of Gaussian ", first + i / width, " is ", values[i],
               ", expected finite numbers");
  }
}

/// Notes in `found` whether a block of floats has one that is not finite.
struct FindNotFinite {
  const float* values;
  std::size_t count;
  std::atomic<bool>* found;

  void operator()(std::size_t block) const {
    const std::size_t begin = block * finite_block;
    if (!are_finite(values + begin, std::min(finite_block, count - begin)))
      found->store(true, std::memory_order_relaxed);
  }
};

/// The numbers of an array.
template <class T>
Span<const float> floats_of(const std::vector<T>& values) {
  return {reinterpret_cast<const float*>(values.data()), values.size() * floats_of_value(values)};
}
}  // namespace detail

/// Throws `InvalidArgument` naming the first Gaussian with a number that is NaN or infinite. Reads
/// every array once; `scene` is valid. Its Gaussians are numbered from `first` on.
inline void validate_numbers(const Scene& scene, std::size_t first = 0) {
  for_each_array(
      [first](const char* array, std::size_t each, const auto& values) {
        const Span<const float> floats = detail::floats_of(values);
        detail::require_finite(array, floats.data, floats.size, each * detail::floats_of_value(values),
                               first);
      },
      scene);
}

/// The same by loops of `backend`, which reaches the host's memory.
template <class B>
void validate_numbers(const B& backend, const Scene& scene) {
  std::atomic<bool> found = false;
  for_each_array(
      [&](const char*, std::size_t, const auto& values) {
        const Span<const float> floats = detail::floats_of(values);
        const std::size_t blocks = (floats.size + detail::finite_block - 1) / detail::finite_block;
        backend.for_each(Count(blocks), detail::FindNotFinite{floats.data, floats.size, &found});
      },
      scene);
  if (found) validate_numbers(scene);
}

/// The highest band with a coefficient other than zero in Gaussians [begin, end): what is above it need not
/// be read to render them.
inline int used_sh_degree(const Scene& scene, std::size_t begin, std::size_t end) {
  const std::size_t stride = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  for (int degree = scene.sh_degree; degree > 0; --degree) {
    const std::size_t first = 3 * std::size_t(sh_rest_count(degree - 1));
    const std::size_t last = 3 * std::size_t(sh_rest_count(degree));
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = first; k < last; ++k)
        if (scene.sh_rest[i * stride + k] != 0) return degree;
  }
  return 0;
}
inline int used_sh_degree(const Scene& scene) { return used_sh_degree(scene, 0, scene.size()); }

/// A view of `scene`, which must outlive it. Throws `InvalidArgument` as `validate` does.
inline SceneView view(const Scene& scene) {
  validate(scene);
  SceneView out{
      .sh_degree = used_sh_degree(scene), .feature_channels = scene.feature_channels, .model = scene.model};
  for_each_array(
      [&](const char*, std::size_t each, const auto& values, auto& rows) {
        if (each != 0) rows = {values.data(), scene.size(), each * sizeof(*values.data())};
      },
      scene, out);
  return out;
}

}  // namespace swiftgs
