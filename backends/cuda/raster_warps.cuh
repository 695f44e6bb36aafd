// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda_pipeline_primitives.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>

#include "box_touched.hpp"
#include "exponents.hpp"
#include "pixel.cuh"
#include "work_queue.cuh"

namespace swiftgs {

namespace kernels {

/// A raster block is four parts, each a warp's own: it traverses the list by itself and never waits for the
/// others. A lane has two pixels of one row, four columns apart.
inline constexpr unsigned warps_of_raster_block = 4;
inline constexpr unsigned raster_threads = warps_of_raster_block * warp_size;

/// Splats that touch a part wait here until there are enough to blend: a ring of two halves, so that one can
/// be filled while the other is blended.
inline constexpr unsigned queue_half = 32, queue_size = 2 * queue_half;
inline constexpr unsigned halves_of_first_segment = first_segment_size / queue_half;
inline constexpr unsigned halves_of_segment = segment_size / queue_half;
static_assert(halves_of_first_segment % halves_of_segment == 0);

/// Terms of splats, as their part sees them.
template <class Exponent>
struct TermsQueue {
  float4 terms[queue_size];
  typename Exponent::Rest rests[queue_size];
};

/// Where a warp's part lies in its frame, and this lane's pixels in it.
struct WarpBlockPlace {
  int x, y;         ///< first pixel
  int column, row;  ///< of the lane's first pixel within the part

  __device__ WarpBlockPlace(const OwnRasterBlock& raster_block, unsigned part) {
    x = raster_block.x + int(part % 2 * warp_block_side);
    y = raster_block.y + int(part / 2 * warp_block_side);
    const PlaceInWarpBlock first(pixel_of_warp_block(0));
    column = int(first.column), row = int(first.row);
  }
  __device__ bool outside(const FrameView& frame) const { return x >= frame.width || y >= frame.height; }
  /// In the image.
  __device__ vec2 first_centre(const View& view) const {
    return vec2(float(view.left() + x) + 0.5f, float(view.top() + y) + 0.5f);
  }
  /// The lane's p-th pixel.
  __device__ PixelPlace pixel(const FrameView& frame, unsigned p, bool extras) const {
    return PixelPlace(frame, x + column + int(p * columns_between), y + row, extras);
  }
};

/// Writes a pixel, if it lies in the image, from colour and depth in units of alpha_max. All kernels round
/// alike.
__device__ inline void store_relative(const View& view, const PixelPlace& at, BlendedPixel pixel) {
  if (!at.inside) return;
  const float alpha_max = view.rules.alpha_max;
  for (int c = 0; c < 3; ++c) pixel.colour[c] = multiply_rounded(pixel.colour[c], alpha_max);
  pixel.depth = multiply_rounded(pixel.depth, alpha_max);
  store_pixel(view.frame, std::size_t(at.x), std::size_t(at.y), pixel, view.background);
}

/// Where a traversal was when a segment ended.
struct SegmentEnd {
  std::uint32_t at;       ///< the next intersection to visit
  std::uint32_t waiting;  ///< splats before it that wait for the next segment
};

/// Why a traversal does not go on.
enum class Pause {
  at_segment,  ///< a segment has ended
  at_limit,    ///< the list is visited up to the limit; splats may wait
  stopped,     ///< all pixels have stopped
};

/// A traversal along a tile's list for one part: queues the splats that touch it, and lets a blender blend
/// them front to back, half a queue at a time, until all its pixels have stopped. The blender fills the rest
/// of a slot, beside the terms.
template <class Exponent>
class ListTraversal {
 public:
  __device__ ListTraversal(const RasterJob& job, TileRange range, vec2 first_centre, const BlendRules& rules,
                           TermsQueue<Exponent>& queue)
      : job_(&job),
        range_(range),
        first_centre_(first_centre),
        rules_(&rules),
        queue_(&queue),
        some_hidden_(job.colours.some_hidden()),
        at_(range.begin) {
    // Shapes are asked for a step ahead, and their ids two.
    next_id_ = load_id(at_), later_id_ = load_id(at_ + warp_size);
    if (at_ < range.end) next_shape_ = load_shape(job, next_id_);
  }

  /// Goes on until a pause: at segments, if the blender wants them, and at position `limit` of the list.
  template <class Blender>
  __device__ Pause go_on(Blender& blender, std::uint32_t limit) {
    while (at_ < limit) {
      const std::uint32_t id = next_id_;
      const SplatShape shape = next_shape_;
      const bool listed = at_ + lane_index() < range_.end;
      at_ += warp_size;
      next_id_ = later_id_;
      if (at_ < range_.end) next_shape_ = load_shape(*job_, next_id_);
      later_id_ = load_id(at_ + warp_size);

      // Queue those that touch the part.
      const bool touches = listed && this->touches(id, shape);
      const unsigned lanes = __ballot_sync(whole_warp, touches);
      if (touches) {
        const unsigned slot =
            (begun_ * queue_half + waiting_ + unsigned(__popc(lanes & lanes_below()))) % queue_size;
        blender.fill(slot, id);
        Exponent::prepare(shape, shape.mean - first_centre_, *rules_, queue_->terms[slot],
                          queue_->rests[slot]);
      }
      waiting_ += unsigned(__popc(lanes));

      // Blend half a queue at a time.
      if (waiting_ >= queue_half) {
        blender.await_queued();
        blender.blend_queued(begun_ % 2 * queue_half, queue_half);
        ++begun_, waiting_ -= queue_half;
        if (Blender::in_segments && segment_has_ended()) return Pause::at_segment;
        if (blender.all_stopped()) {
          drop_rest();
          return Pause::stopped;
        }
      }
    }
    return Pause::at_limit;
  }

  /// Blends what waits. The traversal cannot go on.
  template <class Blender>
  __device__ void blend_rest(Blender& blender) const {
    if (waiting_ == 0) return;
    blender.await_queued();
    blender.blend_queued(begun_ % 2 * queue_half, waiting_);
  }

  /// Leaves alone what waits. The traversal cannot go on.
  __device__ void drop_rest() { waiting_ = 0; }

  /// Segments that have ended.
  __device__ std::uint32_t segments() const {
    return begun_ < halves_of_first_segment ? 0 : 1 + (begun_ - halves_of_first_segment) / halves_of_segment;
  }
  /// Splats that are blended, with those that wait.
  __device__ std::uint32_t blended() const { return begun_ * queue_half + waiting_; }
  /// Intersections that were visited.
  __device__ std::uint32_t visited() const { return min(at_, range_.end) - range_.begin; }
  /// Intersections that are still to visit.
  __device__ std::uint32_t left() const { return range_.end - min(at_, range_.end); }
  /// The next splat to visit.
  __device__ ResumeAt here() const { return {at_, 0}; }
  /// The traversal as it is after a pause at a segment.
  __device__ SegmentEnd segment_end() const { return {at_, waiting_}; }
  /// The first splat behind the segment that ended there. All that waited were of the last step.
  __device__ ResumeAt behind(const SegmentEnd& end) const {
    const std::uint32_t last = end.at - warp_size, id = load_id(last);
    const bool touches = last + lane_index() < range_.end && this->touches(id, load_shape(*job_, id));
    return {last, unsigned(__popc(__ballot_sync(whole_warp, touches))) - end.waiting};
  }

 private:
  __device__ std::uint32_t load_id(std::uint32_t at) const {
    return at + lane_index() < range_.end ? job_->lists.ids[at + lane_index()] : 0;
  }
  __device__ bool touches(std::uint32_t id, const SplatShape& shape) const {
    return box_touched(shape, first_centre_, float(warp_block_side)) &&
           !(some_hidden_ && is_hidden(job_->colours.each[id]));
  }
  __device__ bool segment_has_ended() const {
    return begun_ >= halves_of_first_segment && begun_ % halves_of_segment == 0;
  }

  const RasterJob* job_;
  TileRange range_;
  vec2 first_centre_;
  const BlendRules* rules_;
  TermsQueue<Exponent>* queue_;
  bool some_hidden_;
  std::uint32_t at_, next_id_, later_id_;
  SplatShape next_shape_;
  // Splats put into the queue are `begun_` halves, and `waiting_` more.
  std::uint32_t begun_ = 0, waiting_ = 0;
};

__device__ inline ThreadCounts sum(const ThreadCounts (&of_pixels)[pixels_of_lane]) {
  ThreadCounts all;
  for (const ThreadCounts& one : of_pixels) all.pairs += one.pairs, all.stopped += one.stopped;
  return all;
}

/// Whether none of the warp's pixels is left that could show another splat.
template <unsigned count>
__device__ bool all_stopped(const Pixel (&pixels)[count]) {
  bool stopped = true;
  for (const Pixel& pixel : pixels) stopped = stopped && !pixel.live();
  return __all_sync(whole_warp, stopped);
}

/// Terms and colours of splats, as their part sees them.
template <class Exponent>
struct Queue : TermsQueue<Exponent> {
  float4 colours[queue_size];  ///< RGB, depth
};

/// Blends splats of a queue into pixels of a lane: into both, or into one.
template <class Exponent, bool threshold, bool extras, unsigned pixel_count>
struct LaneBlender {
  BlendRules rules;
  float x, y, right;  ///< the first pixel within the part; one pixel lies `right` columns to the right of it
  Pixel pixels[pixel_count];
  float occluders[pixel_count];
  ThreadCounts counts[pixel_count];

  /// Blends `count` splats from `first` on: whole groups, but with `extras` any number.
  __device__ void blend_queued(const Queue<Exponent>& queue, unsigned first, unsigned count) {
    if constexpr (extras) {
      for (unsigned k = first; k < first + count; ++k) {
        float alphas[pixel_count];
        evaluate(queue.terms[k], queue.rests[k], alphas);
#pragma unroll
        for (unsigned p = 0; p < pixel_count; ++p) {
          const float before = pixels[p].transmittance;
          const float left = Pixel::dimmed_relative(before, alphas[p] * before, rules.alpha_max);
          blend<true>(pixels[p], alphas[p], left, queue.colours[k], occluders[p], counts[p]);
        }
      }
    } else {
      // Pointers, which the loop advances: an index would be multiplied in each round.
      const float4 *terms = queue.terms + first, *colours = queue.colours + first;
      const typename Exponent::Rest* rests = queue.rests + first;
#pragma unroll 1
      for (unsigned k = 0; k < count; k += group_size) {
        blend_group(terms, rests, colours);
        terms += group_size, rests += group_size, colours += group_size;
      }
    }
  }

  __device__ bool all_stopped() const { return kernels::all_stopped(pixels); }

 private:
  /// Alphas of the pixels for a splat, in units of alpha_max.
  __device__ void evaluate(const float4& terms, const typename Exponent::Rest& rest,
                           float (&alphas)[pixel_count]) const {
    float exponents[pixel_count];
    if constexpr (pixel_count == 1)
      exponents[0] = Exponent::evaluate_one(terms, rest, x, y, right);
    else
      Exponent::evaluate(terms, rest, x, y, exponents);
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) alphas[p] = relative_alpha<threshold>(exponents[p], rules);
  }

  __device__ void blend_group(const float4* terms, const typename Exponent::Rest* rests,
                              const float4* colours) {
    float alphas[pixel_count][group_size], weights[pixel_count][group_size];
#pragma unroll
    for (unsigned k = 0; k < group_size; ++k) {
      float of_splat[pixel_count];
      evaluate(terms[k], rests[k], of_splat);
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) alphas[p][k] = of_splat[p];
    }
    weigh_group(pixels, alphas, rules.alpha_max, weights);

#pragma unroll
    for (unsigned k = 0; k < group_size; ++k) {
      const float4 colour = colours[k];
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) pixels[p].add(weights[p][k], colour.x, colour.y, colour.z);
    }
  }
};

/// Asks for the colour of a splat that is put into a queue.
template <class Exponent>
__device__ void fetch_colour(const RasterJob& job, Queue<Exponent>& queue, unsigned slot, std::uint32_t id) {
  __pipeline_memcpy_async(&queue.colours[slot], job.colours.each.data + id, sizeof(float4));
}

/// Blends colours into a part, and holds the pixels of this lane in it.
template <class Exponent, bool threshold, bool extras>
struct ColourBlender {
  static constexpr bool in_segments = true;
  const RasterJob& job;
  Queue<Exponent>& queue;
  LaneBlender<Exponent, threshold, extras, pixels_of_lane> lane;

  __device__ void fill(unsigned slot, std::uint32_t id) const { fetch_colour(job, queue, slot, id); }

  /// Waits for the splats that were queued.
  __device__ void await_queued() const {
    __pipeline_commit();
    __pipeline_wait_prior(0);
    __syncwarp();
  }

  /// Blends `count` splats from `first` on; room after them is there to be overwritten.
  __device__ void blend_queued(unsigned first, unsigned count) {
    // Fill the last group up with splats that show nothing.
    if constexpr (!extras) {
      if (lane_index() < (group_size - count % group_size) % group_size) {
        const unsigned at = first + count + lane_index();
        Exponent::clear(queue.terms[at], queue.rests[at]);
        queue.colours[at] = make_float4(0, 0, 0, 0);
      }
      __syncwarp();
    }
    lane.blend_queued(queue, first, count);
    __syncwarp();
  }

  __device__ bool all_stopped() const { return lane.all_stopped(); }
};

/// Keeps `variable` in memory, and so out of the registers that the traversal needs.
template <class T>
__device__ T& in_memory(T& variable) {
  T* at = &variable;
  asm volatile("" : "+l"(at));
  return *at;
}

/// A traversal at the end of its last segment.
template <bool extras>
struct TraversedSegments {
  JoinedPixels<extras, pixels_of_lane> pixels;
  SegmentEnd end;
  std::uint32_t pairs, stopped;  ///< of this lane, with `extras`
};

/// Joins the segments of a traversal.
template <class Exponent, bool threshold, bool extras>
struct SegmentJoiner {
  LaneBlender<Exponent, threshold, extras, pixels_of_lane>& lane;
  TraversedSegments<extras>& traversed;

  /// Joins segment k, which ended there, with those in front of it, and begins the next.
  __device__ void end_segment(std::uint32_t k, const SegmentEnd& end) const {
    traversed.end = end;
    if constexpr (extras) {
      const ThreadCounts counts = sum(lane.counts);
      traversed.pairs = counts.pairs, traversed.stopped = counts.stopped;
    }
    join_segment(k);
  }

  /// Joins what there is of segment k, the last, and has the pixels show all segments.
  __device__ void end(std::uint32_t k, bool is_empty) const {
    if (k == 0) return;
    if (!is_empty) join_segment(k);
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) lane.pixels[p] = traversed.pixels.load(p).stopped();
  }

  /// Leaves the rest of a list to another block, after so many segments and splats. A segment behind the
  /// first that has not ended is left to it as a whole.
  __device__ void push(WorkItem& part, RasterBlockIndex raster_block, ResumeAt at, std::uint32_t segments,
                       std::uint32_t blended) const {
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      const Pixel& pixel = lane.pixels[p];
      JoinedPixel all;
      bool was_live;
      if (segments == 0)
        all.join(pixel.blended(), 0), was_live = pixel.live();
      else
        all = traversed.pixels.load(p), was_live = pixel.stop_below != had_stopped;
      part.joined.store(pixel_of_warp_block(p), all);
      const unsigned live = __ballot_sync(whole_warp, was_live);
      if (lane_index() == 0) part.live[p] = live;
    }
    if (lane_index() == 0) {
      part.segments = segments, part.blended = blended;
      part.raster_block = raster_block, part.part = threadIdx.x / warp_size;
      part.at = at;
    }
    // Others count what is left to them.
    if constexpr (extras)
      if (segments != 0) lane.counts[0] = {traversed.pairs, traversed.stopped}, lane.counts[1] = {};
  }

 private:
  /// Joins segment k with those in front of it, and begins the next.
  __device__ void join_segment(std::uint32_t k) const {
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      Pixel& pixel = lane.pixels[p];
      JoinedPixel all = k == 0 ? JoinedPixel() : traversed.pixels.load(p);
      const bool live = pixel.live();
      if (pixel.stop_below != had_stopped) all.join(pixel.blended(), k);
      traversed.pixels.store(p, all);
      pixel = {};
      if (live)
        start_segment(pixel, lane.rules.stop_below, all.total.w, k + 1);
      else
        pixel.stop_below = had_stopped;
    }
  }

  /// `stop_below` of a pixel that had stopped before the segment, and has no part in it.
  static constexpr float had_stopped = -INFINITY;
};

/// Blends the list of one raster block: one thread block per raster block, one warp per 8x8 warp block of it.
/// If `shared`, rests of long lists are left to others.
template <class Exponent, bool threshold, bool extras, bool shared, class ViewSource>
__global__ void __launch_bounds__(raster_threads, Exponent::blocks)
    raster_warps(const __grid_constant__ RasterInput<ViewSource> input,
                 const __grid_constant__ WorkQueues work_queues, std::uint32_t warps_at_once) {
  if constexpr (shared) let_next_start();
  __shared__ Queue<Exponent> queues[warps_of_raster_block];
  const unsigned warp = threadIdx.x / warp_size;
  const RasterJob& job = input.job;
  const WarpTimer timer(extras && job.counts, warps_at_once);
  const OwnRasterBlock raster_block(input);
  const View& view = input.views[raster_block.view];
  const BlendRules rules = view.rules;
  const WarpBlockPlace part(raster_block, warp);
  if (part.outside(view.frame)) return;

  ColourBlender<Exponent, threshold, extras> blender{
      job, queues[warp], {rules, float(part.column), float(part.row), 0, {}, {}, {}}};
#pragma unroll
  for (unsigned p = 0; p < pixels_of_lane; ++p) {
    const PixelPlace at = part.pixel(view.frame, p, extras);
    if (at.inside) blender.lane.pixels[p].start(rules.stop_below);
    if constexpr (extras) blender.lane.occluders[p] = at.occluder;
  }

  const TileRange range = raster_block.list(input);
  if (!range.drawn()) return;
  ListTraversal<Exponent> traversal(job, range, part.first_centre(view), rules, queues[warp]);
  TraversedSegments<extras> traversed;
  const SegmentJoiner<Exponent, threshold, extras> joiner{blender.lane, in_memory(traversed)};
  WorkItem* handed_over = nullptr;
  while (!handed_over) {
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
      handed_over = work_queues.reserve_item(traversal.blended(), traversal.visited(), traversal.left());
  }
  if constexpr (!shared) work_queues.end_traversal(traversal.blended(), traversal.visited());
  // Others go on from the end of the last segment, or from within the first: what waits is theirs, or
  // blended.
  if (handed_over && traversal.segments() != 0) traversal.drop_rest();
  traversal.blend_rest(blender);

  if (handed_over) {
    const ResumeAt next =
        traversal.segments() == 0 ? traversal.here() : traversal.behind(joiner.traversed.end);
    joiner.push(*handed_over, OwnRasterBlock::index(input), next, traversal.segments(), traversal.blended());
    work_queues.push(handed_over);
  } else {
    joiner.end(traversal.segments(), traversal.blended() == begin_of_segment(traversal.segments()));
    // Found again: kept in registers during the traversal, places would cost a block in nine.
    const WarpBlockPlace same(OwnRasterBlock(input), threadIdx.x / warp_size);
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p)
      store_relative(view, same.pixel(view.frame, p, extras), blender.lane.pixels[p].blended());
  }
  if constexpr (extras)
    if (job.counts)
      add_counts(job.counts[OwnRasterBlock::number(input)],
                 counts_of_warp(sum(blender.lane.counts), traversal.visited(),
                                traversal.blended() * pixels_of_warp_block, timer));
}
}  // namespace kernels

}  // namespace swiftgs
