// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/raster/raster.hpp>

#include "blending.hpp"
#include "forms.hpp"

/// @file
/// Parts of squares that one warp hands over to others, since its list is long. Handing over moves work and
/// changes no bit.

namespace swiftgs::kernels {

/// A part is 8x8 pixels.
inline constexpr unsigned part_side = 8, pixels_of_part = part_side * part_side;

/// The p-th pixel of this lane.
__device__ inline unsigned pixel_of_part(unsigned p) { return p * warp_size + lane_index(); }

/// The pixels of a part behind some pieces.
template <bool with_depth>
struct JoinedPart {
  float4 totals[pixels_of_part];
  float depths[with_depth ? pixels_of_part : 1];

  __device__ JoinedPixel load(unsigned pixel) const {
    return {totals[pixel], with_depth ? depths[pixel] : 0};
  }
  __device__ void store(unsigned pixel, const JoinedPixel& from) {
    totals[pixel] = from.total;
    if constexpr (with_depth) depths[pixel] = from.depth;
  }
};

/// Where the walk of a list goes on: at a position, but behind the first splats from there on that touch the
/// part.
struct ResumeAt {
  std::uint32_t position, skipped;
};

/// A part at the end of a piece.
struct LongPart {
  JoinedPart<true> joined;
  unsigned live[pixels_of_lane];  ///< lanes whose pixel has not stopped
  std::uint32_t pieces;           ///< so far
  std::uint32_t column, row;      ///< of its square
  std::uint32_t part;             ///< of the square
  ResumeAt at;
};

/// Parts that were handed over, and how many of them have been taken up. Zero between frames.
struct LongPartCounts {
  std::uint32_t found, taken;
};

struct LongParts {
  LongPart* parts = nullptr;
  LongPartCounts* counts = nullptr;
  std::uint32_t capacity = 0;

  __device__ std::uint32_t size() const { return min(counts->found, capacity); }

  /// Room for one more, for a warp; null: there is none.
  __device__ LongPart* take() const {
    std::uint32_t slot = 0;
    if (lane_index() == 0) slot = atomicAdd(&counts->found, 1u);
    slot = __shfl_sync(whole_warp, slot, 0);
    return slot < capacity ? parts + slot : nullptr;
  }
};

/// A walk is long that has blended so many splats, if enough instances are left for other blocks to gain on
/// it: one block, or a cluster of blocks.
inline constexpr std::uint32_t long_blended = 1024, left_for_block = 1024, left_for_cluster = 16384;

/// More long parts than this keep a device busy without help.
inline constexpr std::size_t most_block_parts = 7168, most_cluster_parts = 1024;

/// The long parts of a frame.
struct LongWork {
  LongParts of_blocks, of_clusters;

  /// In memory of `cuda`, for a frame of so many parts.
  static LongWork of(Cuda& cuda, std::size_t parts) {
    const std::size_t blocks = std::min(parts, most_block_parts),
                      clusters = kernels_await_earlier ? std::min(parts, most_cluster_parts) : 0;
    const std::size_t head = 256;  // keeps the parts aligned
    static_assert(2 * sizeof(LongPartCounts) <= 256 && sizeof(LongPart) % 16 == 0);
    std::byte* const memory = cuda.raster_scratch(head + (blocks + clusters) * sizeof(LongPart));
    auto* const counts = reinterpret_cast<LongPartCounts*>(memory);
    auto* const slots = reinterpret_cast<LongPart*>(memory + head);
    return {{slots, counts, std::uint32_t(blocks)}, {slots + blocks, counts + 1, std::uint32_t(clusters)}};
  }

  /// Has the next frame begin without parts.
  void forget(Cuda& cuda) const { cuda.clear(of_blocks.counts, 2 * sizeof(LongPartCounts)); }

  /// Room for a part whose walk is long, for a warp; null: it is not, or there is none.
  __device__ LongPart* take(std::uint32_t blended, std::uint32_t left) const {
    if (blended < long_blended || left < left_for_block) return nullptr;
    LongPart* part = nullptr;
    if (left >= left_for_cluster && of_clusters.capacity != 0) part = of_clusters.take();
    return part ? part : of_blocks.take();
  }
};

}  // namespace swiftgs::kernels
