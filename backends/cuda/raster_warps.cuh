// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda_pipeline_primitives.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>

#include "box_touched.hpp"
#include "forms.hpp"
#include "pixel.cuh"

namespace swiftgs {

namespace kernels {

/// A square is four parts of 8x8 pixels, each a warp's own: it walks the list by itself and never waits for
/// the others. A lane has two pixels of one column, four rows apart.
inline constexpr unsigned part_side = 8, parts_of_square = 4;
inline constexpr unsigned raster_threads = parts_of_square * warp_size;

/// Splats that touch a part wait here until there are enough to blend: a ring of two halves, so that one can
/// be filled while the other is blended.
inline constexpr unsigned queue_half = 32, queue_size = 2 * queue_half;

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

  __device__ explicit PartPlace(const BlockSquare& square) {
    const unsigned warp = threadIdx.x / warp_size;
    x = square.x + int(warp % 2 * part_side);
    y = square.y + int(warp / 2 * part_side);
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
/// beside the terms.
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
        blender.blend_queued(begun % 2 * queue_half, queue_half);
        ++begun, waiting -= queue_half, blended += queue_half;
        if (blender.all_stopped()) {
          waiting = 0;
          break;
        }
      }
    }
    if (waiting != 0) blender.blend_queued(begun % 2 * queue_half, waiting), blended += waiting;
  }
  return {min(at, range.end) - range.begin, blended};
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
  const RasterJob& job;
  const BlendRules& rules;
  Queue<Form>& queue;
  float x, y;  ///< of the lane's first pixel within the part
  Pixel pixels[pixels_of_lane];
  float occluders[pixels_of_lane];
  ThreadCounts counts;

  __device__ void fill(unsigned slot, std::uint32_t id) const {
    __pipeline_memcpy_async(&queue.colours[slot], job.colours.each.data + id, sizeof(float4));
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
    __pipeline_commit();
    __pipeline_wait_prior(0);
    __syncwarp();
    if constexpr (extras) {
      for (unsigned k = first; k < first + count; ++k) {
        float alphas[pixels_of_lane];
        evaluate(queue.terms[k], queue.rests[k], alphas);
#pragma unroll
        for (unsigned p = 0; p < pixels_of_lane; ++p)
          blend<true>(pixels[p], alphas[p], queue.colours[k], occluders[p], counts);
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

/// Blends the list of one square: a block a square, a warp a part of it.
template <class Form, bool threshold, bool extras, class ViewSource>
__global__ void __launch_bounds__(raster_threads, Form::blocks)
    raster_warps(const __grid_constant__ RasterInput<ViewSource> input) {
  __shared__ Queue<Form> queues[parts_of_square];
  Queue<Form>& queue = queues[threadIdx.x / warp_size];
  const RasterJob& job = input.job;
  const BlockSquare square(input);
  const View& view = input.views[square.view];
  const BlendRules rules = view.rules;
  const PartPlace part(square);
  if (part.outside(view.frame)) return;

  ColourBlender<Form, threshold, extras> blender{job, rules, queue, float(part.column), float(part.row),
                                                 {},  {},    {}};
#pragma unroll
  for (unsigned p = 0; p < pixels_of_lane; ++p) {
    const PixelPlace at = part.pixel(view.frame, p, extras);
    if (at.inside) blender.pixels[p].start(rules.stop_below);
    if constexpr (extras) blender.occluders[p] = at.occluder;
  }

  const TileRange range = square.list(input);
  if (!range.drawn()) return;
  const Walked walked = walk_list<Form>(job, range, part.first_centre(view), rules, queue, blender);

  // Found again: kept in registers during the walk, places would cost a block in nine.
  const PartPlace same{BlockSquare(input)};
#pragma unroll
  for (unsigned p = 0; p < pixels_of_lane; ++p) {
    const PixelPlace pixel = same.pixel(view.frame, p, extras);
    if (pixel.inside)
      store_pixel(view.frame, std::size_t(pixel.x), std::size_t(pixel.y), blender.pixels[p].blended(),
                  view.background);
  }
  if constexpr (extras)
    if (job.counts)
      add_counts(job.counts, blender.counts, walked.visited, walked.blended * part_side * part_side);
}

template <class Form, bool threshold>
struct WarpsKernel {
  static constexpr unsigned threads = raster_threads;
  template <bool extras, class ViewSource>
  static constexpr auto of = &raster_warps<Form, threshold, extras, ViewSource>;
};
}  // namespace kernels

/// Rasterizes with terms of `Form` in registers.
template <class Form, bool threshold>
void rasterize_warps(Cuda& cuda, const char* name, const RasterJob& job) {
  kernels::launch_squares<kernels::WarpsKernel<Form, threshold>>(cuda, name, job);
}

}  // namespace swiftgs
