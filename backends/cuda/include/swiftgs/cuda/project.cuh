// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <cuda_pipeline_primitives.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/footprints.cuh>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/running_sum.cuh>
#include <swiftgs/cuda/sh_words.hpp>
#include <swiftgs/project.hpp>

namespace swiftgs {

namespace kernels {
inline constexpr unsigned project_threads = 128;
inline constexpr unsigned project_warps = project_threads / warp_size;

/// Where projection writes to. `counts` are two, of this frame and of the next.
struct ProjectOutput {
  SplatShape* shapes;
  SplatColour* colours;
  Footprint* footprints;
  FrameCounts* counts;
};

/// What the threads of a block tell each other.
struct ProjectShared {
  std::uint32_t before;
  std::uint32_t visible[project_warps], tiles[project_warps];  ///< of each warp
  std::uint32_t ids[project_threads];                          ///< visible Gaussians of the block
  float depths[project_threads];                               ///< and their depths
  union {
    FootprintShared footprints[project_warps];
    float4 rest[project_warps]
               [warp_size * rest_pitch(max_sh_degree)];  ///< SH coefficients of each lane's Gaussian
  };
};

/// Copies the SH coefficients of the warp's Gaussians, `Word` by `Word`: lanes read neighbouring words, where
/// a lane a Gaussian would touch 32 lines with each load. All copies are under way at once.
template <class Word>
__device__ void stage_rest(const SceneView& scene, std::uint32_t id, unsigned gaussians, unsigned words,
                           unsigned pitch, Word* rest) {
  constexpr unsigned floats = sizeof(Word) / sizeof(float);
  unsigned gaussian = lane_index() / words, word = lane_index() % words;
  const unsigned gaussian_step = warp_size / words, word_step = warp_size % words;
  while (__any_sync(whole_warp, gaussian < gaussians)) {
    const std::uint32_t theirs = __shfl_sync(whole_warp, id, int(gaussian % warp_size));
    const float* from =
        scene.sh_rest.data + std::size_t(theirs) * std::size_t(scene.sh_stride) + word * floats;
    if (gaussian < gaussians) __pipeline_memcpy_async(rest + gaussian * pitch + word, from, sizeof(Word));
    gaussian += gaussian_step, word += word_step;
    if (word >= words) word -= words, ++gaussian;
  }
  __pipeline_commit();
  __pipeline_wait_prior(0);
  __syncwarp();
}

/// Copies the SH coefficients of the warp's Gaussians by quadruples where they are aligned, as those of
/// `Cuda::upload` are.
__device__ inline void stage_rest(const SceneView& scene, std::uint32_t id, unsigned gaussians,
                                  float4* rest) {
  const unsigned words = rest_words(scene.sh_degree), pitch = rest_pitch(scene.sh_degree);
  const std::size_t stride = std::size_t(scene.sh_stride);
  if (stride % 4 == 0 && stride >= 4 * words && scene.sh_rest.size >= scene.size() * stride &&
      reinterpret_cast<std::uintptr_t>(scene.sh_rest.data) % sizeof(float4) == 0)
    stage_rest<float4>(scene, id, gaussians, words, pitch, rest);
  else
    stage_rest<float>(scene, id, gaussians, 3 * unsigned(sh_rest_count(scene.sh_degree)), 4 * pitch,
                      reinterpret_cast<float*>(rest));
}

/// `sh_colour` with a degree that the compiler knows, so that coefficients and basis stay in registers.
template <int degree>
__device__ vec3 colour_of(vec3 sh0, const float4* words, vec3 direction) {
  if constexpr (degree == 0) {
    return sh_colour(0, sh0, nullptr, direction);
  } else {
    float rest[4 * rest_words(degree)];
#pragma unroll
    for (unsigned k = 0; k < rest_words(degree); ++k) {
      const float4 word = words[k];
      rest[4 * k] = word.x, rest[4 * k + 1] = word.y, rest[4 * k + 2] = word.z, rest[4 * k + 3] = word.w;
    }
    return sh_colour(degree, sh0, rest, direction);
  }
}
__device__ inline vec3 colour_of(int degree, vec3 sh0, const float4* rest, vec3 direction) {
  switch (degree) {
    case 0:
      return colour_of<0>(sh0, rest, direction);
    case 1:
      return colour_of<1>(sh0, rest, direction);
    case 2:
      return colour_of<2>(sh0, rest, direction);
    default:
      return colour_of<3>(sh0, rest, direction);
  }
}

/// All that projection reads of a Gaussian, asked for at once: the compiler would wait for each array before
/// the next.
__device__ inline Gaussian load_gaussian(const SceneView& scene, std::size_t i) {
  Gaussian g = gaussian(scene, i);
  asm volatile("" : "+f"(g.mean.x), "+f"(g.scale.x), "+f"(g.rotation.w), "+f"(g.opacity));
  return g;
}

/// Projects the Gaussians of one block and appends the visible ones to those of the blocks before it.
template <class Bounds>
__global__ void __launch_bounds__(project_threads)
    project(const __grid_constant__ ProjectJob job, const Bounds bounds, const ProjectOutput output,
            const RunningSums::View sums) {
  __shared__ ProjectShared shared;
  const unsigned warp = threadIdx.x / warp_size;
  RunningSum sum(sums);
  FrameCounts& counts = output.counts[sums.epoch % 2];
  if (blockIdx.x == 0 && threadIdx.x == 0) output.counts[(sums.epoch + 1) % 2] = {};

  // Project, and count the visible splats of the block.
  const std::size_t i = std::size_t(blockIdx.x) * project_threads + threadIdx.x;
  ProjectedShape splat;
  if (i < job.scene.size()) splat = project_shape(job.constants, load_gaussian(job.scene, i));
  const unsigned visible_lanes = __ballot_sync(whole_warp, splat.visible);
  if (lane_index() == 0) shared.visible[warp] = std::uint32_t(__popc(visible_lanes));
  __syncthreads();
  std::uint32_t slot = std::uint32_t(__popc(visible_lanes & lanes_below())), visible = 0;
  for (unsigned w = 0; w < project_warps; ++w) {
    if (w < warp) slot += shared.visible[w];
    visible += shared.visible[w];
  }
  if (threadIdx.x == 0) sum.add(visible);

  // Find their tiles.
  const Footprint footprint =
      find_footprint(bounds, job.grid, splat.shape, splat.visible, shared.footprints[warp]);
  const std::uint32_t tiles_of_warp = warp_sum(footprint.count);
  if (lane_index() == 0) shared.tiles[warp] = tiles_of_warp;
  if (splat.visible) shared.ids[slot] = std::uint32_t(i), shared.depths[slot] = splat.depth;
  __syncthreads();

  // Find where the block's splats begin: by the last warp, which has colours to evaluate only where nearly
  // all are visible.
  if (warp == project_warps - 1) {
    const std::uint32_t before = sum.before(visible);
    std::uint32_t tiles = 0;
    for (const std::uint32_t of_warp : shared.tiles) tiles += of_warp;
    if (lane_index() == 0) {
      shared.before = before;
      add_instances(counts, tiles);
      if (blockIdx.x + 1 == gridDim.x) counts.visible = before + visible;
    }
  }

  // Evaluate their colours, a thread a visible splat.
  SplatColour colour;
  if (warp * warp_size < visible) {
    const unsigned gaussians =
        visible - warp * warp_size < warp_size ? visible - warp * warp_size : warp_size;
    const bool mine = threadIdx.x < visible;
    const std::uint32_t id = mine ? shared.ids[threadIdx.x] : 0;
    if (job.scene.sh_degree > 0) stage_rest(job.scene, id, gaussians, shared.rest[warp]);
    if (mine)
      colour = {colour_of(job.scene.sh_degree, job.scene.sh0[id],
                          shared.rest[warp] + lane_index() * rest_pitch(job.scene.sh_degree),
                          view_direction(job.constants, job.scene.means[id])),
                shared.depths[threadIdx.x]};
  }

  // Append them.
  __syncthreads();
  const std::size_t first = shared.before;
  if (splat.visible) {
    output.shapes[first + slot] = splat.shape;
    output.footprints[first + slot] = footprint;
  }
  if (threadIdx.x < visible) output.colours[first + threadIdx.x] = colour;
}
}  // namespace kernels

template <BoundsPolicy Bounds>
void project(Cuda& cuda, const ProjectJob& job, const Bounds& bounds, ProjectScratch<Cuda>& scratch,
             Splats<Cuda>& splats) {
  const std::size_t n = job.scene.size();
  splats.count = 0, splats.instances = 0;
  splats.shapes.reset(n), splats.colours.reset(n), splats.footprints.reset(n);
  if (n == 0) return;
  const unsigned blocks = blocks_for(n, kernels::project_threads);
  const RunningSums::View sums = scratch.sums.next(cuda, blocks);
  FrameCounts* const counters = scratch.counts.begin(cuda);
  launch(
      "project", kernels::project<Bounds>, blocks, kernels::project_threads, cuda.stream(), job, bounds,
      kernels::ProjectOutput{splats.shapes.data(), splats.colours.data(), splats.footprints.data(), counters},
      sums);
  scratch.counts.end();
  const FrameCounts counts = cuda.read(counters + sums.epoch % 2);
  splats.count = std::size_t(counts.visible);
  splats.instances = counts.instances;
}

}  // namespace swiftgs
