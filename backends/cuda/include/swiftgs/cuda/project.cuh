// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <cuda_pipeline_primitives.h>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/footprints.cuh>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/running_sum.cuh>
#include <swiftgs/project.hpp>

namespace swiftgs {

namespace kernels {
inline constexpr unsigned project_threads = 256;
inline constexpr unsigned project_warps = project_threads / warp_size;
inline constexpr unsigned most_rest = 3 * unsigned(sh_rest_count(max_sh_degree));

/// Where projection writes to. `counts` are two, of this frame and of the next.
struct ProjectOutput {
  SplatShape* shapes;
  SplatColour* colours;
  Footprint* footprints;
  FrameCounts* counts;
};

/// What the threads of a block tell each other.
struct ProjectShared {
  std::uint32_t place, before;
  std::uint32_t visible[project_warps];            ///< Gaussians of each warp
  std::uint32_t ids[project_threads];              ///< visible Gaussians of the block
  float depths[project_threads];                   ///< and their depths
  union {
    FootprintShared footprints[project_warps];
    float rest[project_warps][warp_size * most_rest];  ///< SH coefficients of each lane's Gaussian
  };
};

/// Copies the SH coefficients of the warp's Gaussians, one after another: lanes read neighbouring words, where a lane a
/// Gaussian would touch 32 lines with each load. All copies are under way at once.
__device__ inline void stage_rest(const SceneView& scene, std::uint32_t id, unsigned gaussians, float* rest) {
  const unsigned used = 3 * unsigned(sh_rest_count(scene.sh_degree));
  for (unsigned g = 0; g < gaussians; ++g) {
    const float* from =
        scene.sh_rest.data + std::size_t(__shfl_sync(whole_warp, id, int(g))) * std::size_t(scene.sh_stride);
    for (unsigned k = lane_index(); k < used; k += warp_size)
      __pipeline_memcpy_async(rest + g * used + k, from + k, sizeof(float));
  }
  __pipeline_commit();
  __pipeline_wait_prior(0);
  __syncwarp();
}

/// `sh_colour` with a degree that the compiler knows, so that the basis stays in registers.
__device__ inline vec3 colour_of(int degree, vec3 sh0, const float* rest, vec3 direction) {
  switch (degree) {
    case 0: return sh_colour(0, sh0, rest, direction);
    case 1: return sh_colour(1, sh0, rest, direction);
    case 2: return sh_colour(2, sh0, rest, direction);
    default: return sh_colour(3, sh0, rest, direction);
  }
}

/// Projects the Gaussians of one block and appends the visible ones to those of the blocks before it.
template <class Bounds>
__global__ void __launch_bounds__(project_threads)
    project(const __grid_constant__ ProjectJob job, const Bounds bounds, const ProjectOutput output,
            const RunningSums::View sums) {
  __shared__ ProjectShared shared;
  const unsigned warp = threadIdx.x / warp_size;
  RunningSum sum(sums);
  if (threadIdx.x == 0) shared.place = sum.take_place(gridDim.x);
  __syncthreads();
  const std::uint32_t place = shared.place;
  FrameCounts& counts = output.counts[sums.epoch % 2];
  if (place == 0 && threadIdx.x == 0) output.counts[(sums.epoch + 1) % 2] = {};

  // Project, and count the visible splats of the block.
  const std::size_t i = std::size_t(place) * project_threads + threadIdx.x;
  ProjectedShape splat;
  if (i < job.scene.size()) splat = project_shape(job.constants, job.scene, i);
  const unsigned visible_lanes = __ballot_sync(whole_warp, splat.visible);
  if (lane_index() == 0) shared.visible[warp] = std::uint32_t(__popc(visible_lanes));
  __syncthreads();
  std::uint32_t slot = std::uint32_t(__popc(visible_lanes & lanes_below())), visible = 0;
  for (unsigned w = 0; w < project_warps; ++w) {
    if (w < warp) slot += shared.visible[w];
    visible += shared.visible[w];
  }
  if (threadIdx.x == 0) sum.add(place, visible);

  // Find their tiles.
  const Footprint footprint =
      find_footprint(bounds, job.grid, splat.shape, splat.visible, shared.footprints[warp]);
  add_instances(counts, footprint.count);
  if (splat.visible) shared.ids[slot] = std::uint32_t(i), shared.depths[slot] = splat.depth;
  __syncthreads();

  // Evaluate their colours, a thread a visible splat.
  SplatColour colour;
  if (warp * warp_size < visible) {
    const unsigned gaussians = visible - warp * warp_size < warp_size ? visible - warp * warp_size : warp_size;
    const bool mine = threadIdx.x < visible;
    const std::uint32_t id = mine ? shared.ids[threadIdx.x] : 0;
    stage_rest(job.scene, id, gaussians, shared.rest[warp]);
    if (mine) {
      const unsigned used = 3 * unsigned(sh_rest_count(job.scene.sh_degree));
      colour = {colour_of(job.scene.sh_degree, job.scene.sh0[id], shared.rest[warp] + lane_index() * used,
                          view_direction(job.constants, job.scene.means[id])),
                shared.depths[threadIdx.x]};
    }
  }

  // Append them.
  if (warp == 0) {
    const std::uint32_t before = sum.before(place, visible);
    if (lane_index() == 0) shared.before = before;
    if (lane_index() == 0 && place + 1 == gridDim.x) counts.visible = before + visible;
  }
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
  splats.shapes.reset(n), splats.colours.reset(n), splats.footprints.reset(n);
  splats.count = 0, splats.instances = 0;
  if (n == 0) return;
  if (scratch.counts.size() == 0) {
    scratch.counts.reset(2);
    cuda.clear(scratch.counts.data(), 2 * sizeof(FrameCounts));
  }
  const unsigned blocks = blocks_for(n, kernels::project_threads);
  const RunningSums::View sums = scratch.sums.next(cuda, blocks);
  launch("project", kernels::project<Bounds>, blocks, kernels::project_threads, cuda.stream(), job, bounds,
         kernels::ProjectOutput{splats.shapes.data(), splats.colours.data(), splats.footprints.data(),
                                scratch.counts.data()},
         sums);

  // The one place where a frame waits for its device.
  FrameCounts counts;
  cuda.download(Span<const FrameCounts>{scratch.counts.data() + sums.epoch % 2, 1}, &counts);
  splats.count = std::size_t(counts.visible);
  splats.instances = counts.instances;
}

}  // namespace swiftgs
