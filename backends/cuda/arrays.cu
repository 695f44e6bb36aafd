// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/error.hpp>
#include <swiftgs/memory/copy_arrays.hpp>
#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/project/chunks.hpp>

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
  const std::size_t channels = std::size_t(from.feature_channels);
  to->means.reset(n), to->scales.reset(n), to->rotations.reset(n), to->opacities.reset(n);
  to->sh0.reset(n), to->sh_rest.reset(n * stride);
  to->features.reset(n * channels);
  copy_arrays(*this, from, SceneCapacity::of(*to, 0, int(stride), from.feature_channels));
  SceneView view = to->view(n, from.sh_degree, from.feature_channels);
  view.model = from.model;
  return DeviceScene(std::move(to), view);
}

namespace kernels {
constexpr unsigned bound_threads = 256, bound_warps = bound_threads / warp_size;

/// Bounds of `count` chunks of `scene` from `first` on: a warp a chunk.
__global__ void __launch_bounds__(bound_threads)
    bound_chunks(const __grid_constant__ SceneView scene, const std::uint32_t first,
                 const std::uint32_t count, ChunkBounds* const chunks) {
  await_earlier();
  const std::uint32_t i = blockIdx.x * bound_warps + threadIdx.x / warp_size;
  if (i >= count) return;
  const std::size_t begin = std::size_t(first + i) * chunk_size;
  ChunkBounds bounds;
  for (unsigned k = lane_index(); k < chunk_size; k += warp_size)
    if (begin + k < scene.size()) detail::add_gaussian(bounds, scene, begin + k);
  for (unsigned step = warp_size / 2; step > 0; step /= 2) {
    const auto of_other = [&](float value) { return __shfl_xor_sync(whole_warp, value, step); };
    const auto vector = [&](const vec3& v) { return vec3(of_other(v.x), of_other(v.y), of_other(v.z)); };
    detail::add_bounds(
        bounds, {vector(bounds.low), of_other(bounds.size), vector(bounds.high), of_other(bounds.opacity)});
  }
  if (lane_index() == 0) chunks[first + i] = bounds;
}
}  // namespace kernels

void Cuda::update(DeviceScene& scene, std::size_t first, const SceneArrays& from) const {
  const SceneView view = scene.view();
  if (!scene.arrays()) throw InvalidArgument(update_of_borrowed);
  require_replaceable(view.sh_rest, from);
  validate_update(view, first, from);
  DeviceScene::Arrays& to = *scene.arrays();
  const int sh_stride = view.sh_rest.is_packed() ? 0 : int(view.sh_rest.stride / sizeof(float));
  copy_arrays(*this, from, SceneCapacity::of(to, first, sh_stride, view.feature_channels));
  const ChunkRange chunks = view.chunks.empty() ? ChunkRange{} : chunks_to_bound(first, from);
  if (chunks.size() == 0) return;
  launch_early(*this, "bound_chunks", kernels::bound_chunks, blocks_for(chunks.size(), kernels::bound_warps),
               kernels::bound_threads, view, std::uint32_t(chunks.begin), std::uint32_t(chunks.size()),
               to.chunks.data());
}

}  // namespace swiftgs
