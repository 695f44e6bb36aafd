// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "group.cuh"
#include "lane_blender.cuh"
#include "touched_splats.cuh"

namespace swiftgs::kernels {

/// Warps of a thread block of the helper kernel.
inline constexpr unsigned segment_warps = 8, segment_threads = segment_warps * warp_size;
/// Thread blocks that a multiprocessor can hold.
template <Extras extras>
inline constexpr unsigned segment_occupancy = extras == Extras::all ? 2 : 3;
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
template <class Exponent, Extras extras>
struct SegmentShared {
  static constexpr bool with_depth = extras != Extras::none;
  Queue<Exponent> queues[segment_warps];
  SegmentSplats::Shared splats;
  float4 segments[pixels_of_round];  ///< RGB and `mark_stopped` transmittance; indexed by segment, then slot
  float depths[with_depth ? pixels_of_round : 1];
  JoinedWarpBlock<with_depth> joined;
  unsigned live[pixels_of_lane];  ///< bits of pixels that did not stop
  std::uint32_t pixel_of_slot[pixels_of_warp_block];
  const WorkItem* item;
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
  __device__ std::uint32_t most_splats() const { return blocks * segments_of_block() * segment_size; }
  __device__ unsigned segments() const { return (splats + segment_size - 1) / segment_size; }
  __device__ std::uint32_t splats_of(unsigned segment) const {
    const std::uint32_t before = segment * segment_size;
    return before < splats ? min(splats - before, segment_size) : 0;
  }
};

/// Blends a work item in rounds, by a group of thread blocks.
template <class Exponent, bool threshold, Extras extras, class ViewSource>
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

  __device__ WorkItemBlender(const RasterInput<ViewSource>& of, const WorkItem& item, const Group& by,
                             SegmentShared<Exponent, extras>& in)
      : input(of),
        group(by),
        shared(in),
        raster_block(of, item.raster_block),
        view(of.views[raster_block.view]),
        rules(view.rules),
        place(raster_block, item.warp_block),
        first_centre(place.first_centre(view)) {}

  __device__ static unsigned warp() { return threadIdx.x / warp_size; }

  /// `timer`: began with the work on the item.
  __device__ void run(const WorkItem& item, const WarpTimer& timer) {
    const TileRange range = raster_block.list(input);
    if (threadIdx.x < pixels_of_warp_block) shared.joined.store(threadIdx.x, item.joined.load(threadIdx.x));
    if (threadIdx.x < pixels_of_lane) shared.live[threadIdx.x] = item.live[threadIdx.x];
    __syncthreads();

    ResumeAt next = item.at;
    if (item.segments == 0) next = end_first_segment(next, range.end, first_segment_size - item.blended);
    group.sync();

    SegmentSplats splats(shared.splats, input.job, group, next, range.end);
    std::uint32_t segment = max(item.segments, 1u);
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
    if constexpr (extras == Extras::all)
      if (input.job.counts) {
        RasterCounts of_warp = counts_of_warp(counts, splats.position() - range.begin, evaluated, timer);
        of_warp.segments = warp_sum(segments_joined), of_warp.pixels_joined = warp_sum(pixels_joined);
        of_warp.longest_item = (splats.position() - item.at.position) / group.blocks;
        add_counts(input.job.counts[item.raster_block.number(input.raster_blocks.columns)], of_warp);
      }
  }

 private:
  /// Blends the rest of the first segment, at most `most` splats, with one warp. Every thread block of the
  /// group does the same. Returns where the next segment begins.
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
        if constexpr (extras != Extras::none) lane.occluders[p] = place.pixel(view.frame, p, true).occluder;
      }
      __syncwarp();
      blend_splats(lane, splats, 0, count, count, share);
      if (group.rank != 0) evaluated = 0;  // the first thread block counts for all
#pragma unroll
      for (unsigned p = 0; p < pixels_of_lane; ++p) {
        JoinedPixel all;
        all.join(lane.pixels[p].blended(), 0);
        shared.joined.store(pixel_of_warp_block(p), all);
        const unsigned live = __ballot_sync(whole_warp, lane.pixels[p].live());
        if (lane_index() == 0) shared.live[p] = live;
        if constexpr (extras == Extras::all)
          if (group.rank == 0) counts.pairs += lane.counts[p].pairs, counts.stopped += lane.counts[p].stopped;
      }
    }
    splats.drop(count);
    __syncthreads();
    return splats.next();
  }

  /// As `relative_log2_opacity`. Measured on an H100: if this kernel had the branch of `log2_opacity`,
  /// rasterizing would take 302 us, not 291, in `builtin:1000000`, and 667, not 639, in `builtin:4000000`. So
  /// a single view that needs the branch has the kernel with all extras. Stored views have the branch, since
  /// those of a recorded frame may change.
  __device__ float log2_opacity_of(const SplatShape& shape) const {
    if constexpr (extras == Extras::all || !ViewSource::only)
      return relative_log2_opacity(shape, rules);
    else
      return shape.cutoff + rules.log2_relative_min;
  }

  /// Gives the first slots to live pixels. The caller synchronises before it reads them.
  __device__ void give_slots() {
    if (threadIdx.x >= pixels_of_warp_block) return;
    const unsigned p = threadIdx.x / warp_size;
    if (!(shared.live[p] >> lane_index() & 1)) return;
    const int slot = __popc(shared.live[p] & lanes_below()) + (p == 1 ? __popc(shared.live[0]) : 0);
    shared.pixel_of_slot[slot] = threadIdx.x;
  }

  /// A lane's share of a round: slot `slot` of a segment, and `slot` + 32 if it has two pixels.
  struct Share {
    unsigned lanes;          ///< of a segment; each queues one splat of it at a time
    unsigned segment, slot;  ///< segment among those of the group
    unsigned own;            ///< segment among those of the thread block

    __device__ Share(const Round& round, unsigned rank)
        : lanes(warp_size / round.segments_of_warp), slot(lane_index() % lanes) {
      own = warp() * round.segments_of_warp + lane_index() / lanes;
      segment = rank * round.segments_of_block() + own;
    }
  };

  /// Whether the pixel in a slot is live.
  template <unsigned pixel_count>
  __device__ bool is_live(const Round& round, unsigned slot) const {
    return pixel_count == 1 ? slot < round.live : shared.live[slot / warp_size] >> slot % warp_size & 1;
  }
  /// The pixel in a slot, if it is live.
  template <unsigned pixel_count>
  __device__ unsigned pixel_in(unsigned slot, bool live) const {
    return pixel_count == 1 && live ? shared.pixel_of_slot[slot] : slot;
  }

  template <unsigned pixel_count>
  __device__ void blend_round(const SegmentSplats& splats, const Round& round) {
    const Share share(round, group.rank);
    LaneBlender<Exponent, threshold, extras, pixel_count> lane{rules, 0, 0, 0, {}, {}, {}};
    float befores[pixel_count];  // transmittances before the segment; negative: no pixel, or stopped
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
      if constexpr (extras != Extras::none)
        lane.occluders[p] =
            PixelPlace(view.frame, place.x + int(at.column), place.y + int(at.row), true).occluder;
    }
    const unsigned first_of_warp = group.rank * round.segments_of_block() + warp() * round.segments_of_warp;
    const std::uint32_t most = round.splats_of(first_of_warp);
    if (most != 0) blend_segments(lane, splats, round, share, most, befores);
    group.sync();

    // Find the true transmittances before segments. Blend again the segments in which a pixel stops.
    gather_transmittances(round);
    const bool again = find_befores(round, share, befores);
    if (__syncthreads_or(again)) {
      if (again) blend_segments(lane, splats, round, share, most, befores);
      if (group.blocks == 1) __syncthreads();
    }
    if (group.blocks != 1) group.sync();
    if constexpr (extras == Extras::all)
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

  /// Blends this warp's segments, given the transmittances `befores` before them.
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
      if constexpr (extras != Extras::none) shared.depths[at] = pixel.depth;
    }
  }

  /// Blends `count` splats of a lane's segment, from the `first`-th found on. Segments of the warp have at
  /// most `most` splats.
  template <unsigned pixel_count>
  __device__ void blend_splats(LaneBlender<Exponent, threshold, extras, pixel_count>& lane,
                               const SegmentSplats& splats, std::uint32_t first, std::uint32_t count,
                               std::uint32_t most, const Share& share) {
    // Queue one half while the other is blended, and load the shapes of the next. Each lane queues for its
    // own segment. Behind a segment's end it queues splats that show nothing.
    Queue<Exponent>& queue = shared.queues[warp()];
    std::uint32_t id = share.slot < count ? splats.id(first + share.slot) : 0;
    SplatShape shape = load_shape(input.job.splats, id);
    unsigned half = 0;
    const auto queue_from = [&](std::uint32_t k) {
      const unsigned slot = half + lane_index();
      if (k + share.slot < count) {
        fetch_colour(input.job, queue, slot, id);
        Exponent::prepare(shape, shape.mean - first_centre, log2_opacity_of(shape), queue.terms[slot],
                          queue.rests[slot]);
      } else {
        Exponent::clear(queue.terms[slot], queue.rests[slot]);
        queue.colours[slot] = no_colour();
      }
      __pipeline_commit();
      k += share.lanes;
      id = k + share.slot < count ? splats.id(first + k + share.slot) : 0;
      shape = load_shape(input.job.splats, id);
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
      if constexpr (extras == Extras::all) evaluated += size * pixel_count * warp_size;
      __syncwarp();
      if (lane.all_stopped()) break;
    }
    __pipeline_wait_prior(0);
  }

  /// Copies transmittances of all segments of a round to each thread block. A single one has them already.
  __device__ void gather_transmittances(const Round& round) {
    if (group.blocks == 1) return;
    // The queues are empty now, and large enough.
    static_assert(blocks_of_group * pixels_of_round * sizeof(float) <= sizeof shared.queues);
    const unsigned of_block = round.segments_of_block() * round.slots;
#pragma unroll 4
    for (unsigned i = threadIdx.x; i < round.segments() * round.slots; i += segment_threads)
      gathered()[i] = group.in(i / of_block, shared).segments[i % of_block].w;
    group.sync();
  }
  __device__ float* gathered() const { return reinterpret_cast<float*>(shared.queues); }

  /// Replaces `befores` by the true transmittances. Returns whether a pixel stops in a segment of this warp.
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

  /// Joins the segments of a round in order, one thread per channel of a pixel. Each thread block joins some
  /// pixels for all.
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
      if constexpr (extras != Extras::none) depth = shared.joined.depths[pixel];
    }
#pragma unroll 4
    for (unsigned k = 0; k < round.segments(); ++k) {
      const SegmentShared<Exponent, extras>& of = group.in(k / of_block, shared);
      const unsigned at = k % of_block * round.slots + slot;
      const float left = of.segments[at].w, value = (&of.segments[at].x)[channel];
      const float of_depth = extras != Extras::none ? of.depths[at] : 0;
      if (!live) continue;
      // As `JoinedPixel::join`.
      const float scaled = before * scale_of_segment(round.first + k);
      all = fmaf(scaled, value, all), depth = fmaf(scaled, of_depth, depth);
      before = scaled * fabsf(left), live = !signbit(left);
    }
    __syncwarp();  // all lanes have read what is overwritten
    if (!was_live) return;
    for (unsigned b = 0; b < group.blocks; ++b) {
      SegmentShared<Exponent, extras>& of = group.in(b, shared);
      (&of.joined.totals[pixel].x)[channel] = channel + 1 == channels ? before : all;
      if (extras != Extras::none && channel == 0) of.joined.depths[pixel] = depth;
      if (channel == 0 && !live) atomicAnd(&of.live[pixel / warp_size], ~(1u << pixel % warp_size));
    }
  }
};

}  // namespace swiftgs::kernels
