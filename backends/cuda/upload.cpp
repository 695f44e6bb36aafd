// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include <cuda_runtime_api.h>

#include <swiftgs/cuda/check.hpp>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/memory/harmonic_packing.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/tools/parallel.hpp>

#include "device_scene.hpp"

namespace swiftgs {

namespace {

void copy_bytes(const void* from, std::size_t bytes, void* to, cudaStream_t stream) {
  check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream),
             "cudaMemcpyAsync to the device");
}

/// Copies a host array in the order of `stream`.
template <class T>
void copy(Span<const T> from, DeviceBuffer<T>& to, cudaStream_t stream) {
  if (from.empty()) return;
  to.reset_exactly(from.size);
  copy_bytes(from.data, from.size * sizeof(T), to.data(), stream);
}
template <class T>
void copy(const std::vector<T>& from, DeviceBuffer<T>& to, cudaStream_t stream) {
  copy(Span<const T>{from.data(), from.size()}, to, stream);
}

/// Writes rows by all threads, and copies them in the order of `stream`, a block at a time.
void copy(const HarmonicPacking& packing, DeviceScene::Arrays& to, cudaStream_t stream) {
  constexpr std::size_t part = 4096, block = 64 * part;  // rows of a loop, and of a copy: 48 MiB of floats
  const std::size_t rows = packing.rows(), stride = packing.stride();
  if (stride == 0 || rows == 0) return;
  to.sh_rest.reset_exactly(rows * stride / sizeof(float));
  const auto written = std::make_unique_for_overwrite<unsigned char[]>(std::min(rows, block) * stride);
  for (std::size_t first = 0; first < rows; first += block) {
    const std::size_t count = std::min(block, rows - first);
    // The copy of the block before reads from `written`.
    if (first != 0) check_cuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
    HostThreads().for_each(Count((count + part - 1) / part), [&](std::size_t p) {
      for (std::size_t i = p * part; i < std::min((p + 1) * part, count); ++i)
        packing.write(first + i, written.get() + i * stride);
    });
    copy_bytes(written.get(), count * stride, to.sh_rest.data() + first * stride / sizeof(float), stream);
  }
  // `written` ends here.
  check_cuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
  copy(packing.labels(), to.labels, stream);
}

}  // namespace

DeviceScene Cuda::upload(const Scene& scene, HarmonicsKept kept) const {
  check_not_captured("upload");
  const SceneView host = swiftgs::view(scene);
  validate_numbers(HostThreads(), scene);
  const HarmonicPacking packing(HostThreads(), scene, host.sh_degree, kept);
  const auto arrays = std::make_shared<DeviceScene::Arrays>();
  use_memory_of(*this, *arrays);
  const std::vector<ChunkBounds> chunks = chunk_bounds(host);
  copy(scene.means, arrays->means, stream()), copy(scene.scales, arrays->scales, stream());
  copy(scene.rotations, arrays->rotations, stream()), copy(scene.opacities, arrays->opacities, stream());
  copy(scene.sh0, arrays->sh0, stream()), copy(packing, *arrays, stream());
  copy(scene.features, arrays->features, stream()), copy(chunks, arrays->chunks, stream());
  SceneView device = arrays->view(scene.size(), host.sh_degree, host.feature_channels);
  device.sh_rest = packing.rows_at(arrays->sh_rest.data(), arrays->labels.data());
  device.chunks = std::as_const(arrays->chunks).span(), device.model = scene.model;
  // Copies read memory of the caller, and other streams may read the scene at once.
  check_cuda(cudaStreamSynchronize(stream()), "cudaStreamSynchronize");
  return DeviceScene(arrays, device);
}

DeviceScene Cuda::upload(std::shared_ptr<const Scene> scene, HarmonicsKept kept) const {
  if (!scene) throw InvalidArgument("upload: expected a scene");
  return upload(*scene, kept);
}

}  // namespace swiftgs
