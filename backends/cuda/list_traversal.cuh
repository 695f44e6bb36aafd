// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/cuda/warp.cuh>

#include "exponents.hpp"
#include "work_queue.cuh"

namespace swiftgs::kernels {

/// A raster block has four warp blocks of 8x8 pixels. Each warp traverses the tile list by itself and never
/// waits for another. A lane has two pixels of one row, four columns apart.
inline constexpr unsigned warps_of_raster_block = 4;
inline constexpr unsigned raster_threads = warps_of_raster_block * warp_size;

/// A warp queues splats that touch its warp block until there are enough to blend. The queue is a ring of two
/// halves: a warp fills one while it blends the other.
inline constexpr unsigned queue_half = 32, queue_size = 2 * queue_half;
inline constexpr unsigned halves_of_first_segment = first_segment_size / queue_half;
inline constexpr unsigned halves_of_segment = segment_size / queue_half;
static_assert(halves_of_first_segment % halves_of_segment == 0);

/// Exponents of queued splats, relative to the warp block.
///
/// A warp has one queue. Measured on an H200 when chosen: rasterizing garden takes 141 us so, 172 if each
/// half of the warp has a queue, and 197 if each quarter has. Then lanes read several addresses of shared
/// memory, and its wavefronts become the limit.
///
/// What pixels of a row share is not stored. If it is, rasterizing takes 133 us, not 136, in garden, but 699,
/// not 654, in `builtin:4000000`, where the warp of a long list waits longer (measured likewise).
template <class Exponent>
struct TermsQueue {
  float4 terms[queue_size];
  typename Exponent::Rest rests[queue_size];
};

/// A warp block in its frame, and this lane's pixels in it.
struct WarpBlock {
  int x, y;         ///< first pixel
  int column, row;  ///< of the lane's first pixel within the warp block

  __device__ WarpBlock(const OwnRasterBlock& raster_block, unsigned number) {
    x = raster_block.x + int(number % 2 * warp_block_side);
    y = raster_block.y + int(number / 2 * warp_block_side);
    const PixelOfWarpBlock first(pixel_of_warp_block(0));
    column = int(first.column), row = int(first.row);
  }
  __device__ bool outside(const FrameView& frame) const { return x >= frame.width || y >= frame.height; }
  /// Centre of the first pixel in the image.
  __device__ vec2 first_centre(const View& view) const {
    return vec2(float(view.left() + x) + 0.5f, float(view.top() + y) + 0.5f);
  }
  /// The lane's p-th pixel.
  __device__ FramePixel pixel(const FrameView& frame, unsigned p, bool extras) const {
    return FramePixel(frame, x + column + int(p * columns_between), y + row, extras);
  }
};

/// State of a traversal at the end of a segment.
struct SegmentEnd {
  std::uint32_t at;       ///< the next intersection to visit
  std::uint32_t waiting;  ///< queued splats before it, which belong to the next segment
};

/// Why a traversal pauses.
enum class Pause {
  at_segment,  ///< a segment ended
  at_limit,    ///< the list is visited up to the limit; splats may be queued
  stopped,     ///< all pixels stopped
};

/// One warp's traversal of a tile list. It queues the splats that touch the warp block. A blender blends them
/// front to back, half a queue at a time, until all pixels stopped. The blender fills the rest of a slot.
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
        some_colourless_(job.colours.some_colourless()),
        at_(range.begin) {
    // Load shapes one step ahead, and their ids two.
    next_id_ = load_id(at_), later_id_ = load_id(at_ + warp_size);
    if (at_ < range.end) next_shape_ = load_shape(job.splats, next_id_);
  }

  /// Resumes until the next pause: at the end of a segment if `Blender::in_segments`, and at position
  /// `limit`.
  template <class Blender>
  __device__ Pause go_on(Blender& blender, std::uint32_t limit) {
    while (at_ < limit) {
      const std::uint32_t id = next_id_;
      const SplatShape shape = next_shape_;
      const bool listed = at_ + lane_index() < range_.end;
      at_ += warp_size;
      next_id_ = later_id_;
      if (at_ < range_.end) next_shape_ = load_shape(job_->splats, next_id_);
      later_id_ = load_id(at_ + warp_size);

      // Queue those that touch the warp block.
      const bool touches = listed && this->touches(id, shape);
      const unsigned lanes = __ballot_sync(whole_warp, touches);
      if (touches) {
        const unsigned slot =
            (begun_ * queue_half + waiting_ + unsigned(__popc(lanes & lanes_below()))) % queue_size;
        blender.fill(slot, id);
        Exponent::prepare(shape, shape.from_mean(first_centre_), relative_log2_opacity(shape, *rules_),
                          queue_->terms[slot], queue_->rests[slot]);
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

  /// Blends queued splats. Ends the traversal.
  template <class Blender>
  __device__ void blend_rest(Blender& blender) const {
    if (waiting_ == 0) return;
    blender.await_queued();
    blender.blend_queued(begun_ % 2 * queue_half, waiting_);
  }

  /// Drops queued splats. Ends the traversal.
  __device__ void drop_rest() { waiting_ = 0; }

  /// Segments that ended.
  __device__ std::uint32_t segments() const {
    return begun_ < halves_of_first_segment ? 0 : 1 + (begun_ - halves_of_first_segment) / halves_of_segment;
  }
  /// Splats blended or queued.
  __device__ std::uint32_t blended() const { return begun_ * queue_half + waiting_; }
  /// Intersections visited.
  __device__ std::uint32_t visited() const { return min(at_, range_.end) - range_.begin; }
  /// Intersections not yet visited.
  __device__ std::uint32_t left() const { return range_.end - min(at_, range_.end); }
  /// The next splat to visit.
  __device__ ResumeAt here() const { return {at_, 0}; }
  /// State after a pause at a segment.
  __device__ SegmentEnd segment_end() const { return {at_, waiting_}; }
  /// The first splat behind the segment that ended there. All queued ones were of the last step.
  __device__ ResumeAt behind(const SegmentEnd& end) const {
    const std::uint32_t last = end.at - warp_size, id = load_id(last);
    const bool touches = last + lane_index() < range_.end && this->touches(id, load_shape(job_->splats, id));
    return {last, unsigned(__popc(__ballot_sync(whole_warp, touches))) - end.waiting};
  }

 private:
  __device__ std::uint32_t load_id(std::uint32_t at) const {
    return at + lane_index() < range_.end ? job_->lists.ids[at + lane_index()] : 0;
  }
  __device__ bool touches(std::uint32_t id, const SplatShape& shape) const {
    return box_touched(shape, first_centre_, float(warp_block_side)) &&
           !(some_colourless_ && is_colourless(job_->colours.each[id]));
  }
  __device__ bool segment_has_ended() const {
    return begun_ >= halves_of_first_segment && begun_ % halves_of_segment == 0;
  }

  const RasterJob* job_;
  TileRange range_;
  vec2 first_centre_;
  const BlendRules* rules_;
  TermsQueue<Exponent>* queue_;
  bool some_colourless_;
  std::uint32_t at_, next_id_, later_id_;
  SplatShape next_shape_;
  // Splats queued so far: `begun_` halves and `waiting_` more.
  std::uint32_t begun_ = 0, waiting_ = 0;
};

}  // namespace swiftgs::kernels
