// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/memory/harmonic_packing.hpp>
#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/tools/parallel.hpp>
#include <swiftgs/vulkan/backend.hpp>

#include "commands.hpp"

namespace swiftgs {

struct VulkanScene::Arrays {
  VulkanDevice device;  ///< whose memory they lie in
  VulkanBuffer<vec3> means, scales, sh0;
  VulkanBuffer<Quaternion> rotations;
  VulkanBuffer<float> opacities, features;
  VulkanBuffer<unsigned char> sh_rest;
  VulkanBuffer<std::uint16_t> labels;  ///< empty: no palette
  VulkanBuffer<ChunkBounds> chunks;

  explicit Arrays(const Vulkan& b) : device(b.state().device) { use_memory_of(b, *this); }
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
  const auto arrays = std::make_shared<VulkanScene::Arrays>(*this);
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

namespace {

/// How copy_rows.comp turns numbers of training into those that are drawn.
enum class Turn : std::uint32_t { none, from_log, from_logit, normalised, from_colour };

struct RowsCopy {
  FloatArray from;
  void* to;
  std::size_t width;  ///< floats of a Gaussian
  std::size_t kept;   ///< in `to`: zeros behind the others
  Turn turn = Turn::none;
};

void copy(vulkan::Commands& commands, const RowsCopy& rows, std::size_t count) {
  if (!rows.from.data || rows.kept == 0) return;
  const std::size_t stride =
      rows.from.stride != 0 ? std::size_t(rows.from.stride) / sizeof(float) : rows.width;
  if (stride * sizeof(float) > 0xffffffff)
    detail::refuse("scene: stride is ", stride * sizeof(float), " bytes, expected less than 2^32");
  const std::size_t floats = (count - 1) * stride + rows.width;
  commands.run(vulkan::Kernel::copy_rows, {},
               vulkan::Push(vulkan::reads(rows.from.data, floats),
                            vulkan::writes(static_cast<float*>(rows.to), count * rows.kept),
                            std::uint32_t(stride * sizeof(float)), std::uint32_t(rows.width),
                            std::uint32_t(rows.kept), std::uint32_t(rows.turn), std::uint32_t(count)),
               vulkan::Commands::Shape::of(count));
}

/// Copies Gaussians to those of `to` from `first` on.
void copy(vulkan::Commands& commands, const SceneArrays& from, VulkanScene::Arrays& to, std::size_t first,
          std::size_t sh_stride) {
  if (from.count == 0) return;
  commands.forget();
  const auto channels = std::size_t(from.feature_channels);
  const RowsCopy all[] = {
      {from.means, to.means.data() + first, 3, 3},
      {from.scales, to.scales.data() + first, 3, 3, from.log_scales ? Turn::from_log : Turn::none},
      {from.rotations, to.rotations.data() + first, 4, 4, from.any_rotations ? Turn::normalised : Turn::none},
      {from.opacities, to.opacities.data() + first, 1, 1,
       from.logit_opacities ? Turn::from_logit : Turn::none},
      {from.sh0, to.sh0.data() + first, 3, 3, from.plain_colours ? Turn::from_colour : Turn::none},
      {from.sh_rest, to.sh_rest.data() + first * sh_stride * sizeof(float),
       3 * std::size_t(sh_rest_count(from.sh_degree)), sh_stride},
      {from.features, to.features.data() + first * channels, channels, channels}};
  for (const RowsCopy& rows : all) copy(commands, rows, from.count);
}

/// Floats side by side.
StridedSpan<const float> rows_of(const void* data, std::size_t count, std::size_t each) {
  if (each == 0) return {};
  return {static_cast<const float*>(data), count, each * sizeof(float)};
}

}  // namespace

VulkanScene Vulkan::upload(const SceneArrays& from, std::optional<VulkanScene>& reuse) const {
  validate(from);
  std::shared_ptr<VulkanScene::Arrays> to;
  if (reuse && reuse->arrays_.use_count() == 1) to = std::move(reuse->arrays_);
  reuse.reset();
  if (!to) to = std::make_shared<VulkanScene::Arrays>(*this);
  const std::size_t n = from.count, stride = 3 * std::size_t(sh_rest_count(from.sh_degree));
  const auto channels = std::size_t(from.feature_channels);
  vulkan::Commands commands(*this);
  to->means.reset(n), to->scales.reset(n), to->rotations.reset(n), to->opacities.reset(n), to->sh0.reset(n);
  to->sh_rest.reset(n * stride * sizeof(float)), to->features.reset(n * channels);
  copy(commands, from, *to, 0, stride);
  commands.forget();
  commands.submit();
  const VulkanScene::Arrays& all = *to;
  const SceneView view{.means = all.means.span(),
                       .scales = all.scales.span(),
                       .rotations = all.rotations.span(),
                       .opacities = all.opacities.span(),
                       .sh0 = all.sh0.span(),
                       .sh_rest = rows_of(all.sh_rest.data(), n, stride),
                       .sh_degree = from.sh_degree,
                       .features = rows_of(all.features.data(), n, channels),
                       .feature_channels = from.feature_channels,
                       .model = from.model,
                       .identity = new_scene_identity()};
  return VulkanScene(to, view);
}

void Vulkan::update(VulkanScene& scene, std::size_t first, const SceneArrays& from) const {
  const SceneView view = scene.view();
  if (!scene.arrays_) throw InvalidArgument(update_of_borrowed);
  require_replaceable(view.sh_rest, from);
  validate_update(view, first, from);
  VulkanScene::Arrays& to = *scene.arrays_;
  vulkan::Commands commands(*this);
  copy(commands, from, to, first, view.sh_rest.is_packed() ? 0 : view.sh_rest.stride / sizeof(float));
  const ChunkRange chunks = view.chunks.empty() ? ChunkRange{} : chunks_to_bound(first, from);
  if (chunks.size() != 0)
    commands.run(vulkan::Kernel::bound_chunks, {},
                 vulkan::Push(vulkan::reads(view.means.data, view.size()),
                              vulkan::reads(view.scales.data, view.size()),
                              vulkan::reads(view.rotations.data, view.size()),
                              vulkan::reads(view.opacities.data, view.size()),
                              vulkan::writes(to.chunks.data(), view.chunks.size), std::uint32_t(chunks.begin),
                              std::uint32_t(chunks.end), std::uint32_t(view.size())),
                 vulkan::Commands::Shape::of(chunks.size(), 1));
  commands.forget();
  commands.submit();
}

}  // namespace swiftgs
