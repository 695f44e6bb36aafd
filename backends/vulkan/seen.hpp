// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Views and scenes as shaders read them.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/frame/placing.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/project/chunks.hpp>

#include "commands.hpp"
#include "eye.hpp"

namespace swiftgs::vulkan {

/// An address in a struct of words.
struct Address {
  std::uint32_t low = 0, high = 0;

  Address() = default;
  Address(const void* data)
      : low(std::uint32_t(reinterpret_cast<std::uintptr_t>(data))),
        high(std::uint32_t(reinterpret_cast<std::uintptr_t>(data) >> 32)) {}
};

/// As frame.glsl declares them.
struct SceneWords {
  Address means, scales, rotations, opacities, sh0, sh_rest, labels, features, chunks;
  std::uint32_t means_stride, scales_stride, rotations_stride, opacities_stride, sh0_stride, sh_stride,
      features_stride;
  std::uint32_t sh_format;
  float sh_scale;
  std::uint32_t sh_rows, sh_degree, any_rotations, plain_colours;

  SceneWords() = default;
  explicit SceneWords(const SceneView& scene)
      : means(scene.means.data),
        scales(scene.scales.data),
        rotations(scene.rotations.data),
        opacities(scene.opacities.data),
        sh0(scene.sh0.data),
        sh_rest(scene.sh_rest.data),
        labels(scene.sh_rest.labels),
        features(scene.features.data),
        chunks(scene.chunks.data),
        means_stride(scene.means.stride),
        scales_stride(scene.scales.stride),
        rotations_stride(scene.rotations.stride),
        opacities_stride(scene.opacities.stride),
        sh0_stride(scene.sh0.stride),
        sh_stride(scene.sh_rest.stride),
        features_stride(scene.features.stride),
        sh_format(std::uint32_t(scene.sh_rest.format)),
        sh_scale(scene.sh_rest.scale),
        sh_rows(std::uint32_t(scene.sh_rest.size)),
        sh_degree(std::uint32_t(scene.sh_degree)),
        any_rotations(scene.any_rotations),
        plain_colours(scene.plain_colours) {}
};

/// As chunks.glsl declares it.
struct Culler {
  float wide, high, blur;

  explicit Culler(const ChunkCuller& of)
      : wide(1.0001f * float(of.wide())),
        high(1.0001f * float(of.high())),
        blur(1.0001f * float(of.blur())) {}
};
static_assert(chunk_size == usual_threads);

struct Seen {
  Eye eye;
  SceneWords scene;
  vec4 half_spaces[Clip::max_half_spaces];
  std::uint32_t half_space_count = 0;
  vec3 clip_centre{0};
  float clip_radius = 0;
  vec3 tint{0};
  float tint_amount = 0;
  std::uint32_t first_gaussian = 0;
  Culler culler;
  std::uint32_t unused[2] = {};

  Seen(const View& view, const StoredScene& placed) : Seen(swiftgs::eye(view.camera, placed), placed) {}

 private:
  Seen(const ViewConstants& from, const StoredScene& placed)
      : eye(from),
        scene(placed.scene),
        half_space_count(std::uint32_t(placed.clip.half_space_count)),
        clip_centre(placed.clip.centre),
        clip_radius(placed.clip.radius),
        tint(placed.tint.colour),
        tint_amount(placed.tint.amount),
        first_gaussian(placed.first_gaussian),
        culler(ChunkCuller(from)) {
    for (int k = 0; k < Clip::max_half_spaces; ++k) half_spaces[k] = placed.clip.half_spaces[k];
  }
};

static_assert(sizeof(Seen) % 16 == 0);

/// Every scene by every view, for kernels of `commands`.
inline const Seen* all_seen(Commands& commands, const Views& views, const StoredScenes& scenes) {
  std::vector<Seen> seen;
  for (const View& view : views)
    for (const StoredScene& placed : scenes.each()) seen.emplace_back(view, placed);
  return commands.constants(Span<const Seen>{seen.data(), seen.size()});
}

/// As attributes.glsl declares it.
struct AttributeList {
  struct {
    std::uint32_t of = 0, channel = 0;
  } each[AttributesView::most];
  float most = 0;
  std::uint32_t has_normal = 0, has_ray_depth = 0, count = 0;

  AttributeList() = default;
  /// Rows of those from `first` on that `view` is asked for.
  AttributeList(const View& view, int first, unsigned rows)
      : most(most_attribute(view.rules.alpha_max)),
        has_normal(first == 0 && view.request.normal),
        has_ray_depth(first == 0 && asks_for_ray_depth(view)),
        count(rows * AttributeRow::channels) {
    for (int k = 0; k < int(AttributesView::most); ++k) {
      const Attribute from = attribute(view, view.request, first + k);
      each[k] = {std::uint32_t(from.of), std::uint32_t(from.channel)};
    }
  }
};

static_assert(sizeof(TileGrid) == 28 && offsetof(TileGrid, side) == 16);
inline const TileGrid* grids_of(Commands& commands, const Views& views) {
  std::vector<TileGrid> grids;
  for (const View& view : views) grids.push_back(view.grid);
  return commands.constants(Span<const TileGrid>{grids.data(), grids.size()});
}

}  // namespace swiftgs::vulkan
