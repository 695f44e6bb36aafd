// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <cooperative_groups.h>

#include "raster_warps.cuh"

namespace swiftgs {

namespace kernels {

/// Warps of a block that share a long part, each a piece of its list at a time.
inline constexpr unsigned piece_warps = 8, piece_threads = piece_warps * warp_size;
/// Blocks of a cluster, which share a longer one.
inline constexpr unsigned piece_blocks = 8;
/// Blocks that a multiprocessor holds: 64 registers a thread.
template <bool extras>
inline constexpr unsigned piece_occupancy = extras ? 2 : 4;
/// Splats that a block blends in a round.
inline constexpr std::uint32_t round_of_block = piece_warps * piece_size;
/// Instances that a thread tests at once, and a block.
inline constexpr unsigned tests_of_thread = 4, tests_of_block = tests_of_thread * piece_threads;
static_assert(tests_of_block <= round_of_block, "what a round leaves over fits the next");
static_assert(tests_of_thread * piece_warps == warp_size, "a warp adds up what all have found");

/// The blocks that share a long part: one, or those of a cluster.
struct Group {
  unsigned rank = 0, blocks = 1;

#if __CUDA_ARCH__ >= 900
  __device__ static Group cluster() {
    const auto all = cooperative_groups::this_cluster();
    return {all.block_rank(), all.num_blocks()};
  }
#endif

  __device__ void sync() const {
#if __CUDA_ARCH__ >= 900
    if (blocks != 1) {
      cooperative_groups::this_cluster().sync();
      return;
    }
#endif
    __syncthreads();
  }

  /// `mine` in the shared memory of block `block`.
  template <class T>
  __device__ T& in(unsigned block, T& mine) const {
#if __CUDA_ARCH__ >= 900
    if (blocks != 1) return *cooperative_groups::this_cluster().map_shared_rank(&mine, block);
#endif
    return mine;
  }
};

/// Shared memory of a block.
template <class Form, bool extras>
struct PieceShared {
  Queue<Form> queues[piece_warps];
  std::uint32_t ticket;
  std::uint32_t ids[2][round_of_block];    ///< splats of this block's pieces, in this round and the next
  std::uint32_t touched[warp_size];        ///< splats that touch the part, of each 32 that the block tests
  std::uint32_t touched_of[piece_blocks];  ///< of those that each block tests
  float4 pieces[piece_warps][pixels_of_part];  ///< RGB and `mark_stopped` transmittance of each piece
  float depths[extras ? piece_warps : 1][pixels_of_part];
  JoinedPart<extras> joined;
  unsigned live[pixels_of_lane];
};

/// Finds the splats that touch a part, by all threads of a group, in the order of the list.
struct TouchedSplats {
  std::uint32_t at, end;    ///< instances that are not tested yet
  std::uint32_t skip;       ///< of the next that touch
  std::uint32_t count = 0;  ///< found, and not blended yet
  unsigned parity = 0;      ///< of this round's ids

  /// Finds splats until there are enough for a round, or the list ends. Every block gets those of its pieces.
  template <class Shared>
  __device__ void fill(const RasterJob& job, vec2 first_centre, const Group& group, Shared& shared) {
    const bool some_hidden = job.colours.some_hidden();
    const unsigned warp = threadIdx.x / warp_size;
    const std::uint32_t round = group.blocks * round_of_block;
    while (count < round && at < end) {
      // Test.
      const std::uint32_t first =
          at + (group.rank * piece_warps + warp) * tests_of_thread * warp_size + lane_index();
      std::uint32_t ids[tests_of_thread];
      unsigned lanes[tests_of_thread];
#pragma unroll
      for (unsigned k = 0; k < tests_of_thread; ++k) {
        const std::uint32_t position = first + k * warp_size;
        ids[k] = position < end ? job.lists.ids[position] : 0;
      }
#pragma unroll
      for (unsigned k = 0; k < tests_of_thread; ++k) {
        const SplatShape shape = load_shape(job, ids[k]);
        bool touched = first + k * warp_size < end && box_touched(shape, first_centre, float(part_side));
        if (some_hidden) touched = touched && !is_hidden(job.colours.each[ids[k]]);
        lanes[k] = __ballot_sync(whole_warp, touched);
        if (lane_index() == 0) shared.touched[warp * tests_of_thread + k] = std::uint32_t(__popc(lanes[k]));
      }
      __syncthreads();

      // Count those before each 32.
      const std::uint32_t mine = shared.touched[lane_index()], before = sum_below(mine);
      std::uint32_t found = __shfl_sync(whole_warp, before + mine, warp_size - 1), before_block = 0;
      if (group.blocks != 1) {
        if (threadIdx.x < group.blocks) group.in(threadIdx.x, shared).touched_of[group.rank] = found;
        group.sync();
        found = 0;
        for (unsigned b = 0; b < group.blocks; ++b) {
          if (b == group.rank) before_block = found;
          found += shared.touched_of[b];
        }
      }

      // Give each to the block that blends it.
#pragma unroll
      for (unsigned k = 0; k < tests_of_thread; ++k) {
        const std::uint32_t before_warp = __shfl_sync(whole_warp, before, int(warp * tests_of_thread + k));
        const std::uint32_t nth =
            before_block + before_warp + std::uint32_t(__popc(lanes[k] & lanes_below()));
        if (!(lanes[k] >> lane_index() & 1) || nth < skip) continue;
        std::uint32_t place = count + nth - skip;
        const unsigned next = place >= round;
        if (next) place -= round;
        group.in(place / round_of_block, shared).ids[parity ^ next][place % round_of_block] = ids[k];
      }
      count += found - min(skip, found), skip -= min(skip, found);
      at += min(group.blocks * tests_of_block, end - at);
      group.sync();
    }
  }

  /// Leaves the round behind. Whether there may be another.
  __device__ bool next_round(const Group& group) {
    count -= min(group.blocks * round_of_block, count), parity ^= 1;
    return count != 0 || at < end;
  }
};

/// The rest of a long part, blended by a group of blocks in rounds: a warp a piece of the list.
template <class Form, bool threshold, bool extras, class ViewSource>
struct LongPartBlender {
  using Shared = PieceShared<Form, extras>;
  using Blender = ColourBlender<Form, threshold, extras>;
  const RasterInput<ViewSource>& input;
  const Group group;
  Shared& shared;
  const BlockSquare square;
  const View& view;
  const BlendRules rules;
  const PartPlace place;
  const vec2 first_centre;
  std::uint32_t blended = 0, blended_pieces = 0;  ///< splats and pieces of this warp
  std::uint32_t pixels_joined = 0;                ///< of this lane
  ThreadCounts counts;

  __device__ LongPartBlender(const RasterInput<ViewSource>& of, const LongPart& part, const Group& by,
                             Shared& in)
      : input(of),
        group(by),
        shared(in),
        square(of, part.column, part.row),
        view(of.views[square.view]),
        rules(view.rules),
        place(square, part.part),
        first_centre(place.first_centre(view)) {}

  __device__ static unsigned warp() { return threadIdx.x / warp_size; }
  /// Of all warps of the group.
  __device__ unsigned piece() const { return group.rank * piece_warps + warp(); }

  __device__ void run(const LongPart& part, const LongWork& work) {
    const TileRange range = square.list(input);
    if (threadIdx.x < pixels_of_part) shared.joined.store(threadIdx.x, part.joined.load(threadIdx.x));
    if (threadIdx.x < pixels_of_lane) shared.live[threadIdx.x] = part.live[threadIdx.x];
    Blender blender{input.job,
                    rules,
                    shared.queues[warp()],
                    shared.joined,
                    work,
                    float(place.column),
                    float(place.row),
                    {},
                    {},
                    {}};
    if constexpr (extras)
      for (unsigned p = 0; p < pixels_of_lane; ++p)
        blender.occluders[p] = place.pixel(view.frame, p, true).occluder;
    __syncthreads();

    TouchedSplats splats{part.at.position, range.end, part.at.skipped};
    std::uint32_t first_piece = part.pieces;
    do {
      splats.fill(input.job, first_centre, group, shared);
      const std::uint32_t count = min(splats.count, group.blocks * round_of_block);
      if (count == 0) break;
      blend_round(blender, shared.ids[splats.parity] + warp() * piece_size, count, first_piece);
      first_piece += group.blocks * piece_warps;
    } while ((shared.live[0] | shared.live[1]) != 0 && splats.next_round(group));

    if (group.rank == 0 && warp() < pixels_of_lane) {
      const PixelPlace pixel = place.pixel(view.frame, warp(), false);
      if (pixel.inside)
        store_pixel(view.frame, std::size_t(pixel.x), std::size_t(pixel.y),
                    shared.joined.load(pixel_of_part(warp())).blended(), view.background);
    }
    if constexpr (extras)
      if (input.job.counts) {
        SquareCounts of_warp = counts_of_warp(counts, splats.at - range.begin, blended * pixels_of_part);
        of_warp.pieces = blended_pieces, of_warp.pixels_joined = warp_sum(pixels_joined);
        of_warp.longest_item = (splats.at - part.at.position) / group.blocks;
        add_counts(input.job.counts[part.row * input.squares.columns + part.column], of_warp);
      }
  }

 private:
  /// Blends the `count` splats of a round, which begins with piece `base`. `ids` are this warp's splats.
  __device__ void blend_round(Blender& blender, const std::uint32_t* ids, std::uint32_t count,
                              std::uint32_t base) {
    const unsigned pieces = (count + piece_size - 1) / piece_size;
    const std::uint32_t mine = piece() < pieces ? min(count - piece() * piece_size, piece_size) : 0;

    // By the transmittance before the round: a pixel that stops by it stops in this piece or an earlier one.
    float befores[pixels_of_lane];
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p)
      befores[p] =
          shared.live[p] >> lane_index() & 1 ? first_before(shared.joined.totals[pixel_of_part(p)].w) : -1;
    if (mine != 0) blend_piece(blender, ids, mine, befores, base);
    group.sync();

    // By the true transmittance before the piece: blend again where a pixel stops in it.
    const bool again = find_befores(pieces, mine != 0, befores, base);
    group.sync();
    if (again) blend_piece(blender, ids, mine, befores, base);
    if constexpr (extras) {
      blended_pieces += mine != 0;
      for (unsigned p = 0; p < pixels_of_lane; ++p) {
        if (mine == 0 || befores[p] < 0) continue;
        counts.pairs += blender.counts[p].pairs, counts.stopped += blender.counts[p].stopped;
        ++pixels_joined;
      }
    }
    group.sync();
    join(pieces, base);
    group.sync();
  }

  /// What the first blending takes for the transmittance before this warp's piece. Of the first piece it is
  /// known.
  __device__ float first_before(float before_round) const {
    return piece() == 0 ? before_round : most_before(before_round);
  }

  /// Blends this warp's piece of pixels that have the transmittances `befores` in front of it; negative: they
  /// have stopped.
  __device__ void blend_piece(Blender& blender, const std::uint32_t* ids, std::uint32_t count,
                              const float (&befores)[pixels_of_lane], std::uint32_t base) {
    Queue<Form>& queue = blender.queue;
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      blender.pixels[p] = {}, blender.counts[p] = {};
      if (befores[p] >= 0) start_piece(blender.pixels[p], rules.stop_below, befores[p], base + piece());
    }

    // Queue a half while the other is blended, and load the shapes of the next.
    std::uint32_t id = lane_index() < count ? ids[lane_index()] : 0;
    SplatShape shape = load_shape(input.job, id);
    const auto queue_from = [&](std::uint32_t k) {
      if (k + lane_index() < count) {
        const unsigned slot = k % queue_size + lane_index();
        blender.fill(slot, id);
        Form::prepare(shape, shape.mean - first_centre, rules.log2_alpha_min, queue.terms[slot],
                      queue.rests[slot]);
      }
      __pipeline_commit();
      const std::uint32_t next = k + queue_half + lane_index();
      id = next < count ? ids[next] : 0;
      shape = load_shape(input.job, id);
    };
    queue_from(0);
#pragma unroll 1
    for (std::uint32_t k = 0; k < count; k += queue_half) {
      if (k + queue_half < count) {
        queue_from(k + queue_half);
        __pipeline_wait_prior(1);
      } else {
        __pipeline_wait_prior(0);
      }
      __syncwarp();
      const std::uint32_t size = min(count - k, queue_half);
      blender.blend_queued(k % queue_size, size);
      if constexpr (extras) blended += size;
      if (blender.all_stopped()) break;
    }
    __pipeline_wait_prior(0);

#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      const BlendedPixel pixel = blender.pixels[p].blended();
      const bool stopped = befores[p] >= 0 && !blender.pixels[p].live();
      shared.pieces[warp()][pixel_of_part(p)] = make_float4(pixel.colour.x, pixel.colour.y, pixel.colour.z,
                                                            mark_stopped(pixel.transmittance, stopped));
      if constexpr (extras) shared.depths[warp()][pixel_of_part(p)] = pixel.depth;
    }
  }

  /// Replaces `befores` by the true transmittances before this warp's piece, if there is one. Whether a pixel
  /// stops in the piece that its warp has blended with others.
  __device__ bool find_befores(unsigned pieces, bool any, float (&befores)[pixels_of_lane],
                               std::uint32_t base) {
    // Nothing is queued now, and the queues have room for the transmittances of all pieces.
    float(*const lefts)[pixels_of_part] = reinterpret_cast<float(*)[pixels_of_part]>(shared.queues);
    static_assert(piece_blocks * piece_warps * sizeof *lefts <= sizeof shared.queues);
#pragma unroll 4
    for (unsigned i = threadIdx.x; i < pieces * pixels_of_part; i += piece_threads) {
      const unsigned k = i / pixels_of_part, pixel = i % pixels_of_part;
      lefts[k][pixel] = group.in(k / piece_warps, shared).pieces[k % piece_warps][pixel].w;
    }
    __syncthreads();
    if (!any || piece() == 0) return false;

    bool again = false;
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      float before = shared.joined.totals[pixel_of_part(p)].w;
      bool live = befores[p] >= 0;
#pragma unroll 4
      for (unsigned k = 0; k < piece(); ++k) {
        const float left = lefts[k][pixel_of_part(p)];
        live = live && !stops_in_piece(left, rules.stop_below, before, base + k);
        before = before * scale_of_piece(base + k) * fabsf(left);
      }
      befores[p] = live ? before : -1;
      again = again || (live && stops_in_piece(lefts[piece()][pixel_of_part(p)], rules.stop_below, before,
                                               base + piece()));
    }
    return __any_sync(whole_warp, again);
  }

  /// Joins the pieces of a round in order. Each block joins some pixels for all, a thread a channel of one.
  __device__ void join(unsigned pieces, std::uint32_t base) {
    constexpr unsigned channels = 4;
    const unsigned of_block = channels * pixels_of_part / group.blocks;
    if (threadIdx.x >= of_block) return;
    const unsigned at = group.rank * of_block + threadIdx.x, pixel = at / channels, channel = at % channels;
    const unsigned p = pixel / warp_size, lane = pixel % warp_size;
    const bool was_live = shared.live[p] >> lane & 1;
    bool live = was_live;
    float before = shared.joined.totals[pixel].w;
    float all = (&shared.joined.totals[pixel].x)[channel];
    float depth = extras ? shared.joined.depths[pixel] : 0;
#pragma unroll 4
    for (unsigned k = 0; k < pieces; ++k) {
      const Shared& of = group.in(k / piece_warps, shared);
      const float4& piece = of.pieces[k % piece_warps][pixel];
      const float left = piece.w, value = (&piece.x)[channel];
      const float of_depth = extras ? of.depths[k % piece_warps][pixel] : 0;
      if (!live) continue;
      // As `JoinedPixel::join`.
      const float scaled = before * scale_of_piece(base + k);
      all = fmaf(scaled, value, all), depth = fmaf(scaled, of_depth, depth);
      before = scaled * fabsf(left), live = !signbit(left);
    }
    __syncwarp();  // all have read what is overwritten
    for (unsigned b = 0; was_live && b < group.blocks; ++b) {
      Shared& of = group.in(b, shared);
      (&of.joined.totals[pixel].x)[channel] = channel + 1 == channels ? before : all;
      if (extras && channel == 0) of.joined.depths[pixel] = depth;
      if (channel == 0 && !live) atomicAnd(&of.live[p], ~(1u << lane));
    }
  }
};

/// Goes on with long parts: clusters with the longest, and then each block by itself. Parts are taken up as
/// blocks become free.
template <class Form, bool threshold, bool extras, class ViewSource>
__global__ void __launch_bounds__(piece_threads, piece_occupancy<extras>)
    raster_pieces(const __grid_constant__ RasterInput<ViewSource> input,
                  const __grid_constant__ LongWork work) {
  await_earlier();
  __shared__ PieceShared<Form, extras> shared;
  using Blender = LongPartBlender<Form, threshold, extras, ViewSource>;
  const std::uint32_t of_clusters = work.of_clusters.capacity ? work.of_clusters.size() : 0;
  const std::uint32_t of_blocks = work.of_blocks.size();
  if (of_clusters == 0 && of_blocks == 0) return;
#if __CUDA_ARCH__ >= 900
  const Group cluster = Group::cluster();
  while (of_clusters != 0) {
    cluster.sync();  // all have started, and read the ticket before
    if (cluster.rank == 0 && threadIdx.x == 0) {
      const std::uint32_t ticket = atomicAdd(&work.of_clusters.counts->taken, 1u);
      for (unsigned b = 0; b < cluster.blocks; ++b) cluster.in(b, shared).ticket = ticket;
    }
    cluster.sync();
    const std::uint32_t ticket = shared.ticket;
    if (ticket >= of_clusters) break;
    const LongPart& part = work.of_clusters.parts[ticket];
    Blender(input, part, cluster, shared).run(part, work);
  }
#endif
  for (;;) {
    __syncthreads();
    if (threadIdx.x == 0) shared.ticket = atomicAdd(&work.of_blocks.counts->taken, 1u);
    __syncthreads();
    const std::uint32_t ticket = shared.ticket;
    if (ticket >= of_blocks) {
      // The last block leaves zeros for the next frame: all others have read the counts.
      if (threadIdx.x == 0 && ticket == of_blocks + gridDim.x - 1) {
        *work.of_blocks.counts = {};
        if (work.of_clusters.capacity) *work.of_clusters.counts = {};
      }
      return;
    }
    const LongPart& part = work.of_blocks.parts[ticket];
    Blender(input, part, Group{}, shared).run(part, work);
  }
}
}  // namespace kernels

/// Rasterizes with terms of `Form` in registers.
template <class Form, bool threshold>
void rasterize_warps(Cuda& cuda, const char* name, const RasterJob& job) {
  using namespace kernels;
  with_squares(cuda, job, [&]<bool extras, class ViewSource>(const RasterInput<ViewSource>& input) {
    const LongWork work = LongWork::of(cuda, input.squares.size() * parts_of_square);
    launch(name, raster_warps<Form, threshold, extras, ViewSource>, blocks_of(input.squares), raster_threads,
           cuda.stream(), input, work);
    const unsigned clusters = unsigned(cuda.multiprocessors()) * piece_occupancy<extras> / piece_blocks;
    try {
      launch_clusters(cuda, name, raster_pieces<Form, threshold, extras, ViewSource>,
                      std::max(clusters, 1u) * piece_blocks, piece_threads, piece_blocks, input, work);
    } catch (const DeviceError&) {
      work.forget(cuda);  // or the next frame would go on with this one's parts
      throw;
    }
  });
}

}  // namespace swiftgs
