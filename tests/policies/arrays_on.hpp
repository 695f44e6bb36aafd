// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include <swiftgs/memory/scene_arrays.hpp>

#include "policies/tile_lists.hpp"

namespace swiftgs::test {

/// Arrays of a scene in memory of a backend.
template <class B>
struct ArraysOn {
  template <class T>
  using Buffer = typename B::template Buffer<T>;

  ArraysOn(const B& backend, const Scene& scene)
      : means(to_backend(backend, scene.means)),
        scales(to_backend(backend, scene.scales)),
        sh0(to_backend(backend, scene.sh0)),
        rotations(to_backend(backend, scene.rotations)),
        opacities(to_backend(backend, scene.opacities)),
        sh_rest(to_backend(backend, scene.sh_rest)),
        features(to_backend(backend, scene.features)),
        all{.count = scene.size(), .sh_degree = scene.sh_degree, .feature_channels = scene.feature_channels} {
    for_each_array([](const char*, std::size_t, FloatArray& array,
                      const auto& buffer) { array = {reinterpret_cast<const float*>(buffer.data())}; },
                   all, *this);
  }

  SceneView view() const { return swiftgs::view(all); }

  Buffer<vec3> means, scales, sh0;
  Buffer<Quaternion> rotations;
  Buffer<float> opacities, sh_rest, features;
  SceneArrays all;
};

/// Each array, in the order of `for_each_array`, as a bit.
inline constexpr unsigned every_array = 0x7f, means_alone = 0x01, means_and_rotations = 0x05,
                          sh_rest_alone = 0x20;

/// `arrays` without those whose bit is not in `which`.
inline SceneArrays some_of(SceneArrays arrays, unsigned which) {
  unsigned bit = 1;
  for_each_array(
      [&](const char*, std::size_t, FloatArray& array) {
        if (!(which & bit)) array = {};
        bit *= 2;
      },
      arrays);
  return arrays;
}

/// Writes arrays of `from` into `scene`, from Gaussian `first` on.
inline void replace(Scene& scene, std::size_t first, const Scene& from, unsigned which = every_array) {
  unsigned bit = 1;
  for_each_array(
      [&](const char*, std::size_t each, auto& to, const auto& values) {
        if (which & bit) std::copy(values.begin(), values.end(), to.begin() + std::ptrdiff_t(first * each));
        bit *= 2;
      },
      scene, from);
}

}  // namespace swiftgs::test
