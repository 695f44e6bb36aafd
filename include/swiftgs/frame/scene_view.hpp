// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/rendering_model.hpp>
#include <swiftgs/frame/span.hpp>

namespace swiftgs {

/// Most features a Gaussian may have.
inline constexpr int max_feature_channels = 1 << 24;

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

/// Constant arrays of one scene, in memory that the backend reads; a frame is rendered from them. A Gaussian
/// with a number that is NaN or infinite is not drawn. A rotation of zeros turns nothing, as the identity
/// does. Bands above `sh_degree` are never loaded, also where they are stored.
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

  /// A renderer learns the quicker sort and the quicker tiles for each identity. Images do
  /// not depend on it. Every upload has an identity of its own; copies share it and updates keep it. With 0,
  /// as of your own arrays, a renderer learns nothing: set a `new_scene_identity()` for each scene in them.
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

}  // namespace swiftgs
