// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "segment_memory.cuh"

namespace swiftgs::kernels {

/// Blends a work item in rounds, by a group of thread blocks.
template <class Exponent, bool threshold, class Planes, class ViewSource>
struct WorkItemBlender {
  using Before = BeforeSegment<Planes>;

  const RasterInput<ViewSource>& input;
  const Group group;
  SegmentShared<Exponent, Planes>& shared;
  const OwnRasterBlock raster_block;
  const View& view;
  const BlendRules rules;
  const WarpBlock warp_block;
  const vec2 first_centre;

  __device__ WorkItemBlender(const RasterInput<ViewSource>& of, const WorkItem& item, const Group& by,
                             SegmentShared<Exponent, Planes>& in)
      : input(of),
        group(by),
        shared(in),
        raster_block(of, item.raster_block),
        view(of.views[raster_block.view]),
        rules(view.rules),
        warp_block(raster_block, item.warp_block),
        first_centre(warp_block.first_centre(view)) {}

  __device__ static unsigned warp() { return threadIdx.x / warp_size; }

  /// `planes`: of the item.
  __device__ void run(const WorkItem& item,
                      const typename Planes::template Joined<pixels_of_warp_block>& planes) {
    const TileRange range = raster_block.list(input);
    if (threadIdx.x < pixels_of_warp_block) {
      shared.joined.store(threadIdx.x, item.joined.load(threadIdx.x));
      shared.planes.copy(threadIdx.x, planes, threadIdx.x);
    }
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
      const unsigned pixel = pixel_of_warp_block(warp());
      shared.planes.store(pixel, input.job, view, warp_block.pixel(view.frame, warp(), false),
                          shared.joined.load(pixel).blended());
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
      LaneBlender<Exponent, threshold, Planes, pixels_of_lane> lane(input.job, view, float(warp_block.column),
                                                                    float(warp_block.row));
      lane.rays.put(view, warp_block.x + warp_block.column, warp_block.y + warp_block.row);
#pragma unroll
      for (unsigned p = 0; p < pixels_of_lane; ++p) {
        const JoinedPixel from = shared.joined.load(pixel_of_warp_block(p));
        lane.pixels[p] = from.stopped();
        if (shared.live[p] >> lane_index() & 1) lane.pixels[p].start(rules.stop_below, from.total.w);
        shared.planes.go_on(pixel_of_warp_block(p), lane.planes, p, lane.pixels[p].live(), rules);
        if constexpr (Planes::depth)
          lane.occluders[p] = lane.rays.take(p, warp_block.pixel(view.frame, p, true).occluder);
      }
      __syncwarp();
      blend_splats(lane, splats, 0, count, count, share);
#pragma unroll
      for (unsigned p = 0; p < pixels_of_lane; ++p) {
        JoinedPixel all;
        all.join(lane.pixels[p].blended(), 0);
        shared.joined.store(pixel_of_warp_block(p), all);
        shared.planes.end_rest(pixel_of_warp_block(p), lane.planes, p, all.total.w);
        const unsigned live = __ballot_sync(whole_warp, lane.pixels[p].live());
        if (lane_index() == 0) shared.live[p] = live;
      }
    }
    splats.drop(count);
    __syncthreads();
    return splats.next();
  }

  /// As `relative_log2_opacity`. Measured on an H100: if the kernel of colours had the branch of
  /// `log2_opacity`, rasterizing would take 302 us, not 291, in `builtin:1000000`, and 667, not 639, in
  /// `builtin:4000000`. So a single view that needs the branch has a kernel with picks. Stored views have the
  /// branch, since those of a recorded frame may change.
  __device__ float log2_opacity_of(const SplatShape& shape) const {
    if constexpr (!Planes::few || !ViewSource::only)
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
    LaneBlender<Exponent, threshold, Planes, pixel_count> lane(input.job, view, 0, 0);
    Before befores[pixel_count];
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) {
      const unsigned slot = share.slot + p * warp_size;
      const bool live = is_live<pixel_count>(round, slot);
      const unsigned pixel = pixel_in<pixel_count>(slot, live);
      const PixelOfWarpBlock at(pixel);
      if (p == 0) {
        const unsigned first = at.column % columns_between;
        lane.x = float(first), lane.right = float(at.column - first), lane.y = float(at.row);
        lane.rays.put(view, warp_block.x + int(at.column), warp_block.y + int(at.row));
      }
      // A pixel that stops by the transmittance before the round stops in this segment or an earlier one.
      const float before = shared.joined.totals[pixel].w;
      befores[p].transmittance = !live ? -1 : share.segment == 0 ? before : most_before(before);
      if (live && share.segment == 0) {
        befores[p].planes = shared.planes.before(pixel, lane.planes, rules);
        befores[p].planes.enter(before, round.first);
      }
      if constexpr (Planes::depth)
        lane.occluders[p] = lane.rays.take(
            p,
            FramePixel(view.frame, warp_block.x + int(at.column), warp_block.y + int(at.row), true).occluder);
    }
    const unsigned first_of_warp = group.rank * round.segments_of_block() + warp() * round.segments_of_warp;
    const std::uint32_t most = round.splats_of(first_of_warp);
    if (most != 0) blend_segments(lane, splats, round, share, most, befores);
    group.sync();

    // Find the true transmittances before segments. Blend again the segments in which a pixel stops.
    gather_transmittances(round);
    const bool again = find_befores(lane, round, share, befores);
    if (__syncthreads_or(again)) {
      if (again) blend_segments(lane, splats, round, share, most, befores);
      if (group.blocks == 1) __syncthreads();
    }
    if (group.blocks != 1) group.sync();
    join<pixel_count>(round);
    group.sync();
  }

  /// Blends this warp's segments, given what lies in front of them.
  template <unsigned pixel_count>
  __device__ void blend_segments(LaneBlender<Exponent, threshold, Planes, pixel_count>& lane,
                                 const SegmentSplats& splats, const Round& round, const Share& share,
                                 std::uint32_t most, const Before (&befores)[pixel_count]) {
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) {
      lane.pixels[p] = {};
      const float before = befores[p].transmittance;
      if (before >= 0) start_segment(lane.pixels[p], rules.stop_below, before, round.first + share.segment);
      lane.planes.start(p, befores[p].planes);
    }

    blend_splats(lane, splats, share.own * segment_size, round.splats_of(share.segment), most, share);

    __syncwarp();  // all lanes have loaded what they queued
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) {
      const BlendedPixel pixel = lane.pixels[p].blended();
      const bool stopped = befores[p].transmittance >= 0 && !lane.pixels[p].live();
      const unsigned at = round.at(share.own, share.slot + p * warp_size);
      shared.segments[at] = make_float4(pixel.colour.x, pixel.colour.y, pixel.colour.z,
                                        mark_stopped(pixel.transmittance, stopped));
      if constexpr (Planes::depth) shared.depths[at] = pixel.depth;
      lane.planes.put(shared.planes_of_segments, shared.queues[warp()], at, p, pixel.transmittance);
    }
  }

  /// Blends `count` splats of a lane's segment, from the `first`-th found on. Segments of the warp have at
  /// most `most` splats.
  template <unsigned pixel_count>
  __device__ void blend_splats(LaneBlender<Exponent, threshold, Planes, pixel_count>& lane,
                               const SegmentSplats& splats, std::uint32_t first, std::uint32_t count,
                               std::uint32_t most, const Share& share) {
    // Queue one half while the other is blended, and load the shapes of the next. Each lane queues for its
    // own segment. Behind a segment's end it queues splats that show nothing.
    Queue<Exponent, Planes>& queue = shared.queues[warp()];
    std::uint32_t id = share.slot < count ? splats.id(first + share.slot) : 0;
    SplatShape shape = load_shape(input.job.splats, id);
    unsigned half = 0;
    const auto queue_from = [&](std::uint32_t k) {
      const unsigned slot = half + lane_index();
      if (k + share.slot < count) {
        queue.fetch(input.job, slot, id);
        Exponent::prepare(shape, shape.from_mean(first_centre), log2_opacity_of(shape), queue.terms[slot],
                          queue.rests[slot]);
      } else {
        queue.clear(slot);
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
    for (unsigned i = threadIdx.x; i < round.segments() * round.slots; i += segment_threads) {
      const unsigned own = i % of_block;
      gathered()[i] =
          group.in(i / of_block, shared).segments[round.at(own / round.slots, own % round.slots)].w;
    }
    group.sync();
  }
  __device__ float* gathered() const {
    return Planes::fills_queues ? shared.gathered : reinterpret_cast<float*>(shared.queues);
  }

  /// Replaces `befores` by what lies in front of segments. Returns whether a pixel stops or passes a limit in
  /// a segment of this warp.
  template <unsigned pixel_count>
  __device__ bool find_befores(const LaneBlender<Exponent, threshold, Planes, pixel_count>& lane,
                               const Round& round, const Share& share, Before (&befores)[pixel_count]) {
    bool again = false;
    if (share.segment != 0 && share.segment < round.segments()) {
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) {
        bool live = befores[p].transmittance >= 0;
        const unsigned slot = share.slot + p * warp_size, pixel = pixel_in<pixel_count>(slot, live);
        float before = shared.joined.totals[pixel].w;
        typename Planes::Before planes = shared.planes.before(pixel, lane.planes, rules);
        const auto transmittance = [&](unsigned k) {
          return group.blocks == 1 ? shared.segments[round.at(k, slot)].w
                                   : gathered()[k * round.slots + slot];
        };
        const auto stops = [&](unsigned k, float left) {
          return stops_in_segment(left, rules.stop_below, before, round.first + k);
        };
#pragma unroll 4
        for (unsigned k = 0; k < share.segment; ++k) {
          const float left = transmittance(k);
          live = live && !stops(k, left);
          planes.pass(before, round.first + k, fabsf(left));
          before = before * scale_of_segment(round.first + k) * fabsf(left);
        }
        const float left = transmittance(share.segment);
        planes.enter(before, round.first + share.segment);
        const bool differs = stops(share.segment, left) || planes.differs(fabsf(left));
        befores[p] = {live ? before : -1, planes};
        again = again || (live && differs);
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
    typename Planes::Channel planes;
    if (was_live) {  // Other warps and blocks may be writing the other pixels.
      before = shared.joined.totals[pixel].w, all = (&shared.joined.totals[pixel].x)[channel];
      if constexpr (Planes::depth) depth = shared.joined.depths[pixel];
      planes.load(shared.planes, pixel, channel);
    }
#pragma unroll 4
    for (unsigned k = 0; k < round.segments(); ++k) {
      const SegmentShared<Exponent, Planes>& of = group.in(k / of_block, shared);
      const unsigned at = round.at(k % of_block, slot);
      const float left = of.segments[at].w, value = (&of.segments[at].x)[channel];
      const float of_depth = Planes::depth ? of.depths[at] : 0;
      if (!live) continue;
      // As `JoinedPixel::join`.
      const float scaled = before * scale_of_segment(round.first + k);
      all = fmaf(scaled, value, all), depth = fmaf(scaled, of_depth, depth);
      planes.join(of, at, channel, scaled);
      before = scaled * fabsf(left), live = !signbit(left);
    }
    __syncwarp();  // all lanes have read what is overwritten
    if (!was_live) return;
    for (unsigned b = 0; b < group.blocks; ++b) {
      SegmentShared<Exponent, Planes>& of = group.in(b, shared);
      (&of.joined.totals[pixel].x)[channel] = channel + 1 == channels ? before : all;
      if (Planes::depth && channel == 0) of.joined.depths[pixel] = depth;
      planes.store(of.planes, pixel, channel);
      if (channel == 0 && !live) atomicAnd(&of.live[pixel / warp_size], ~(1u << pixel % warp_size));
    }
  }
};

}  // namespace swiftgs::kernels
