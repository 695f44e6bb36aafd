// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <optional>
#include <utility>

#include <swiftgs/cuda.cuh>
#include <swiftgs/scene_arrays.hpp>

#include "device_scene.hpp"

namespace swiftgs {

DeviceScene Cuda::upload(const SceneArrays& from) const {
  std::optional<DeviceScene> none;
  return upload(from, none);
}

DeviceScene Cuda::upload(const SceneArrays& from, std::optional<DeviceScene>& reuse) const {
  validate(from);
  check_not_captured("upload");
  std::shared_ptr<DeviceScene::Arrays> to;
  if (reuse) to = DeviceScene::take(*std::exchange(reuse, std::nullopt));
  if (!to) {
    to = std::make_shared<DeviceScene::Arrays>();
    use_memory_of(*this, *to);
  }
  const std::size_t n = from.count, stride = sh_rest_stride(from.sh_degree);
  to->means.reset(n), to->scales.reset(n), to->rotations.reset(n), to->opacities.reset(n);
  to->sh0.reset(n), to->sh_rest.reset(n * stride);
  to->features.reset(n * std::size_t(from.feature_channels));
  copy_arrays(*this, from,
              {to->means.data(), to->scales.data(), to->rotations.data(), to->opacities.data(),
               to->sh0.data(), to->sh_rest.data(), int(stride), to->features.data()});
  const DeviceScene::Arrays& copied = *to;
  const SceneView view{.means = copied.means.span(),
                       .scales = copied.scales.span(),
                       .rotations = copied.rotations.span(),
                       .opacities = copied.opacities.span(),
                       .sh0 = copied.sh0.span(),
                       .sh_rest = copied.sh_rest.span(),
                       .sh_degree = from.sh_degree,
                       .sh_stride = int(stride),
                       .features = copied.features.span(),
                       .feature_channels = from.feature_channels,
                       .identity = new_scene_identity()};
  return DeviceScene(std::move(to), view);
}

}  // namespace swiftgs
