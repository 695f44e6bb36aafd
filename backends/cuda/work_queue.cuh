// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <type_traits>

#include <cuda/atomic>

#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/raster_block.cuh>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/cuda/warp.cuh>

#include "blending.hpp"
#include "exponents.hpp"
#include "state.hpp"

/// @file
/// Work queues: a warp with a long tile list pushes the rest of its warp block, and the helper kernel blends
/// it. This moves work and changes no bit.

namespace swiftgs::kernels {

/// A warp block is 8x8 pixels.
inline constexpr unsigned warp_block_side = 8, pixels_of_warp_block = warp_block_side * warp_block_side;

/// The p-th pixel of this lane.
__device__ inline unsigned pixel_of_warp_block(unsigned p) { return p * warp_size + lane_index(); }

/// A pixel within its warp block. The first 32 are the left half.
struct PixelOfWarpBlock {
  unsigned column, row;

  __device__ explicit PixelOfWarpBlock(unsigned pixel) {
    column = pixel % columns_between + pixel / warp_size * columns_between;
    row = pixel % warp_size / columns_between;
  }
};

/// Colours and depths of pixels behind the segments joined so far.
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

/// Resume at `position`, skip `skipped` touching splats.
struct ResumeAt {
  std::uint32_t position, skipped;
};

/// The rest of a warp block's list, from the end of a segment or from within the first.
struct WorkItem {
  JoinedWarpBlock<true> joined;   ///< pixels behind all splats that are blended
  unsigned live[pixels_of_lane];  ///< lanes whose pixel has not stopped
  std::uint32_t segments;         ///< so far
  std::uint32_t blended;          ///< splats
  RasterBlockIndex raster_block;
  std::uint32_t warp_block;  ///< of the raster block
  ResumeAt at;
};

/// A traversal is long after so many blended splats or visited intersections: its rest is pushed. A shorter
/// one is pushed only if a helper is idle.
/// Measured on an H200 when chosen: if every traversal is pushed after 1,024 splats, rasterizing
/// `builtin:12000000` takes 2.5 ms, not 1.3.
inline constexpr std::uint32_t long_blended = 4096, long_visited = 8192;
/// Frames stop sharing after so many frames in a row without a work item. A view that alternates with up to
/// seven others goes on sharing. The price: when lists become long after a while, two frames are drawn
/// without helpers. Measured on an H200: if every frame starts the helper kernel, frames of herz, garden and
/// fox, whose lists are short, take 1.1, 2.4 and 3.3 % longer than without segments. Of the 8 us in fox and
/// in garden, 4.6 are the helper kernel, which finds nothing, 2 the registers for pushing, and 1 to 2 the
/// joining.
inline constexpr std::uint32_t most_quiet_frames = 8;
/// Frames use work queues again after one in which a warp blended or visited so many intersections.
/// These limits lie below those for pushing. The price: while a warp visits between 4,096 and 8,192
/// intersections, eight of ten frames may start the helper kernel in vain.
inline constexpr std::uint32_t loud_blended = long_blended / 2, loud_visited = long_visited / 2;
/// A traversal looks for idle helpers at the end of each segment, and after so many intersections without
/// one.
inline constexpr std::uint32_t visits_between_checks = 1024;
/// With fewer intersections left, a helper would not gain.
inline constexpr std::uint32_t least_left = 2048;

/// Queues of work items, by intersections left. Clusters of thread blocks empty the first two, in this order.
/// Single thread blocks empty the last.
/// Measured on an H200: where `longer` begins at 32,768, rasterizing `builtin:4000000` takes 642 us, with
/// half of it 605, with a quarter 553 and with an eighth 569. If helpers take long lists from the start and
/// `raster_warps` the others alone, it takes 820 and more.
enum : unsigned { longest, longer, shorter, queue_count };
inline constexpr std::uint32_t least_left_of_longest = 16384, least_left_of_longer = 8192;

/// Most items of each queue. More of them keep a device busy without help.
inline constexpr std::size_t most_longest = 256, most_longer = 1024, most_shorter = 7168;

/// The work queues of a frame: warps push items while groups of thread blocks, clusters or single ones, take
/// them. If recent frames had no items, `raster_warps` alone draws the frame and pushes nothing.
struct WorkQueues {
  struct Queue {
    std::uint32_t found;  ///< pushed; above the capacity, if some were refused
    std::uint32_t taken;
  };
  /// Counts of groups of one kind.
  struct Groups {
    std::uint32_t begun;
    std::uint32_t done;  ///< items
  };
  /// Zero between frames.
  struct State {
    std::uint32_t waiting;  ///< items, and `complete`
    std::uint32_t left;     ///< thread blocks that are done
    Groups groups[2];       ///< single blocks, clusters
    Queue queues[queue_count];
  };
  /// A bit of `waiting`: no more items will be pushed.
  static constexpr std::uint32_t complete = 1u << 31;

  WorkItem* items;       ///< of all queues, one behind the other
  std::byte* planes;     ///< of the pixels of each item
  std::uint32_t* ready;  ///< of each item: not 0 after it is written and until it is taken
  State* state;
  std::uint32_t first[queue_count + 1];  ///< item of each queue, and behind the last
  std::uint32_t* quiet_frames;           ///< in a row without items, `most_quiet_frames` at most

  /// Bytes before the items. The same for all frames, which leave zeros in them.
  static constexpr std::size_t head =
      sizeof(State) + (most_longest + most_longer + most_shorter) * sizeof(std::uint32_t);
  static_assert(head % 16 == 0 && sizeof(WorkItem) % 16 == 0);

  /// In memory of `cuda`, for a frame of so many warp blocks whose pixels hold `Planes` in an item.
  template <class Planes>
  static WorkQueues of(Cuda& cuda, std::size_t warp_blocks) {
    WorkQueues all{};
    RasterMemory& raster = RasterMemory::of(cuda);
    all.quiet_frames = raster.at_least(cuda, raster.word, 1);
    const auto add = [&](unsigned queue, std::size_t most) {
      all.first[queue + 1] = all.first[queue] + std::uint32_t(std::min(warp_blocks, most));
    };
    add(longest, kernels_await_earlier ? most_longest : 0);
    add(longer, kernels_await_earlier ? most_longer : 0);
    add(shorter, most_shorter);
    const std::size_t of_items = all.first[queue_count] * sizeof(WorkItem),
                      of_planes = std::is_empty_v<Planes> ? 0 : all.first[queue_count] * sizeof(Planes);
    std::byte* const memory = raster.at_least(cuda, raster.scratch, head + of_items + of_planes);
    all.items = reinterpret_cast<WorkItem*>(memory + head);
    all.planes = memory + head + of_items;
    all.ready = reinterpret_cast<std::uint32_t*>(memory + sizeof(State));
    all.state = reinterpret_cast<State*>(memory);
    return all;
  }

  /// Whether the next frame uses work queues. Recorded frames do: nobody awaits them, so the host knows
  /// nothing of the frames before.
  static bool are_shared(const Cuda& cuda) { return RasterMemory::of(cuda).known_word < most_quiet_frames; }

  /// Without room: kernels push nothing to them.
  WorkQueues closed() const {
    WorkQueues all = *this;
    std::fill(std::begin(all.first), std::end(all.first), 0);
    return all;
  }
  __device__ bool are_closed() const { return first[queue_count] == 0; }

  /// Empties the queues for the next frame.
  void forget(Cuda& cuda) const { cuda.clear(state, head); }

  template <class Planes>
  __device__ Planes& planes_of(const WorkItem* item) const {
    return reinterpret_cast<Planes*>(planes)[item - items];
  }

  /// Reserves an item for a warp that blended, visited and left so many. Null if fewer than
  /// `least_left` are left, if the queues are full, or if the traversal is short and no helper is idle or
  /// fewer than `least_left_to_help` are left.
  template <std::uint32_t least_left_to_help>
  __device__ WorkItem* reserve_item(std::uint32_t blended, std::uint32_t visited,
                                    std::uint32_t intersections_left) const {
    if (intersections_left < least_left) return nullptr;
    const bool is_long = blended >= long_blended || visited >= long_visited;
    std::uint32_t slot = none;
    if (lane_index() == 0) {
      // A shorter queue, if one is full.
      unsigned q = queue_of(intersections_left);
      while (q != shorter && found(q) == most(q)) ++q;
      if (found(q) != most(q) && (is_long || (intersections_left >= least_left_to_help && is_awaited(q)))) {
        slot = first[q] + atomicAdd(&state->queues[q].found, 1u);
        if (slot >= first[q + 1]) slot = none;
      }
    }
    slot = __shfl_sync(whole_warp, slot, 0);
    return slot == none ? nullptr : items + slot;
  }

  /// Publishes an item that this warp has written: from now on helpers may take it.
  __device__ void push(const WorkItem* item) const {
    __syncwarp();
    if (lane_index() != 0) return;
    word(state->waiting).fetch_add(1, cuda::memory_order_relaxed);  // before it can be taken
    word(ready[item - items]).store(1, cuda::memory_order_release);
  }

  /// After a traversal of a frame without work queues.
  __device__ void end_traversal(std::uint32_t blended, std::uint32_t visited) const {
    if ((blended >= loud_blended || visited >= loud_visited) && lane_index() == 0)
      word(*quiet_frames).store(0, cuda::memory_order_relaxed);
  }

  /// For one thread of each group, before it takes items. The first single thread block and the first cluster
  /// wait for the end of the kernel that fills the queues, so no thread block ends before it.
  __device__ void begin(bool as_cluster) const {
    if (word(state->groups[as_cluster].begun).fetch_add(1, cuda::memory_order_relaxed) != 0) return;
    await_earlier();
    word(state->waiting).fetch_or(complete, cuda::memory_order_release);
  }

  /// Waits for the next item for a group, in one of its threads; null: there will be none.
  __device__ const WorkItem* await_next(bool as_cluster) const {
    for (;;) {
      const std::uint32_t waiting = word(state->waiting).load(cuda::memory_order_acquire);
      const WorkItem* item = nullptr;
      if (waiting != 0 && waiting != complete) {
        if (as_cluster) item = take(longest);
        if (!item) item = take(as_cluster ? longer : shorter);
      }
      if (item || (waiting & complete) != 0) return item;
      __nanosleep(100);
    }
  }

  /// After a group is done with an item, for one of its threads.
  __device__ void end_item(bool as_cluster) const {
    word(state->groups[as_cluster].done).fetch_add(1, cuda::memory_order_relaxed);
  }

  /// For one thread of each thread block that takes no more items. The last leaves zeros for the next frame.
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

  /// Whether more groups are idle than items are queued. One group always waits for the kernel's end instead.
  __device__ bool is_awaited(unsigned q) const {
    const bool as_cluster = q != shorter;
    Groups& groups = state->groups[as_cluster];
    const std::uint32_t of_groups = as_cluster ? found(longest) + found(longer) : found(shorter);
    return value(groups.begun) + value(groups.done) > of_groups + 1;
  }

  /// Takes the next item of a queue; null: there is none, or it is not written yet.
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
        return items + first[q] + next;
      }
    }
    return nullptr;
  }
};

}  // namespace swiftgs::kernels
