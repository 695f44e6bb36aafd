// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <tuple>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/memory/harmonic_packing.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/tools/parallel.hpp>
#include <swiftgs/vulkan/backend.hpp>

namespace swiftgs {

struct VulkanScene::Arrays {
  VulkanBuffer<vec3> means, scales, sh0;
  VulkanBuffer<Quaternion> rotations;
  VulkanBuffer<float> opacities, features;
  VulkanBuffer<unsigned char> sh_rest;
  VulkanBuffer<std::uint16_t> labels;  ///< empty: no palette
  VulkanBuffer<ChunkBounds> chunks;

  static auto buffers(auto& self) {
    return std::tie(self.means, self.scales, self.sh0, self.rotations, self.opacities, self.features,
                    self.sh_rest, self.labels, self.chunks);
  }
};

namespace {

template <class T>
void copy(const Vulkan& b, const std::vector<T>& from, VulkanBuffer<T>& to) {
  to.reset_exactly(from.size());
  b.write(from.data(), to.data(), from.size() * sizeof(T));
}

void copy(const Vulkan& b, const HarmonicPacking& packing, VulkanScene::Arrays& to) {
  constexpr std::size_t block = 1 << 16;
  const std::size_t rows = packing.rows(), stride = packing.stride();
  if (stride == 0 || rows == 0) return;
  to.sh_rest.reset_exactly(rows * stride);
  std::vector<unsigned char> written(std::min(rows, block) * stride);
  for (std::size_t first = 0; first < rows; first += block) {
    const std::size_t count = std::min(block, rows - first);
    for (std::size_t i = 0; i < count; ++i) packing.write(first + i, written.data() + i * stride);
    b.write(written.data(), to.sh_rest.data() + first * stride, count * stride);
  }
  const auto labels = packing.labels();
  copy(b, std::vector<std::uint16_t>(labels.begin(), labels.end()), to.labels);
}

}  // namespace

VulkanScene Vulkan::upload(const Scene& scene, HarmonicsKept kept) const {
  const SceneView host = swiftgs::view(scene);
  validate_numbers(HostThreads(), scene);
  const HarmonicPacking packing(HostThreads(), scene, host.sh_degree, kept);
  const auto arrays = std::make_shared<VulkanScene::Arrays>();
  use_memory_of(*this, *arrays);
  copy(*this, scene.means, arrays->means), copy(*this, scene.scales, arrays->scales);
  copy(*this, scene.rotations, arrays->rotations), copy(*this, scene.opacities, arrays->opacities);
  copy(*this, scene.sh0, arrays->sh0), copy(*this, scene.features, arrays->features);
  copy(*this, packing, *arrays), copy(*this, chunk_bounds(host), arrays->chunks);
  SceneView device = host;
  device.means = std::as_const(arrays->means).span(), device.scales = std::as_const(arrays->scales).span();
  device.rotations = std::as_const(arrays->rotations).span();
  device.opacities = std::as_const(arrays->opacities).span();
  device.sh0 = std::as_const(arrays->sh0).span();
  device.features.data = arrays->features.data();
  device.sh_rest = packing.rows_at(arrays->sh_rest.data(), arrays->labels.data());
  device.chunks = std::as_const(arrays->chunks).span();
  device.identity = new_scene_identity();
  return VulkanScene(arrays, device);
}

VulkanScene Vulkan::upload(std::shared_ptr<const Scene> scene, HarmonicsKept kept) const {
  if (!scene) throw InvalidArgument("upload: expected a scene");
  return upload(*scene, kept);
}

}  // namespace swiftgs
