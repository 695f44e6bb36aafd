// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <tuple>

#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

struct DeviceScene::Arrays {
  DeviceBuffer<vec3> means, scales, sh0;
  DeviceBuffer<Quaternion> rotations;
  DeviceBuffer<float> opacities, features;
  DeviceBuffer<float> sh_rest;         ///< or what takes the place of floats
  DeviceBuffer<std::uint16_t> labels;  ///< empty: no palette
  DeviceBuffer<ChunkBounds> chunks;    ///< empty for arrays of the device, whose order nobody looks at

  /// Of `count` Gaussians; without chunks.
  SceneView view(std::size_t count, int sh_degree, int feature_channels) const;

  static auto buffers(auto& self) {
    return std::tie(self.means, self.scales, self.sh0, self.rotations, self.opacities, self.features,
                    self.sh_rest, self.labels, self.chunks);
  }
};

/// Floats a Gaussian in `sh_rest` for bands up to `degree`: a multiple of 16 bytes, which kernels copy by,
/// and of a colour.
inline std::size_t sh_rest_stride(int degree) {
  return padded_row(HarmonicFormat::floats, degree) / sizeof(float);
}

inline SceneView DeviceScene::Arrays::view(std::size_t count, int sh_degree, int feature_channels) const {
  const auto rows = [count](const DeviceBuffer<float>& of, std::size_t each) {
    return each == 0 ? StridedSpan<const float>() : StridedSpan(of.data(), count, each * sizeof(float));
  };
  return {.means = means.span(),
          .scales = scales.span(),
          .rotations = rotations.span(),
          .opacities = opacities.span(),
          .sh0 = sh0.span(),
          .sh_rest = rows(sh_rest, sh_rest_stride(sh_degree)),
          .sh_degree = sh_degree,
          .features = rows(features, std::size_t(feature_channels)),
          .feature_channels = feature_channels,
          .identity = new_scene_identity()};
}

}  // namespace swiftgs
