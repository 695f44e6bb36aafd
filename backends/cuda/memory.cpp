// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <cuda_runtime_api.h>

#include <swiftgs/chunks.hpp>
#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/check.hpp>

#include "device_scene.hpp"

namespace swiftgs {

void* DeviceMemory::allocate(std::size_t bytes) {
  void* memory = nullptr;
  const cudaError_t result = cudaMalloc(&memory, bytes);
  if (result == cudaErrorMemoryAllocation) {
    cudaGetLastError();  // the next call must not see it again
    const MemoryUse use = Cuda::memory_use();
    throw CapacityError("bytes of device memory", bytes, use.total - use.in_use);
  }
  check_cuda(result, "cudaMalloc");
  return memory;
}

void DeviceMemory::release(void* memory) { cudaFree(memory); }

namespace {

/// Copies a host array in the order of `stream`.
template <class T>
void copy(const std::vector<T>& from, DeviceBuffer<T>& to, cudaStream_t stream) {
  if (from.empty()) return;
  to.reset_exactly(from.size());
  check_cuda(cudaMemcpyAsync(to.data(), from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice, stream),
             "cudaMemcpyAsync to the device");
}

}  // namespace

DeviceScene Cuda::upload(const Scene& scene) const {
  const SceneView host = swiftgs::view(scene);
  validate_numbers(scene);
  check_not_captured("upload");
  const auto arrays = std::make_shared<DeviceScene::Arrays>();
  use_memory_of(*this, *arrays);
  // Only the bands that are used.
  const std::size_t used = 3 * std::size_t(sh_rest_count(host.sh_degree));
  const std::size_t stride = sh_rest_stride(host.sh_degree);
  std::vector<float> rest(stride * scene.size());
  for (std::size_t i = 0; i < scene.size() && used != 0; ++i)
    std::copy_n(host.sh_rest.at(i), used, rest.data() + i * stride);
  const std::vector<ChunkBounds> chunks = chunk_bounds(host);
  copy(scene.means, arrays->means, stream()), copy(scene.scales, arrays->scales, stream());
  copy(scene.rotations, arrays->rotations, stream()), copy(scene.opacities, arrays->opacities, stream());
  copy(scene.sh0, arrays->sh0, stream()), copy(rest, arrays->sh_rest, stream());
  copy(scene.features, arrays->features, stream()), copy(chunks, arrays->chunks, stream());
  SceneView device = arrays->view(scene.size(), host.sh_degree, host.feature_channels);
  device.chunks = std::as_const(arrays->chunks).span();
  // Copies read memory of the caller, and other streams may read the scene at once.
  check_cuda(cudaStreamSynchronize(stream()), "cudaStreamSynchronize");
  return DeviceScene(arrays, device);
}

DeviceScene Cuda::upload(std::shared_ptr<const Scene> scene) const {
  if (!scene) throw std::invalid_argument("upload: expected a scene");
  return upload(*scene);
}

}  // namespace swiftgs
