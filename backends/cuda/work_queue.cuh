// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <cuda/atomic>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/raster_block.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/raster/raster.hpp>

#include "blending.hpp"
#include "exponents.hpp"

/// @file
/// Parts of raster blocks that one warp hands over to others, since its list is long. Handing over moves work
/// and changes no bit.

namespace swiftgs::kernels {

/// A part is 8x8 pixels.
inline constexpr unsigned warp_block_side = 8, pixels_of_warp_block = warp_block_side * warp_block_side;

/// The p-th pixel of this lane.
__device__ inline unsigned pixel_of_warp_block(unsigned p) { return p * warp_size + lane_index(); }

/// Where a pixel lies within its part. The first 32 are its left half.
struct PlaceInWarpBlock {
  unsigned column, row;

  __device__ explicit PlaceInWarpBlock(unsigned pixel) {
    column = pixel % columns_between + pixel / warp_size * columns_between;
    row = pixel % warp_size / columns_between;
  }
};

/// Pixels behind some segments.
template <bool with_depth, unsigned count>
struct JoinedPixels {
  float4 totals[count];
  float depths[with_depth ? count : 1];

  __device__ JoinedPixel load(unsigned pixel) const {
    return {totals[pixel], with_depth ? depths[pixel] : 0};
  }
  __device__ void store(unsigned pixel, const JoinedPixel& from) {
    totals[pixel] = from.total;
    if constexpr (with_depth) depths[pixel] = from.depth;
  }
};
template <bool with_depth>
using JoinedWarpBlock = JoinedPixels<with_depth, pixels_of_warp_block>;

/// Where the traversal of a list goes on: at a position, but behind the first splats from there on that touch
/// the part.
struct ResumeAt {
  std::uint32_t position, skipped;
};

/// A part at the end of a segment, or within the first.
struct WorkItem {
  JoinedWarpBlock<true> joined;   ///< pixels behind all splats that are blended
  unsigned live[pixels_of_lane];  ///< lanes whose pixel has not stopped
  std::uint32_t segments;         ///< so far
  std::uint32_t blended;          ///< splats
  RasterBlockIndex raster_block;
  std::uint32_t part;  ///< of the raster block
  ResumeAt at;
};

/// A long traversal has blended so many splats, or visited so many intersections. It is handed over. A
/// shorter traversal is handed over only if others wait for work.
inline constexpr std::uint32_t long_blended = 4096, long_visited = 8192;
/// Frames stop sharing long parts after so many in a row without one.
inline constexpr std::uint32_t most_quiet_frames = 8;
/// They share again after a frame in which a warp alone has blended so many splats, or visited so many
/// intersections.
inline constexpr std::uint32_t loud_blended = long_blended / 2, loud_visited = long_visited / 2;
/// A traversal asks at the end of each segment whether others wait, and after so many intersections without
/// one.
inline constexpr std::uint32_t visits_between_checks = 1024;
/// If fewer intersections are left, others would not gain.
inline constexpr std::uint32_t least_left = 2048;

/// Queues of long parts, by the intersections that are left. Clusters of blocks take those of the first two,
/// the first before the second. Single blocks take the rest.
enum : unsigned { longest, longer, shorter, queue_count };
inline constexpr std::uint32_t least_left_of_longest = 65536, least_left_of_longer = 32768;

/// Parts of each queue at most. More of them keep a device busy without help.
inline constexpr std::size_t most_longest = 256, most_longer = 1024, most_shorter = 7168;

/// The long parts of a frame, in queues that warps fill while groups of blocks empty them: clusters, or
/// single blocks. Where frames have had no long parts for a while, one kernel draws them and hands nothing
/// over.
struct WorkQueues {
  struct Queue {
    std::uint32_t found;  ///< handed over; more than there is room for, if some were refused
    std::uint32_t taken;
  };
  /// Groups that are single blocks, and clusters.
  struct Groups {
    std::uint32_t begun;
    std::uint32_t done;  ///< parts
  };
  /// Zero between frames.
  struct State {
    std::uint32_t waiting;  ///< parts, and `complete`
    std::uint32_t left;     ///< blocks that are done
    Groups groups[2];       ///< single blocks, clusters
    Queue queues[queue_count];
  };
  /// A bit of `waiting`: no more will be handed over.
  static constexpr std::uint32_t complete = 1u << 31;

  WorkItem* parts;       ///< of all queues, one behind the other
  std::uint32_t* ready;  ///< of each part: not 0 after it is written and until it is taken
  State* state;
  std::uint32_t first[queue_count + 1];  ///< part of each queue, and behind the last
  std::uint32_t* quiet_frames;           ///< in a row that had no long parts, `most_quiet_frames` at most

  /// Bytes before the parts. The same for all frames, which leave zeros in them.
  static constexpr std::size_t head =
      sizeof(State) + (most_longest + most_longer + most_shorter) * sizeof(std::uint32_t);
  static_assert(head % 16 == 0 && sizeof(WorkItem) % 16 == 0);

  /// In memory of `cuda`, for a frame of so many parts.
  static WorkQueues of(Cuda& cuda, std::size_t parts) {
    WorkQueues all{};
    all.quiet_frames = cuda.raster_word();
    const auto add = [&](unsigned queue, std::size_t most) {
      all.first[queue + 1] = all.first[queue] + std::uint32_t(std::min(parts, most));
    };
    add(longest, kernels_await_earlier ? most_longest : 0);
    add(longer, kernels_await_earlier ? most_longer : 0);
    add(shorter, most_shorter);
    std::byte* const memory = cuda.raster_scratch(head + all.first[queue_count] * sizeof(WorkItem));
    all.parts = reinterpret_cast<WorkItem*>(memory + head);
    all.ready = reinterpret_cast<std::uint32_t*>(memory + sizeof(State));
    all.state = reinterpret_cast<State*>(memory);
    return all;
  }

  /// Whether the next frame shares long parts. Counted frames do, so that counts do not depend on the frames
  /// before. Recorded frames do: nobody awaits them, so the host knows nothing of the frames before.
  static bool are_shared(const Cuda& cuda, bool counted) {
    return counted || cuda.known_raster_word() < most_quiet_frames;
  }

  /// Has the next frame begin without parts.
  void forget(Cuda& cuda) const { cuda.clear(state, head); }

  /// Room for a part, for a warp whose traversal has blended so many splats, visited so many intersections
  /// and left so many; null: the traversal is not long and nobody waits for it, others would not gain, or
  /// there is no room.
  __device__ WorkItem* reserve_item(std::uint32_t blended, std::uint32_t visited,
                                    std::uint32_t intersections_left) const {
    if (intersections_left < least_left) return nullptr;
    const bool is_long = blended >= long_blended || visited >= long_visited;
    std::uint32_t slot = none;
    if (lane_index() == 0) {
      // A shorter queue, if one is full.
      unsigned q = queue_of(intersections_left);
      while (q != shorter && found(q) == most(q)) ++q;
      if (found(q) != most(q) && (is_long || is_awaited(q))) {
        slot = first[q] + atomicAdd(&state->queues[q].found, 1u);
        if (slot >= first[q + 1]) slot = none;
      }
    }
    slot = __shfl_sync(whole_warp, slot, 0);
    return slot == none ? nullptr : parts + slot;
  }

  /// Publishes a part that this warp has written: from now on others may take it.
  __device__ void push(const WorkItem* part) const {
    __syncwarp();
    if (lane_index() != 0) return;
    word(state->waiting).fetch_add(1, cuda::memory_order_relaxed);  // before it can be taken
    word(ready[part - parts]).store(1, cuda::memory_order_release);
  }

  /// After a traversal of a frame that shares nothing.
  __device__ void end_traversal(std::uint32_t blended, std::uint32_t visited) const {
    if ((blended >= loud_blended || visited >= loud_visited) && lane_index() == 0)
      word(*quiet_frames).store(0, cuda::memory_order_relaxed);
  }

  /// For one thread of each group, before it asks for parts. The first single block and the first cluster
  /// wait for the end of the kernel that fills the queues, and so no block ends before.
  __device__ void begin(bool as_cluster) const {
    if (word(state->groups[as_cluster].begun).fetch_add(1, cuda::memory_order_relaxed) != 0) return;
    await_earlier();
    word(state->waiting).fetch_or(complete, cuda::memory_order_release);
  }

  /// Waits for the next part for a group, in one of its threads; null: there will be none.
  __device__ const WorkItem* await_next(bool as_cluster) const {
    for (;;) {
      const std::uint32_t waiting = word(state->waiting).load(cuda::memory_order_acquire);
      const WorkItem* part = nullptr;
      if (waiting != 0 && waiting != complete) {
        if (as_cluster) part = take(longest);
        if (!part) part = take(as_cluster ? longer : shorter);
      }
      if (part || (waiting & complete) != 0) return part;
      __nanosleep(100);
    }
  }

  /// After a group is done with a part, for one of its threads.
  __device__ void end_item(bool as_cluster) const {
    word(state->groups[as_cluster].done).fetch_add(1, cuda::memory_order_relaxed);
  }

  /// For one thread of each block, which asks for nothing more. The last leaves zeros for the next frame.
  __device__ void leave() const {
    if (word(state->left).fetch_add(1, cuda::memory_order_acq_rel) != gridDim.x - 1) return;
    const bool quiet = found(longest) + found(longer) + found(shorter) == 0;
    *quiet_frames = quiet ? min(*quiet_frames + 1, most_quiet_frames) : 0;
    *state = {};
  }

 private:
  using Word = cuda::atomic_ref<std::uint32_t, cuda::thread_scope_device>;
  __device__ static Word word(std::uint32_t& value) { return Word(value); }
  __device__ static std::uint32_t value(std::uint32_t& of) {
    return word(of).load(cuda::memory_order_relaxed);
  }

  static constexpr std::uint32_t none = ~0u;

  __device__ static unsigned queue_of(std::uint32_t intersections_left) {
    if (!kernels_await_earlier || intersections_left < least_left_of_longer) return shorter;
    return intersections_left < least_left_of_longest ? longer : longest;
  }
  __device__ std::uint32_t most(unsigned q) const { return first[q + 1] - first[q]; }
  __device__ std::uint32_t found(unsigned q) const { return min(value(state->queues[q].found), most(q)); }

  /// Whether more groups have nothing to do than parts wait for them. One waits for the kernel's end instead.
  __device__ bool is_awaited(unsigned q) const {
    const bool as_cluster = q != shorter;
    Groups& groups = state->groups[as_cluster];
    const std::uint32_t of_groups = as_cluster ? found(longest) + found(longer) : found(shorter);
    return value(groups.begun) + value(groups.done) > of_groups + 1;
  }

  /// Takes the next part of a queue; null: there is none, or it is not written yet.
  __device__ const WorkItem* take(unsigned q) const {
    Queue& queue = state->queues[q];
    std::uint32_t next = value(queue.taken);
    const std::uint32_t end = found(q);
    while (next < end) {
      const Word written = word(ready[first[q] + next]);
      if (written.load(cuda::memory_order_acquire) == 0) {
        const std::uint32_t before = next;
        next = value(queue.taken);
        if (next == before) return nullptr;  // not written; else others have taken it
      } else if (word(queue.taken).compare_exchange_strong(next, next + 1, cuda::memory_order_relaxed)) {
        written.store(0, cuda::memory_order_release);
        word(state->waiting).fetch_sub(1, cuda::memory_order_relaxed);
        return parts + first[q] + next;
      }
    }
    return nullptr;
  }
};

}  // namespace swiftgs::kernels
