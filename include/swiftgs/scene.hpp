// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include <swiftgs/math.hpp>
#include <swiftgs/span.hpp>

namespace swiftgs {

/// Highest degree of spherical harmonics that is rendered.
inline constexpr int max_sh_degree = 3;

/// SH coefficients a channel above band 0: 0, 3, 8, 15 for degree 0 to 3.
SWIFTGS_HD constexpr int sh_rest_count(int degree) { return (degree + 1) * (degree + 1) - 1; }

/// Gaussians on the host, structure of arrays, activated: nothing is left to exponentiate or normalise.
/// World axes are those of the cameras; a reader converts what it reads.
struct Scene {
  std::vector<vec3> means;            ///< @shape{N} world position
  std::vector<vec3> scales;           ///< @shape{N} standard deviation along each local axis, >= 0
  std::vector<Quaternion> rotations;  ///< @shape{N} unit, local axes to world
  std::vector<float> opacities;       ///< @shape{N} in [0, 1]
  std::vector<vec3> sh0;              ///< @shape{N} SH coefficient of band 0, RGB
  std::vector<float> sh_rest;  ///< @shape{N, sh_rest_count(sh_degree), 3} bands 1 and up, RGB innermost
  int sh_degree = 0;           ///< 0 to 3: the bands that are stored
  bool antialiased = false;    ///< trained with Mip-Splatting's opacity compensation

  std::size_t size() const { return means.size(); }
};

/// Constant arrays of one scene wherever a backend keeps them; what a frame is rendered from.
/// `sh_degree` may be lower than what is stored: bands above it are never loaded.
struct SceneView {
  Span<const vec3> means;
  Span<const vec3> scales;
  Span<const Quaternion> rotations;
  Span<const float> opacities;
  Span<const vec3> sh0;
  Span<const float> sh_rest;
  int sh_degree = 0;  ///< bands to evaluate
  int sh_stride = 0;  ///< floats a Gaussian in `sh_rest`

  SWIFTGS_HD std::size_t size() const { return means.size; }
};

/// Throws `std::invalid_argument` unless all arrays of `scene` have the lengths that its count and degree ask
/// for.
inline void validate(const Scene& scene) {
  const auto expect = [&](const char* array, std::size_t length, std::size_t expected) {
    if (length != expected)
      throw std::invalid_argument(std::string("scene: ") + array + " has " + std::to_string(length) +
                                  " elements, expected " + std::to_string(expected));
  };
  if (scene.sh_degree < 0 || scene.sh_degree > max_sh_degree)
    throw std::invalid_argument("scene: sh_degree is " + std::to_string(scene.sh_degree) +
                                ", expected 0 to 3");
  expect("scales", scene.scales.size(), scene.size());
  expect("rotations", scene.rotations.size(), scene.size());
  expect("opacities", scene.opacities.size(), scene.size());
  expect("sh0", scene.sh0.size(), scene.size());
  expect("sh_rest", scene.sh_rest.size(), scene.size() * 3 * sh_rest_count(scene.sh_degree));
}

/// The highest band with a coefficient other than zero: what is above it need not be read to render the
/// scene.
inline int used_sh_degree(const Scene& scene) {
  const std::size_t stride = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  for (int degree = scene.sh_degree; degree > 0; --degree) {
    const std::size_t first = 3 * std::size_t(sh_rest_count(degree - 1));
    const std::size_t last = 3 * std::size_t(sh_rest_count(degree));
    for (std::size_t i = 0; i < scene.size(); ++i)
      for (std::size_t k = first; k < last; ++k)
        if (scene.sh_rest[i * stride + k] != 0) return degree;
  }
  return 0;
}

/// A view of `scene`, which must outlive it. Throws `std::invalid_argument` as `validate` does.
inline SceneView view(const Scene& scene) {
  validate(scene);
  const auto span = [](const auto& v) { return Span{v.data(), v.size()}; };
  return {.means = span(scene.means),
          .scales = span(scene.scales),
          .rotations = span(scene.rotations),
          .opacities = span(scene.opacities),
          .sh0 = span(scene.sh0),
          .sh_rest = span(scene.sh_rest),
          .sh_degree = used_sh_degree(scene),
          .sh_stride = 3 * sh_rest_count(scene.sh_degree)};
}

}  // namespace swiftgs
