// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda_pipeline_primitives.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>

#include "box_touched.hpp"
#include "forms.hpp"
#include "long_parts.cuh"
#include "pixel.cuh"

namespace swiftgs {

namespace kernels {

/// A square is four parts, each a warp's own: it walks the list by itself and never waits for the others. A
/// lane has two pixels of one column, four rows apart.
inline constexpr unsigned parts_of_square = 4;
inline constexpr unsigned raster_threads = parts_of_square * warp_size;

/// Splats that touch a part wait here until there are enough to blend: a ring of two halves, so that one can
/// be filled while the other is blended.
inline constexpr unsigned queue_half = 32, queue_size = 2 * queue_half;
inline constexpr unsigned halves_of_first_piece = first_piece_size / queue_half;
inline constexpr unsigned halves_of_piece = piece_size / queue_half;
static_assert(halves_of_first_piece % halves_of_piece == 0);

/// Terms of splats, as their part sees them.
template <class Form>
struct TermsQueue {
  float4 terms[queue_size];
  typename Form::Rest rests[queue_size];
};

/// Where a warp's part lies in its frame, and this lane's pixels in it.
struct PartPlace {
  int x, y;         ///< first pixel
  int column, row;  ///< of the lane's first pixel within the part

  __device__ PartPlace(const BlockSquare& square, unsigned part) {
    x = square.x + int(part % 2 * part_side);
    y = square.y + int(part / 2 * part_side);
    column = int(lane_index() % part_side), row = int(lane_index() / part_side);
  }
  __device__ bool outside(const FrameView& frame) const { return x >= frame.width || y >= frame.height; }
  /// In the image.
  __device__ vec2 first_centre(const View& view) const {
    return vec2(float(view.left() + x) + 0.5f, float(view.top() + y) + 0.5f);
  }
  /// The lane's p-th pixel.
  __device__ PixelPlace pixel(const FrameView& frame, unsigned p, bool extras) const {
    return PixelPlace(frame, x + column, y + row + int(p) * int(rows_between), extras);
  }
};

/// How far a part's walk came: instances of the list, and splats that were blended.
struct Walked {
  std::uint32_t visited = 0, blended = 0;
};

/// Walks a tile's list for one part: queues the splats that touch it, and lets `blender` blend them front to
/// back, half a queue at a time, until all its pixels have stopped. The blender fills the rest of a slot,
/// beside the terms. One that blends in pieces is told where a piece ends, and may hand the rest of the list
/// over to others.
template <class Form, class Blender>
__device__ Walked walk_list(const RasterJob& job, TileRange range, vec2 first_centre, const BlendRules& rules,
                            TermsQueue<Form>& queue, Blender& blender) {
  const bool some_hidden = job.colours.some_hidden();
  const auto load_id = [&](std::uint32_t at) {
    return at + lane_index() < range.end ? job.lists.ids[at + lane_index()] : 0;
  };
  // Splats put into the queue are `begun` halves, and `waiting` more.
  std::uint32_t begun = 0, waiting = 0, blended = 0;
  std::uint32_t at = range.begin;
  if (at < range.end) {
    // Shapes are asked for a step ahead, and their ids two.
    std::uint32_t next_id = load_id(at), later_id = load_id(at + warp_size);
    SplatShape next_shape = load_shape(job, next_id);
    while (at < range.end) {
      const std::uint32_t id = next_id;
      const SplatShape shape = next_shape;
      const bool listed = at + lane_index() < range.end;
      at += warp_size;
      next_id = later_id;
      if (at < range.end) next_shape = load_shape(job, next_id);
      later_id = load_id(at + warp_size);

      // Queue those that touch the part.
      bool touched = listed && box_touched(shape, first_centre, float(part_side));
      if (some_hidden) touched = touched && !is_hidden(job.colours.each[id]);
      const unsigned lanes = __ballot_sync(whole_warp, touched);
      if (touched) {
        const unsigned slot =
            (begun * queue_half + waiting + unsigned(__popc(lanes & lanes_below()))) % queue_size;
        blender.fill(slot, id);
        Form::prepare(shape, shape.mean - first_centre, rules.log2_alpha_min, queue.terms[slot],
                      queue.rests[slot]);
      }
      waiting += unsigned(__popc(lanes));

      // Blend half a queue at a time.
      if (waiting >= queue_half) {
        blender.await_queued();
        blender.blend_queued(begun % 2 * queue_half, queue_half);
        ++begun, waiting -= queue_half, blended += queue_half;
        if (blender.all_stopped()) {
          waiting = 0;
          break;
        }
        if constexpr (Blender::in_pieces)
          if (begun >= halves_of_first_piece && begun % halves_of_piece == 0) {
            blender.end_piece();
            // The next splat to blend is among those of this step.
            const std::uint32_t step = at - warp_size;
            if (blender.hand_over({step, unsigned(__popc(lanes)) - waiting}, range, blended)) {
              waiting = 0;
              break;
            }
          }
      }
    }
    if (waiting != 0) {
      blender.await_queued();
      blender.blend_queued(begun % 2 * queue_half, waiting);
      blended += waiting;
    }
  }
  return {min(at, range.end) - range.begin, blended};
}

__device__ inline ThreadCounts sum(const ThreadCounts (&of_pixels)[pixels_of_lane]) {
  ThreadCounts all;
  for (const ThreadCounts& one : of_pixels) all.pairs += one.pairs, all.stopped += one.stopped;
  return all;
}

/// Whether no pixel of the part is left that could show another splat.
__device__ inline bool all_stopped(const Pixel (&pixels)[pixels_of_lane]) {
  bool stopped = true;
  for (const Pixel& pixel : pixels) stopped = stopped && !pixel.live();
  return __all_sync(whole_warp, stopped);
}

/// Terms and colours of splats, as their part sees them.
template <class Form>
struct Queue : TermsQueue<Form> {
  float4 colours[queue_size];  ///< RGB, depth
};

/// Blends colours into a part, and holds the pixels of this lane in it.
template <class Form, bool threshold, bool extras>
struct ColourBlender {
  static constexpr bool in_pieces = true;
  const RasterJob& job;
  const BlendRules& rules;
  Queue<Form>& queue;
  JoinedPart<extras>& joined;  ///< of the pieces before this one
  const LongWork& others;
  float x, y;  ///< of the lane's first pixel within the part
  Pixel pixels[pixels_of_lane];
  float occluders[pixels_of_lane];
  ThreadCounts counts[pixels_of_lane];
  std::uint32_t pieces = 0;  ///< joined
  bool handed_over = false;

  __device__ void fill(unsigned slot, std::uint32_t id) const {
    __pipeline_memcpy_async(&queue.colours[slot], job.colours.each.data + id, sizeof(float4));
  }

  /// Waits for the splats that were queued.
  __device__ void await_queued() const {
    __pipeline_commit();
    __pipeline_wait_prior(0);
    __syncwarp();
  }

  __device__ JoinedPixel joined_pixel(unsigned p) const { return joined.load(pixel_of_part(p)); }

  /// Joins a piece with those in front of it, and begins the next.
  __device__ void end_piece() {
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      JoinedPixel all;
      if (pieces != 0) all = joined_pixel(p);
      // One that had stopped before has no part in the piece.
      if (pixels[p].last >= 0) all.join(pixels[p].blended(), pieces);
      joined.store(pixel_of_part(p), all);
      const bool live = pixels[p].live();
      pixels[p] = {};
      if (live)
        start_piece(pixels[p], rules.stop_below, all.total.w, pieces + 1);
      else
        pixels[p].last = -1;
    }
    ++pieces;
  }

  /// Leaves the rest of a long list to other blocks, where they have room for it.
  __device__ bool hand_over(ResumeAt at, TileRange list, std::uint32_t blended) {
    LongPart* const part = others.take(blended, list.end - at.position);
    if (!part) return false;
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      part->joined.store(pixel_of_part(p), joined_pixel(p));
      const unsigned live = __ballot_sync(whole_warp, pixels[p].live());
      if (lane_index() == 0) part->live[p] = live;
    }
    if (lane_index() == 0) {
      part->pieces = pieces;
      part->column = blockIdx.x, part->row = BlockSquare::row(), part->part = threadIdx.x / warp_size;
      part->at = at;
    }
    return handed_over = true;
  }

  /// Alphas of the lane's pixels for a splat.
  __device__ void evaluate(const float4& terms, const typename Form::Rest& rest,
                           float (&alphas)[pixels_of_lane]) const {
    float exponents[pixels_of_lane];
    Form::evaluate(terms, rest, x, y, exponents);
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) alphas[p] = alpha_of<threshold>(exponents[p], rules);
  }

  /// Blends `group_size` splats. Pointers, which a loop over groups advances: an index would be multiplied in
  /// each round.
  __device__ void blend_group(const float4* terms, const typename Form::Rest* rests, const float4* colours) {
    float alphas[pixels_of_lane][group_size], weights[pixels_of_lane][group_size];
#pragma unroll
    for (unsigned k = 0; k < group_size; ++k) {
      float of_splat[pixels_of_lane];
      evaluate(terms[k], rests[k], of_splat);
#pragma unroll
      for (unsigned p = 0; p < pixels_of_lane; ++p) alphas[p][k] = of_splat[p];
    }
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) weigh_group(pixels[p], alphas[p], weights[p]);

#pragma unroll
    for (unsigned k = 0; k < group_size; ++k) {
      const float4 colour = colours[k];
#pragma unroll
      for (unsigned p = 0; p < pixels_of_lane; ++p)
        pixels[p].add(weights[p][k], colour.x, colour.y, colour.z);
    }
  }

  /// Blends `count` splats from `first` on; room after them is there to be overwritten.
  __device__ void blend_queued(unsigned first, unsigned count) {
    if constexpr (extras) {
      for (unsigned k = first; k < first + count; ++k) {
        float alphas[pixels_of_lane];
        evaluate(queue.terms[k], queue.rests[k], alphas);
#pragma unroll
        for (unsigned p = 0; p < pixels_of_lane; ++p)
          blend<true>(pixels[p], alphas[p], queue.colours[k], occluders[p], counts[p]);
      }
    } else {
      // Fill the last group up with splats that show nothing.
      if (lane_index() < (group_size - count % group_size) % group_size) {
        const unsigned at = first + count + lane_index();
        Form::clear(queue.terms[at], queue.rests[at]);
        queue.colours[at] = make_float4(0, 0, 0, 0);
      }
      __syncwarp();
      const float4 *terms = queue.terms + first, *colours = queue.colours + first;
      const typename Form::Rest* rests = queue.rests + first;
#pragma unroll 1
      for (unsigned k = 0; k < count; k += group_size) {
        blend_group(terms, rests, colours);
        terms += group_size, rests += group_size, colours += group_size;
      }
    }
    __syncwarp();
  }

  __device__ bool all_stopped() const { return kernels::all_stopped(pixels); }
};

/// Blends the list of one square: a block a square, a warp a part of it. Long parts are left to `others`.
template <class Form, bool threshold, bool extras, class ViewSource>
__global__ void __launch_bounds__(raster_threads, Form::blocks)
    raster_warps(const __grid_constant__ RasterInput<ViewSource> input,
                 const __grid_constant__ LongWork others) {
  __shared__ Queue<Form> queues[parts_of_square];
  __shared__ JoinedPart<extras> joined[parts_of_square];
  const unsigned warp = threadIdx.x / warp_size;
  const RasterJob& job = input.job;
  const BlockSquare square(input);
  const View& view = input.views[square.view];
  const BlendRules rules = view.rules;
  const PartPlace part(square, warp);
  if (part.outside(view.frame)) return;

  ColourBlender<Form, threshold, extras> blender{
      job, rules, queues[warp], joined[warp], others, float(part.column), float(part.row), {}, {}, {}};
#pragma unroll
  for (unsigned p = 0; p < pixels_of_lane; ++p) {
    const PixelPlace at = part.pixel(view.frame, p, extras);
    if (at.inside) blender.pixels[p].start(rules.stop_below);
    if constexpr (extras) blender.occluders[p] = at.occluder;
  }

  const TileRange range = square.list(input);
  if (!range.drawn()) return;
  const Walked walked = walk_list<Form>(job, range, part.first_centre(view), rules, queues[warp], blender);

  if (!blender.handed_over) {
    // Found again: kept in registers during the walk, places would cost a block in nine.
    const PartPlace same(BlockSquare(input), threadIdx.x / warp_size);
    if (blender.pieces != 0 && walked.blended != begin_of_piece(blender.pieces)) blender.end_piece();
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      const PixelPlace pixel = same.pixel(view.frame, p, extras);
      if (pixel.inside)
        store_pixel(view.frame, std::size_t(pixel.x), std::size_t(pixel.y),
                    blender.pieces != 0 ? blender.joined_pixel(p).blended() : blender.pixels[p].blended(),
                    view.background);
    }
  }
  if constexpr (extras)
    if (job.counts)
      add_counts(job.counts[BlockSquare::number()],
                 counts_of_warp(sum(blender.counts), walked.visited, walked.blended * pixels_of_part));
}
}  // namespace kernels

}  // namespace swiftgs
