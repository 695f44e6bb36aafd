// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include <swiftgs/conventions.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/span.hpp>

namespace swiftgs {

/// Most features a Gaussian may have.
inline constexpr int max_feature_channels = 1 << 24;

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

/// Gaussians that a view may skip together; `project/chunks.hpp` says how.
inline constexpr std::size_t chunk_size = 128;

/// What holds for all Gaussians of a chunk: numbers i * chunk_size to (i + 1) * chunk_size - 1 of a scene.
struct alignas(16) ChunkBounds {
  vec3 low{std::numeric_limits<float>::infinity()};  ///< box of the means
  float size = 0;                                    ///< largest standard deviation along any direction
  vec3 high{-std::numeric_limits<float>::infinity()};
  float opacity = 0;  ///< largest
};
static_assert(sizeof(ChunkBounds) == 32);

/// Consecutive chunks of a scene or of a frame.
struct ChunkRange {
  std::size_t begin = 0, end = 0;
  std::size_t size() const { return end - begin; }
};

/// Constant arrays of one scene wherever a backend keeps them; what a frame is rendered from. A Gaussian with
/// a number that is NaN or infinite is not drawn. A rotation of zeros turns nothing, as the identity does.
/// `sh_degree` may be lower than what is stored: bands above it are never loaded.
struct SceneView {
  StridedSpan<const vec3> means{};
  StridedSpan<const vec3> scales{};
  StridedSpan<const Quaternion> rotations{};
  StridedSpan<const float> opacities{};
  StridedSpan<const vec3> sh0{};
  HarmonicRows sh_rest{};
  /// Must match the arrays whenever a frame is drawn. Empty: no chunk is skipped.
  /// @shape{ceil(N / chunk_size)}
  Span<const ChunkBounds> chunks{};
  int sh_degree = 0;  ///< bands to evaluate
  /// Points to the first feature of each Gaussian; the rest follow. One that is not finite counts as 0.
  StridedSpan<const float> features{};
  int feature_channels = 0;
  bool any_rotations = false;  ///< quaternions of any length, drawn as `normalised` makes them
  bool plain_colours = false;  ///< `sh0` holds colours, drawn as `sh0_of` makes coefficients of them
  RenderingModel model{};      ///< what frames follow where their conventions leave it to the scene

  /// Renderers reuse what they learnt from frames of the same identity: which sort and which tiles are
  /// quicker, nothing that changes a bit. Every upload has its own, shared by its copies, and an update keeps
  /// it. 0 for your own arrays: nothing is learnt, unless you set a `new_scene_identity()` for each scene
  /// that they hold.
  std::uint64_t identity = 0;

  SWIFTGS_HD std::size_t size() const { return means.size; }
};

namespace detail {
/// Floats of one value of an array.
template <class Array>
constexpr std::size_t floats_of_value(const Array& array) {
  if constexpr (requires { array.data(); })
    return sizeof(*array.data()) / sizeof(float);
  else if constexpr (std::is_same_v<Array, HarmonicRows>)
    return std::size_t(1);
  else
    return sizeof(*array.data) / sizeof(float);
}
}  // namespace detail

/// Calls f(name, each, first.means, more.means...) and so on for each array of Gaussians, which has `each`
/// values a Gaussian in `first`. All are any of `Scene`, `SceneView`, `SceneArrays` and the like.
template <class F, class First, class... More>
void for_each_array(const F& f, First&& first, More&&... more) {
  const auto call = [&](const char* name, std::size_t floats, auto& array, auto&... arrays) {
    f(name, floats / detail::floats_of_value(array), array, arrays...);
  };
  call("means", 3, first.means, more.means...);
  call("scales", 3, first.scales, more.scales...);
  call("rotations", 4, first.rotations, more.rotations...);
  call("opacities", 1, first.opacities, more.opacities...);
  call("sh0", 3, first.sh0, more.sh0...);
  call("sh_rest", 3 * std::size_t(sh_rest_count(first.sh_degree)), first.sh_rest, more.sh_rest...);
  call("features", std::size_t(first.feature_channels), first.features, more.features...);
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
