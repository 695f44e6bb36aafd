// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <cuda/atomic>

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

/// A part at the end of a piece, or within the first.
struct LongPart {
  JoinedPart<true> joined;        ///< pixels behind all splats that are blended
  unsigned live[pixels_of_lane];  ///< lanes whose pixel has not stopped
  std::uint32_t pieces;           ///< so far
  std::uint32_t blended;          ///< splats
  std::uint32_t column, row;      ///< of its square
  std::uint32_t part;             ///< of the square
  ResumeAt at;
};

/// A walk is long that has blended so many splats, or visited so many instances; if enough instances are left
/// for others to gain on it.
inline constexpr std::uint32_t long_blended = 2048, long_visited = 4096, left_for_block = 2048;
/// Clusters of blocks take up the longest.
inline constexpr std::uint32_t left_of_longest = 16384;

/// More long parts than this keep a device busy without help.
inline constexpr std::size_t most_long_parts = 7168, most_longest_parts = 1024;

/// The long parts of a frame: two queues, which warps fill while blocks empty them.
struct LongParts {
  struct Counts {
    std::uint32_t found;  ///< handed over
    std::uint32_t taken;
  };
  /// Zero between frames.
  struct State {
    Counts longest, others;
    std::uint32_t complete;  ///< not 0: no more will be handed over
    std::uint32_t begun;     ///< blocks
    std::uint32_t left;      ///< blocks that are done
  };
  LongPart* parts;       ///< the longest, then the others
  std::uint32_t* ready;  ///< of each part: not 0 after it is written and until it is taken
  State* state;
  std::uint32_t most_longest, most_others;

  /// Bytes before the parts. The same for all frames, which leave zeros in them.
  static constexpr std::size_t head = 32 + (most_longest_parts + most_long_parts) * sizeof(std::uint32_t);
  static_assert(sizeof(State) <= 32 && head % 16 == 0 && sizeof(LongPart) % 16 == 0);

  /// In memory of `cuda`, for a frame of so many parts.
  static LongParts of(Cuda& cuda, std::size_t parts) {
    const std::size_t longest = kernels_await_earlier ? std::min(parts, most_longest_parts) : 0;
    const std::size_t others = std::min(parts, most_long_parts);
    std::byte* const memory = cuda.raster_scratch(head + (longest + others) * sizeof(LongPart));
    return {reinterpret_cast<LongPart*>(memory + head), reinterpret_cast<std::uint32_t*>(memory + 32),
            reinterpret_cast<State*>(memory), std::uint32_t(longest), std::uint32_t(others)};
  }

  /// Has the next frame begin without parts.
  void forget(Cuda& cuda) const { cuda.clear(state, head); }

  /// Room for a part of whose list so many instances are left, for a warp; null: others would not gain on it,
  /// or there is none.
  __device__ LongPart* take_room(std::uint32_t instances_left) const {
    if (instances_left < left_for_block) return nullptr;
    const bool of_longest = instances_left >= left_of_longest && most_longest != 0;
    std::uint32_t slot = 0;
    if (lane_index() == 0) slot = atomicAdd(&(of_longest ? state->longest : state->others).found, 1u);
    slot = __shfl_sync(whole_warp, slot, 0);
    if (slot >= (of_longest ? most_longest : most_others)) return nullptr;
    return parts + (of_longest ? 0 : most_longest) + slot;
  }

  /// Publishes a part that this warp has written: from now on a block may take it.
  __device__ void hand_over(const LongPart* part) const {
    __syncwarp();
    if (lane_index() == 0) word(ready[part - parts]).store(1, cuda::memory_order_release);
  }

  /// For one thread of each block, before it asks for parts. That of the first block waits for the end of the
  /// kernel that fills the queues, and so no block ends before.
  __device__ void begin() const {
    if (word(state->begun).fetch_add(1, cuda::memory_order_relaxed) != 0) return;
    await_earlier();
    word(state->complete).store(1, cuda::memory_order_release);
  }

  /// Waits for the next part of a queue, for one thread; null: there will be none.
  __device__ const LongPart* await_next(bool of_longest) const {
    Counts& counts = of_longest ? state->longest : state->others;
    const std::uint32_t first = of_longest ? 0 : most_longest, most = of_longest ? most_longest : most_others;
    for (;;) {
      const bool last = word(state->complete).load(cuda::memory_order_acquire) != 0;
      std::uint32_t next = word(counts.taken).load(cuda::memory_order_relaxed);
      if (next >= min(word(counts.found).load(cuda::memory_order_relaxed), most)) {
        if (last) return nullptr;
      } else if (word(ready[first + next]).load(cuda::memory_order_acquire) != 0) {
        if (!word(counts.taken).compare_exchange_strong(next, next + 1, cuda::memory_order_relaxed)) continue;
        ready[first + next] = 0;
        return parts + first + next;
      }
      __nanosleep(100);
    }
  }

  /// For one thread of each block, which asks for nothing more. The last leaves zeros for the next frame.
  __device__ void leave() const {
    if (word(state->left).fetch_add(1, cuda::memory_order_acq_rel) == gridDim.x - 1) *state = {};
  }

 private:
  using Word = cuda::atomic_ref<std::uint32_t, cuda::thread_scope_device>;
  __device__ static Word word(std::uint32_t& value) { return Word(value); }
};

}  // namespace swiftgs::kernels
