// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <swiftgs/cuda/launch.cuh>

#include "lane_blender.cuh"

namespace swiftgs::kernels {

/// Pixels at the end of the last segment.
template <class Planes>
struct TraversedSegments {
  JoinedPixels<Planes::depth, pixels_of_lane> pixels;
  typename Planes::template Joined<pixels_of_lane> planes;
  SegmentEnd end;
};

/// Composites the segments of a traversal.
template <class Exponent, bool threshold, class Planes>
struct SegmentJoiner {
  using ItemPlanes = typename Planes::template Joined<pixels_of_warp_block>;

  LaneBlender<Exponent, threshold, Planes, pixels_of_lane>& lane;
  TraversedSegments<Planes>& traversed;

  /// Joins segment k, which ended at `end`, to those in front of it. Starts the next.
  __device__ void end_segment(std::uint32_t k, const SegmentEnd& end) const {
    traversed.end = end;
    join_segment(k);
  }

  /// Joins the unfinished segment k. Leaves all segments in the pixels, and in the planes traversed.
  __device__ void end(std::uint32_t k, bool is_empty) const {
    if (k == 0) {
#pragma unroll
      for (unsigned p = 0; p < pixels_of_lane; ++p) traversed.planes.set(p, lane.planes, p, left_by(p));
      return;
    }
    if (!is_empty) join_segment(k);
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) lane.pixels[p] = traversed.pixels.load(p).stopped();
  }

  /// Writes a work item for the rest of a list, after `segments` segments and `blended` splats. An unfinished
  /// segment behind the first goes to the item as a whole.
  __device__ void write(WorkItem& item, ItemPlanes& planes, RasterBlockIndex raster_block, ResumeAt at,
                        std::uint32_t segments, std::uint32_t blended) const {
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      const Pixel& pixel = lane.pixels[p];
      JoinedPixel all;
      bool was_live;
      if (segments == 0) {
        all.join(pixel.blended(), 0), was_live = pixel.live();
        planes.set(pixel_of_warp_block(p), lane.planes, p, left_by(p));
      } else {
        all = traversed.pixels.load(p), was_live = pixel.stop_below != had_stopped;
        planes.copy(pixel_of_warp_block(p), traversed.planes, p);
      }
      item.joined.store(pixel_of_warp_block(p), all);
      const unsigned live = __ballot_sync(whole_warp, was_live);
      if (lane_index() == 0) item.live[p] = live;
    }
    if (lane_index() == 0) {
      item.segments = segments, item.blended = blended;
      item.raster_block = raster_block, item.warp_block = threadIdx.x / warp_size;
      item.at = at;
    }
  }

 private:
  /// Transmittance behind the segment of the lane's p-th pixel; infinite if it had stopped before.
  __device__ float left_by(unsigned p) const { return lane.pixels[p].blended().transmittance; }

  /// Joins segment k to those in front of it. Starts the next.
  __device__ void join_segment(std::uint32_t k) const {
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      Pixel& pixel = lane.pixels[p];
      JoinedPixel all = k == 0 ? JoinedPixel() : traversed.pixels.load(p);
      const bool live = pixel.live();
      if (k == 0)
        traversed.planes.set(p, lane.planes, p, left_by(p));
      else
        traversed.planes.join(p, lane.planes, p, left_by(p), all.total.w * scale_of_segment(k));
      if (pixel.stop_below != had_stopped) all.join(pixel.blended(), k);
      traversed.pixels.store(p, all);
      pixel = {};
      traversed.planes.start_next(p, lane.planes, p, live, lane.rules, all.total.w, k + 1);
      if (live)
        start_segment(pixel, lane.rules.stop_below, all.total.w, k + 1);
      else
        pixel.stop_below = had_stopped;
    }
  }

  /// `stop_below` of a pixel that had stopped before the segment.
  static constexpr float had_stopped = -INFINITY;
};

/// Thread blocks of a multiprocessor at once.
template <class Exponent, class Planes>
inline constexpr unsigned raster_occupancy = std::min(Exponent::blocks, Planes::most_blocks);

/// Intersections that a traversal must have left to be pushed before it is long, if a helper is idle. Planes
/// cost pushing and joining more.
/// Measured on an H100: if traversals with picks are not pushed before they are long, frames of herz take
/// 0.56 ms, not 0.58, but those of `builtin:1000000` 0.80, not 0.63.
template <class Planes>
inline constexpr std::uint32_t least_left_to_help =
    Planes::few || Planes::one_by_one ? least_left : 2 * least_left;

/// Blends the list of one raster block: one thread block per raster block, one warp per warp block. If
/// `shared`, pushes the rest of a long traversal to the work queues. Kernels of colour and depth are faster
/// if they are compiled without that too; others push nothing where the queues are closed.
template <class Exponent, bool threshold, class Planes, bool shared, class ViewSource>
__global__ void __launch_bounds__(raster_threads,
                                  (resident_blocks(raster_occupancy<Exponent, Planes>, raster_threads)))
    raster_warps(const __grid_constant__ RasterInput<ViewSource> input,
                 const __grid_constant__ WorkQueues work_queues) {
  if constexpr (shared) let_next_start();
  __shared__ Queue<Exponent, Planes> queues[warps_of_raster_block];
  const unsigned warp = threadIdx.x / warp_size;
  const RasterJob& job = input.job;
  const OwnRasterBlock raster_block(input);
  const View& view = input.views[raster_block.view];
  const BlendRules rules = view.rules;
  const WarpBlock warp_block(raster_block, warp);
  if (warp_block.outside(view.frame)) return;

  using Lane = LaneBlender<Exponent, threshold, Planes, pixels_of_lane>;
  ColourBlender<Exponent, threshold, Planes> blender{
      job, queues[warp], Lane(job, view, float(warp_block.column), float(warp_block.row))};
  blender.lane.rays.put(view, warp_block.x + warp_block.column, warp_block.y + warp_block.row);
#pragma unroll
  for (unsigned p = 0; p < pixels_of_lane; ++p) {
    const FramePixel at = warp_block.pixel(view.frame, p, Planes::depth);
    if (at.inside) blender.lane.pixels[p].start(rules.stop_below);
    if constexpr (Planes::depth) blender.lane.occluders[p] = blender.lane.rays.take(p, at.occluder);
  }

  const TileRange range = raster_block.list(input);
  if (!range.drawn()) return;
  ListTraversal<Exponent> traversal(job, range, warp_block.first_centre(view), rules, queues[warp]);
  TraversedSegments<Planes> traversed;
  const SegmentJoiner<Exponent, threshold, Planes> joiner{blender.lane, in_memory(traversed)};
  WorkItem* item = nullptr;
  while (!item) {
    const std::uint32_t limit =
        shared ? traversal.here().position + min(traversal.left(), visits_between_checks) : range.end;
    const Pause pause = traversal.go_on(blender, limit);
    if (pause == Pause::stopped || (pause == Pause::at_limit && traversal.left() == 0)) break;
    if (pause == Pause::at_segment) {
      joiner.end_segment(traversal.segments() - 1, traversal.segment_end());
      if (blender.all_stopped()) {
        traversal.drop_rest();
        break;
      }
    }
    if constexpr (shared)
      item = work_queues.reserve_item<least_left_to_help<Planes>>(traversal.blended(), traversal.visited(),
                                                                  traversal.left());
  }
  if (!shared || (!Planes::few && work_queues.are_closed()))
    work_queues.end_traversal(traversal.blended(), traversal.visited());
  // A helper resumes at the end of the last segment and queues the splats behind it again. Within the first
  // segment it resumes here: blend the queued splats.
  if (item && traversal.segments() != 0) traversal.drop_rest();
  traversal.blend_rest(blender);

  if (item) {
    using Joiner = SegmentJoiner<Exponent, threshold, Planes>;
    const ResumeAt next =
        traversal.segments() == 0 ? traversal.here() : traversal.behind(joiner.traversed.end);
    joiner.write(*item, work_queues.planes_of<typename Joiner::ItemPlanes>(item),
                 OwnRasterBlock::index(input), next, traversal.segments(), traversal.blended());
    work_queues.push(item);
  } else {
    joiner.end(traversal.segments(), traversal.blended() == begin_of_segment(traversal.segments()));
    // Find the warp block again: kept in registers during the traversal, it would cost one thread block in
    // nine.
    const WarpBlock same(OwnRasterBlock(input), threadIdx.x / warp_size);
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p)
      joiner.traversed.planes.store(p, job, view, same.pixel(view.frame, p, false),
                                    blender.lane.pixels[p].blended());
  }
}

}  // namespace swiftgs::kernels
