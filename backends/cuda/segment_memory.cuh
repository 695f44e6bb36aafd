// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "lane_blender.cuh"
#include "touched_splats.cuh"

namespace swiftgs::kernels {

/// Warps of a thread block of the helper kernel.
inline constexpr unsigned segment_warps = 8, segment_threads = segment_warps * warp_size;
/// Thread blocks that a multiprocessor can hold.
template <class Planes>
inline constexpr unsigned segment_occupancy = Planes::few ? 3 : 2;
/// Thread blocks launched for each multiprocessor. One more is no faster on long lists, and starts later on
/// short ones.
/// Measured on an H200: with three, frames of garden and fox, whose lists are short, take 2.3 us longer than
/// with two; with one they take as long.
inline constexpr unsigned blocks_of_multiprocessor = 2;
/// Most segments that a warp blends at once.
inline constexpr unsigned most_segments_of_warp = 2;
/// Pixels of segments that a thread block blends in a round.
inline constexpr unsigned pixels_of_round = segment_warps * pixels_of_warp_block;

using SegmentSplats = TouchedSplats<segment_warps, segment_warps * segment_size,
                                    segment_warps * most_segments_of_warp * segment_size>;

/// Shared memory of a thread block.
template <class Exponent, class Planes>
struct SegmentShared {
  /// After a segment is blended, its pixels have their sums of attributes where those of splats were queued.
  Queue<Exponent, Planes> queues[segment_warps];
  SegmentSplats::Shared splats;
  // Of pixels in segments, by `Round::at`.
  float4 segments[pixels_of_round];  ///< RGB and `mark_stopped` transmittance
  float depths[Planes::depth ? pixels_of_round : 1];
  typename Planes::template Segments<pixels_of_round> planes_of_segments;
  /// Transmittances behind the segments of all thread blocks. Without attributes they lie in the queues.
  float gathered[Planes::fills_queues ? blocks_of_group * pixels_of_round : 1];
  JoinedWarpBlock<Planes::depth> joined;
  typename Planes::template Joined<pixels_of_warp_block> planes;
  unsigned live[pixels_of_lane];  ///< bits of pixels that did not stop
  std::uint32_t pixel_of_slot[pixels_of_warp_block];
  const WorkItem* item;
};

/// What lies in front of a segment of a pixel.
template <class Planes>
struct BeforeSegment {
  float transmittance;  ///< negative: no pixel, or it has stopped
  typename Planes::Before planes{};
};

/// In a round each warp blends one segment, or some at once. If more than half of the warp block's pixels are
/// live, each pixel has a slot and each lane two slots. Otherwise live pixels have the first slots and a lane
/// one slot. If 16 or fewer are live, half a warp blends a segment, so that a warp blends two.
struct Round {
  unsigned blocks;            ///< of the group
  unsigned live;              ///< live pixels
  unsigned slots;             ///< 64, 32 or 16
  unsigned segments_of_warp;  ///< at once
  std::uint32_t first;        ///< segment of the list
  std::uint32_t splats = 0;

  __device__ Round(unsigned blocks_, unsigned live_, std::uint32_t first_)
      : blocks(blocks_), live(live_), first(first_) {
    slots = live > 32 ? 64 : live > 16 || blocks != 1 ? 32 : 16;
    segments_of_warp = slots == 16 ? most_segments_of_warp : 1;
  }

  __device__ unsigned segments_of_block() const { return segment_warps * segments_of_warp; }
  /// Where the pixel in a slot of the k-th segment of a thread block is stored.
  __device__ unsigned at(unsigned k, unsigned slot) const {
    return k * (pixels_of_warp_block / segments_of_warp) + slot;
  }
  __device__ std::uint32_t most_splats() const { return blocks * segments_of_block() * segment_size; }
  __device__ unsigned segments() const { return (splats + segment_size - 1) / segment_size; }
  __device__ std::uint32_t splats_of(unsigned segment) const {
    const std::uint32_t before = segment * segment_size;
    return before < splats ? min(splats - before, segment_size) : 0;
  }
};

}  // namespace swiftgs::kernels
