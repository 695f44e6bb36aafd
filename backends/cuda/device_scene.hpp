// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <tuple>

#include <swiftgs/cuda.hpp>

namespace swiftgs {

struct DeviceScene::Arrays {
  DeviceBuffer<vec3> means, scales, sh0;
  DeviceBuffer<Quaternion> rotations;
  DeviceBuffer<float> opacities, sh_rest, features;
  DeviceBuffer<ChunkBounds> chunks;  ///< empty for arrays of the device, whose order nobody looks at

  static auto buffers(auto& self) {
    return std::tie(self.means, self.scales, self.sh0, self.rotations, self.opacities, self.sh_rest,
                    self.features, self.chunks);
  }
};

/// Floats a Gaussian in `sh_rest` for bands up to `degree`: a multiple of 16 bytes, which kernels copy by,
/// and of a colour.
inline std::size_t sh_rest_stride(int degree) { return (3 * std::size_t(sh_rest_count(degree)) + 3) / 4 * 4; }

}  // namespace swiftgs
