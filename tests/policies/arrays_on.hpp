// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include <swiftgs/scene_arrays.hpp>

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

  Buffer<vec3> means, scales, sh0;
  Buffer<Quaternion> rotations;
  Buffer<float> opacities, sh_rest, features;
  SceneArrays all;
};

}  // namespace swiftgs::test
