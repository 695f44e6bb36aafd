// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "group.cuh"
#include "raster_warps.cuh"
#include "touched_splats.cuh"

namespace swiftgs {

namespace kernels {

/// Warps of a block that shares out the rest of a long part.
inline constexpr unsigned segment_warps = 8, segment_threads = segment_warps * warp_size;
/// Blocks that a multiprocessor can hold.
template <bool extras>
inline constexpr unsigned segment_occupancy = extras ? 2 : 3;
/// Blocks for each multiprocessor: one more is no faster where lists are long, and starts later where they
/// are not.
inline constexpr unsigned blocks_of_multiprocessor = 2;
/// Segments that a warp blends at once, where few pixels are left.
inline constexpr unsigned most_segments_of_warp = 2;
/// Pixels of segments that a block blends in a round.
inline constexpr unsigned pixels_of_round = segment_warps * pixels_of_warp_block;

using SegmentSplats = TouchedSplats<segment_warps, segment_warps * segment_size,
                                    segment_warps * most_segments_of_warp * segment_size>;

/// Shared memory of a block.
template <class Exponent, bool extras>
struct SegmentShared {
  Queue<Exponent> queues[segment_warps];
  SegmentSplats::Shared splats;
  float4 segments[pixels_of_round];  ///< RGB and `mark_stopped` transmittance; indexed by segment, then slot
  float depths[extras ? pixels_of_round : 1];
  JoinedWarpBlock<extras> joined;
  unsigned live[pixels_of_lane];  ///< pixels that have not stopped
  std::uint32_t pixel_of_slot[pixels_of_warp_block];
  const WorkItem* part;
};

/// A round of a long part, in which each warp blends one segment, or some at once. Where more than half of
/// the part's pixels are left, each pixel has a slot, and a lane two of them. Else those that are left have
/// the first slots, and a lane one of them. Where they are few, lanes that this frees blend further segments.
struct Round {
  unsigned blocks;            ///< of the group
  unsigned live;              ///< pixels left
  unsigned slots;             ///< 64, 32 or 16
  unsigned segments_of_warp;  ///< at once
  std::uint32_t first;        ///< segment, of those of the part
  std::uint32_t splats = 0;

  __device__ Round(unsigned blocks_, unsigned live_, std::uint32_t first_)
      : blocks(blocks_), live(live_), first(first_) {
    slots = live > 32 ? 64 : live > 16 || blocks != 1 ? 32 : 16;
    segments_of_warp = slots == 16 ? most_segments_of_warp : 1;
  }

  __device__ unsigned segments_of_block() const { return segment_warps * segments_of_warp; }
  __device__ std::uint32_t most_splats() const { return blocks * segments_of_block() * segment_size; }
  __device__ unsigned segments() const { return (splats + segment_size - 1) / segment_size; }
  __device__ std::uint32_t splats_of(unsigned segment) const {
    const std::uint32_t before = segment * segment_size;
    return before < splats ? min(splats - before, segment_size) : 0;
  }
};

/// The rest of a long part, blended by a block in rounds.
template <class Exponent, bool threshold, bool extras, class ViewSource>
struct WorkItemBlender {
  const RasterInput<ViewSource>& input;
  const Group group;
  SegmentShared<Exponent, extras>& shared;
  const OwnRasterBlock raster_block;
  const View& view;
  const BlendRules rules;
  const WarpBlockPlace place;
  const vec2 first_centre;
  std::uint32_t evaluated = 0;                           ///< pixels, by this warp
  std::uint32_t segments_joined = 0, pixels_joined = 0;  ///< of this lane
  ThreadCounts counts;

  __device__ WorkItemBlender(const RasterInput<ViewSource>& of, const WorkItem& part, const Group& by,
                             SegmentShared<Exponent, extras>& in)
      : input(of),
        group(by),
        shared(in),
        raster_block(of, part.raster_block),
        view(of.views[raster_block.view]),
        rules(view.rules),
        place(raster_block, part.part),
        first_centre(place.first_centre(view)) {}

  __device__ static unsigned warp() { return threadIdx.x / warp_size; }

  /// `timer`: began with the work on the part.
  __device__ void run(const WorkItem& part, const WarpTimer& timer) {
    const TileRange range = raster_block.list(input);
    if (threadIdx.x < pixels_of_warp_block) shared.joined.store(threadIdx.x, part.joined.load(threadIdx.x));
    if (threadIdx.x < pixels_of_lane) shared.live[threadIdx.x] = part.live[threadIdx.x];
    __syncthreads();

    ResumeAt next = part.at;
    if (part.segments == 0) next = end_first_segment(next, range.end, first_segment_size - part.blended);
    group.sync();

    SegmentSplats splats(shared.splats, input.job, group, next, range.end);
    std::uint32_t segment = max(part.segments, 1u);
    for (;;) {
      Round round(group.blocks, unsigned(__popc(shared.live[0]) + __popc(shared.live[1])), segment);
      if (round.live == 0) break;
      give_slots();
      splats.find(first_centre, round.most_splats());
      round.splats = min(splats.count(), round.most_splats());
      if (round.splats == 0) break;
      if (round.slots == pixels_of_warp_block)
        blend_round<pixels_of_lane>(splats, round);
      else
        blend_round<1>(splats, round);
      splats.drop(round.splats), segment += round.segments();
    }

    if (group.rank == 0 && warp() < pixels_of_lane) {
      const JoinedPixel pixel = shared.joined.load(pixel_of_warp_block(warp()));
      store_relative(view, place.pixel(view.frame, warp(), false), pixel.blended());
    }
    if constexpr (extras)
      if (input.job.counts) {
        RasterCounts of_warp = counts_of_warp(counts, splats.position() - range.begin, evaluated, timer);
        of_warp.segments = warp_sum(segments_joined), of_warp.pixels_joined = warp_sum(pixels_joined);
        of_warp.longest_item = (splats.position() - part.at.position) / group.blocks;
        add_counts(input.job.counts[part.raster_block.number(input.raster_blocks.columns)], of_warp);
      }
  }

 private:
  /// Blends the rest of the first segment, `most` splats or fewer, with one warp. Every block of the group
  /// does the same. Returns where the next segment begins.
  __device__ ResumeAt end_first_segment(ResumeAt from, std::uint32_t end, std::uint32_t most) {
    SegmentSplats splats(shared.splats, input.job, Group(), from, end);
    splats.find(first_centre, most);
    const std::uint32_t count = min(splats.count(), most);
    if (warp() == 0) {
      const Share share(Round(1, pixels_of_warp_block, 0), 0);
      LaneBlender<Exponent, threshold, extras, pixels_of_lane> lane{
          rules, float(place.column), float(place.row), 0, {}, {}, {}};
#pragma unroll
      for (unsigned p = 0; p < pixels_of_lane; ++p) {
        const JoinedPixel from = shared.joined.load(pixel_of_warp_block(p));
        lane.pixels[p] = from.stopped();
        if (shared.live[p] >> lane_index() & 1) lane.pixels[p].start(rules.stop_below, from.total.w);
        if constexpr (extras) lane.occluders[p] = place.pixel(view.frame, p, true).occluder;
      }
      __syncwarp();
      blend_splats(lane, splats, 0, count, count, share);
      if (group.rank != 0) evaluated = 0;  // the first block counts for all
#pragma unroll
      for (unsigned p = 0; p < pixels_of_lane; ++p) {
        JoinedPixel all;
        all.join(lane.pixels[p].blended(), 0);
        shared.joined.store(pixel_of_warp_block(p), all);
        const unsigned live = __ballot_sync(whole_warp, lane.pixels[p].live());
        if (lane_index() == 0) shared.live[p] = live;
        if constexpr (extras)
          if (group.rank == 0) counts.pairs += lane.counts[p].pairs, counts.stopped += lane.counts[p].stopped;
      }
    }
    splats.drop(count);
    __syncthreads();
    return splats.next();
  }

  /// Gives the first slots to the pixels that are left. The block synchronises before it reads them.
  __device__ void give_slots() {
    if (threadIdx.x >= pixels_of_warp_block) return;
    const unsigned p = threadIdx.x / warp_size;
    if (!(shared.live[p] >> lane_index() & 1)) return;
    const int slot = __popc(shared.live[p] & lanes_below()) + (p == 1 ? __popc(shared.live[0]) : 0);
    shared.pixel_of_slot[slot] = threadIdx.x;
  }

  /// What a lane blends in a round: slot `slot` of a segment and, if it has two pixels, `slot` + 32.
  struct Share {
    unsigned lanes;          ///< of a segment; each queues one of its splats at a time
    unsigned segment, slot;  ///< the segment of those of the group
    unsigned own;            ///< the segment of those of the block

    __device__ Share(const Round& round, unsigned rank)
        : lanes(warp_size / round.segments_of_warp), slot(lane_index() % lanes) {
      own = warp() * round.segments_of_warp + lane_index() / lanes;
      segment = rank * round.segments_of_block() + own;
    }
  };

  /// Whether the pixel in a slot is left.
  template <unsigned pixel_count>
  __device__ bool is_live(const Round& round, unsigned slot) const {
    return pixel_count == 1 ? slot < round.live : shared.live[slot / warp_size] >> slot % warp_size & 1;
  }
  /// The pixel in a slot, if it is left.
  template <unsigned pixel_count>
  __device__ unsigned pixel_in(unsigned slot, bool live) const {
    return pixel_count == 1 && live ? shared.pixel_of_slot[slot] : slot;
  }

  template <unsigned pixel_count>
  __device__ void blend_round(const SegmentSplats& splats, const Round& round) {
    const Share share(round, group.rank);
    LaneBlender<Exponent, threshold, extras, pixel_count> lane{rules, 0, 0, 0, {}, {}, {}};
    float befores[pixel_count];  // transmittances in front of the segment; negative: no pixel, or stopped
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) {
      const unsigned slot = share.slot + p * warp_size;
      const bool live = is_live<pixel_count>(round, slot);
      const unsigned pixel = pixel_in<pixel_count>(slot, live);
      const PlaceInWarpBlock at(pixel);
      if (p == 0) {
        const unsigned first = at.column % columns_between;
        lane.x = float(first), lane.right = float(at.column - first), lane.y = float(at.row);
      }
      // A pixel that stops by the transmittance before the round stops in this segment or an earlier one.
      const float before = shared.joined.totals[pixel].w;
      befores[p] = !live ? -1 : share.segment == 0 ? before : most_before(before);
      if constexpr (extras)
        lane.occluders[p] =
            PixelPlace(view.frame, place.x + int(at.column), place.y + int(at.row), true).occluder;
    }
    const unsigned first_of_warp = group.rank * round.segments_of_block() + warp() * round.segments_of_warp;
    const std::uint32_t most = round.splats_of(first_of_warp);
    if (most != 0) blend_segments(lane, splats, round, share, most, befores);
    group.sync();

    // By the true transmittance before the segment: blend again where a pixel stops in it.
    gather_transmittances(round);
    const bool again = find_befores(round, share, befores);
    if (__syncthreads_or(again)) {
      if (again) blend_segments(lane, splats, round, share, most, befores);
      if (group.blocks == 1) __syncthreads();
    }
    if (group.blocks != 1) group.sync();
    if constexpr (extras)
      if (share.segment < round.segments()) {
        segments_joined += share.slot == 0;
        for (unsigned p = 0; p < pixel_count; ++p) {
          if (befores[p] < 0) continue;
          counts.pairs += lane.counts[p].pairs, counts.stopped += lane.counts[p].stopped;
          ++pixels_joined;
        }
      }
    join<pixel_count>(round);
    group.sync();
  }

  /// Blends this warp's segments, of pixels that have the transmittances `befores` in front of them.
  template <unsigned pixel_count>
  __device__ void blend_segments(LaneBlender<Exponent, threshold, extras, pixel_count>& lane,
                                 const SegmentSplats& splats, const Round& round, const Share& share,
                                 std::uint32_t most, const float (&befores)[pixel_count]) {
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) {
      lane.pixels[p] = {}, lane.counts[p] = {};
      if (befores[p] >= 0)
        start_segment(lane.pixels[p], rules.stop_below, befores[p], round.first + share.segment);
    }

    blend_splats(lane, splats, share.own * segment_size, round.splats_of(share.segment), most, share);

#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) {
      const BlendedPixel pixel = lane.pixels[p].blended();
      const bool stopped = befores[p] >= 0 && !lane.pixels[p].live();
      const unsigned at = share.own * round.slots + share.slot + p * warp_size;
      shared.segments[at] = make_float4(pixel.colour.x, pixel.colour.y, pixel.colour.z,
                                        mark_stopped(pixel.transmittance, stopped));
      if constexpr (extras) shared.depths[at] = pixel.depth;
    }
  }

  /// Blends the `count` splats of a lane's segment, from the first-th on that were found. No segment of the
  /// warp has more than `most`.
  template <unsigned pixel_count>
  __device__ void blend_splats(LaneBlender<Exponent, threshold, extras, pixel_count>& lane,
                               const SegmentSplats& splats, std::uint32_t first, std::uint32_t count,
                               std::uint32_t most, const Share& share) {
    // Queue a half while the other is blended, and load the shapes of the next. Each lane queues for its own
    // segment; behind the end of a segment, splats that show nothing.
    Queue<Exponent>& queue = shared.queues[warp()];
    std::uint32_t id = share.slot < count ? splats.id(first + share.slot) : 0;
    SplatShape shape = load_shape(input.job, id);
    unsigned half = 0;
    const auto queue_from = [&](std::uint32_t k) {
      const unsigned slot = half + lane_index();
      if (k + share.slot < count) {
        fetch_colour(input.job, queue, slot, id);
        Exponent::prepare(shape, shape.mean - first_centre, rules, queue.terms[slot], queue.rests[slot]);
      } else {
        Exponent::clear(queue.terms[slot], queue.rests[slot]);
        queue.colours[slot] = make_float4(0, 0, 0, 0);
      }
      __pipeline_commit();
      k += share.lanes;
      id = k + share.slot < count ? splats.id(first + k + share.slot) : 0;
      shape = load_shape(input.job, id);
      half ^= queue_half;
    };
    queue_from(0);
#pragma unroll 1
    for (std::uint32_t k = 0; k < most; k += share.lanes) {
      const unsigned queued = (half ^ queue_half) + lane_index() - share.slot;
      if (k + share.lanes < most) {
        queue_from(k + share.lanes);
        __pipeline_wait_prior(1);
      } else {
        __pipeline_wait_prior(0);
      }
      __syncwarp();
      const std::uint32_t size = min(most - k, share.lanes);
      lane.blend_queued(queue, queued, (size + group_size - 1) / group_size * group_size);
      if constexpr (extras) evaluated += size * pixel_count * warp_size;
      __syncwarp();
      if (lane.all_stopped()) break;
    }
    __pipeline_wait_prior(0);
  }

  /// Transmittances of all segments of a round in one place. A block alone has them there.
  __device__ void gather_transmittances(const Round& round) {
    if (group.blocks == 1) return;
    // Nothing is queued now, and the queues have room for them.
    static_assert(blocks_of_group * pixels_of_round * sizeof(float) <= sizeof shared.queues);
    const unsigned of_block = round.segments_of_block() * round.slots;
#pragma unroll 4
    for (unsigned i = threadIdx.x; i < round.segments() * round.slots; i += segment_threads)
      gathered()[i] = group.in(i / of_block, shared).segments[i % of_block].w;
    group.sync();
  }
  __device__ float* gathered() const { return reinterpret_cast<float*>(shared.queues); }

  /// Replaces `befores` by the true transmittances. Whether a pixel stops in a segment that its warp has
  /// blended with others.
  template <unsigned pixel_count>
  __device__ bool find_befores(const Round& round, const Share& share, float (&befores)[pixel_count]) {
    bool again = false;
    if (share.segment != 0 && share.segment < round.segments()) {
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) {
        bool live = befores[p] >= 0;
        const unsigned slot = share.slot + p * warp_size;
        float before = shared.joined.totals[pixel_in<pixel_count>(slot, live)].w;
        const auto transmittance = [&](unsigned k) {
          const unsigned at = k * round.slots + slot;
          return group.blocks == 1 ? shared.segments[at].w : gathered()[at];
        };
        const auto stops = [&](unsigned k, float left) {
          return stops_in_segment(left, rules.stop_below, before, round.first + k);
        };
#pragma unroll 4
        for (unsigned k = 0; k < share.segment; ++k) {
          const float left = transmittance(k);
          live = live && !stops(k, left);
          before = before * scale_of_segment(round.first + k) * fabsf(left);
        }
        befores[p] = live ? before : -1;
        again = again || (live && stops(share.segment, transmittance(share.segment)));
      }
    }
    return __any_sync(whole_warp, again);
  }

  /// Joins the segments of a round in order, a thread a channel of a pixel. Each block joins some pixels for
  /// all.
  template <unsigned pixel_count>
  __device__ void join(const Round& round) {
    constexpr unsigned channels = 4;
    const unsigned pixels = round.slots / group.blocks, of_block = round.segments_of_block();
    const unsigned own = threadIdx.x / channels, channel = threadIdx.x % channels;
    if (warp() * warp_size >= channels * pixels) return;
    const unsigned slot = group.rank * pixels + own % pixels;
    const bool was_live = own < pixels && is_live<pixel_count>(round, slot);
    const unsigned pixel = pixel_in<pixel_count>(slot, was_live);
    bool live = was_live;
    float before = 0, all = 0, depth = 0;
    if (was_live) {  // Other warps and blocks may be writing the other pixels.
      before = shared.joined.totals[pixel].w, all = (&shared.joined.totals[pixel].x)[channel];
      if constexpr (extras) depth = shared.joined.depths[pixel];
    }
#pragma unroll 4
    for (unsigned k = 0; k < round.segments(); ++k) {
      const SegmentShared<Exponent, extras>& of = group.in(k / of_block, shared);
      const unsigned at = k % of_block * round.slots + slot;
      const float left = of.segments[at].w, value = (&of.segments[at].x)[channel];
      const float of_depth = extras ? of.depths[at] : 0;
      if (!live) continue;
      // As `JoinedPixel::join`.
      const float scaled = before * scale_of_segment(round.first + k);
      all = fmaf(scaled, value, all), depth = fmaf(scaled, of_depth, depth);
      before = scaled * fabsf(left), live = !signbit(left);
    }
    __syncwarp();  // all have read what is overwritten
    if (!was_live) return;
    for (unsigned b = 0; b < group.blocks; ++b) {
      SegmentShared<Exponent, extras>& of = group.in(b, shared);
      (&of.joined.totals[pixel].x)[channel] = channel + 1 == channels ? before : all;
      if (extras && channel == 0) of.joined.depths[pixel] = depth;
      if (channel == 0 && !live) atomicAnd(&of.live[pixel / warp_size], ~(1u << pixel % warp_size));
    }
  }
};

/// Goes on with parts that `raster_warps` hands over, while it still runs, in blocks for which it leaves
/// room: clusters with those that have most left, single blocks with the rest.
template <class Exponent, bool threshold, bool extras, class ViewSource>
__global__ void __launch_bounds__(segment_threads, segment_occupancy<extras>)
    raster_segments(const __grid_constant__ RasterInput<ViewSource> input,
                    const __grid_constant__ WorkQueues work_queues, std::uint32_t warps_at_once) {
  __shared__ SegmentShared<Exponent, extras> shared;
  const Group cluster = Group::cluster();
  // Every other cluster takes parts for clusters first. The others take parts for single blocks first.
  bool as_cluster = cluster.blocks != 1 && blockIdx.x / cluster.blocks % 2 == 1;
  if (threadIdx.x == 0 && !(as_cluster && cluster.rank != 0)) work_queues.begin(as_cluster);
  for (unsigned turn = 0; turn < (cluster.blocks == 1 ? 1 : 2); ++turn, as_cluster = !as_cluster) {
    const Group group = as_cluster ? cluster : Group();
    for (;;) {
      group.sync();
      if (group.rank == 0 && threadIdx.x == 0) {
        const WorkItem* const next = work_queues.await_next(as_cluster);
        for (unsigned b = 0; b < group.blocks; ++b) group.in(b, shared).part = next;
      }
      group.sync();
      const WorkItem* const part = shared.part;
      if (!part) break;
      const WarpTimer timer(extras && input.job.counts, warps_at_once);
      WorkItemBlender<Exponent, threshold, extras, ViewSource>(input, *part, group, shared).run(*part, timer);
      if (group.rank == 0 && threadIdx.x == 0) work_queues.end_item(as_cluster);
    }
  }
  if (threadIdx.x == 0) work_queues.leave();
}
}  // namespace kernels

/// Rasterizes with terms of `Exponent` in registers.
template <class Exponent, bool threshold>
void rasterize_warps(Cuda& cuda, const char* name, const RasterJob& job) {
  using namespace kernels;
  with_raster_input(cuda, job, [&]<bool extras, class ViewSource>(const RasterInput<ViewSource>& input) {
    const WorkQueues work_queues = WorkQueues::of(cuda, input.raster_blocks.size() * warps_of_raster_block);
    const bool shared = WorkQueues::are_shared(cuda, job.counts != nullptr);
    const auto warps = shared ? raster_warps<Exponent, threshold, extras, true, ViewSource>
                              : raster_warps<Exponent, threshold, extras, false, ViewSource>;
    const auto segments = raster_segments<Exponent, threshold, extras, ViewSource>;
    launch(name, warps, blocks_of(input.raster_blocks), raster_threads, cuda.stream(), input, work_queues,
           warps_at_once(cuda, job, warps, raster_threads));
    if (!shared) return;
    const unsigned clusters = unsigned(cuda.multiprocessors()) * blocks_of_multiprocessor / blocks_of_group;
    try {
      launch_early<blocks_of_group>(cuda, name, segments, std::max(clusters, 1u) * blocks_of_group,
                                    segment_threads, input, work_queues,
                                    warps_at_once(cuda, job, segments, segment_threads));
    } catch (const DeviceError&) {
      work_queues.forget(cuda);  // or the next frame would go on with this one's
      throw;
    }
  });
}

}  // namespace swiftgs
