// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/footprints.cuh>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/running_sum.cuh>
#include <swiftgs/project.hpp>

namespace swiftgs::kernels {

inline constexpr unsigned project_threads = 128;
inline constexpr unsigned project_warps = project_threads / warp_size;

/// Where projection writes to.
struct ProjectOutput {
  SplatShape* shapes;
  float* depths;
  std::uint32_t* gaussians;
  Footprint* footprints;
  std::uint32_t* hidden;  ///< is cleared
};

/// What the threads of a block tell each other.
template <class Bounds>
struct ProjectShared {
  std::uint32_t turn, before;
  std::uint32_t visible[project_warps], tiles[project_warps];  ///< of each warp
  FootprintShared<Bounds> footprints[project_warps];
};

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
    project(const __grid_constant__ ViewConstants camera, const __grid_constant__ SceneView scene,
            const TileGrid grid, const Bounds bounds, const ProjectOutput output,
            const TurnsView<FrameCounts> turns) {
  __shared__ ProjectShared<Bounds> shared;
  const unsigned warp = threadIdx.x / warp_size;
  const std::uint32_t loaded_turn = threadIdx.x == 0 ? read_turn(turns) : 0;

  // Project, and count the visible splats of the block.
  const std::size_t i = std::size_t(blockIdx.x) * project_threads + threadIdx.x;
  ProjectedShape splat;
  if (i < scene.size()) splat = project_shape(camera, load_gaussian(scene, i));
  const unsigned visible_lanes = __ballot_sync(whole_warp, splat.visible);
  if (lane_index() == 0) shared.visible[warp] = std::uint32_t(__popc(visible_lanes));
  if (threadIdx.x == 0) shared.turn = loaded_turn;
  __syncthreads();
  std::uint32_t slot = std::uint32_t(__popc(visible_lanes & lanes_below())), visible = 0;
  for (unsigned w = 0; w < project_warps; ++w) {
    if (w < warp) slot += shared.visible[w];
    visible += shared.visible[w];
  }
  if (threadIdx.x == 0) {
    RunningSum(turns.words, loaded_turn).add(visible);
    if (blockIdx.x == 0) turns.next_copy(loaded_turn) = {}, *output.hidden = 0;
  }

  // Find their tiles.
  const Footprint footprint =
      find_footprint(bounds, grid, splat.shape, splat.visible, shared.footprints[warp]);
  const std::uint32_t tiles_of_warp = warp_sum(footprint.count);
  if (lane_index() == 0) shared.tiles[warp] = tiles_of_warp;
  __syncthreads();

  // Find where the block's splats begin.
  if (warp == 0) {
    const std::uint32_t turn = shared.turn, before = RunningSum(turns.words, turn).before(visible);
    std::uint32_t tiles = 0;
    for (const std::uint32_t of_warp : shared.tiles) tiles += of_warp;
    if (lane_index() == 0) {
      shared.before = before;
      add_instances(turns.copy(turn), tiles);
      if (blockIdx.x + 1 == gridDim.x) {
        turns.copy(turn).visible = before + visible;
        end_turn(turns, turn);
      }
    }
  }
  __syncthreads();

  // Append them.
  if (!splat.visible) return;
  const std::size_t at = std::size_t(shared.before) + slot;
  output.shapes[at] = splat.shape;
  output.footprints[at] = footprint;
  output.depths[at] = splat.depth;
  output.gaussians[at] = std::uint32_t(i);
}

template <BoundsPolicy Bounds>
void run_project(Cuda& cuda, const FrameInput& input, const Bounds& bounds, ProjectScratch<Cuda>& scratch,
                 Splats<Cuda>& splats, Footprints<Cuda, Bounds>& footprints) {
  cuda.check_not_captured("project");
  const View& view = only_view(input.views);
  const SceneView& scene = only_scene(input.scenes);
  const std::size_t n = scene.size();
  splats.count = footprints.count = 0, footprints.instances = 0;
  splats.pending = footprints.found_by = {};
  splats.reset(n), footprints.each.reset(n), scratch.hidden.reset(1);
  footprints.grid = view.grid;
  if (n == 0) return;
  const unsigned blocks = blocks_for(n, project_threads);
  const TurnsView<FrameCounts> turns = scratch.turns.begin(cuda, blocks);
  launch("project", project<Bounds>, blocks, project_threads, cuda.stream(), view.camera, scene, view.grid,
         bounds,
         ProjectOutput{splats.shapes.data(), splats.depths.data(), splats.gaussians.data(),
                       footprints.each.data(), scratch.hidden.data()},
         turns);
  scratch.turns.end();
  splats.pending = footprints.found_by = {turns.last(), scratch.hidden.data(), ++scratch.projections};
}

template <BoundsPolicy Bounds>
void run_bin(Cuda& cuda, Span<const View> views, const Bounds& bounds, Splats<Cuda>& splats,
             Footprints<Cuda, Bounds>& footprints) {
  cuda.check_not_captured("bin");
  const TileGrid grid = only_view(views).grid;
  const bool found = splats.pending && footprints.found_by == splats.pending && footprints.grid == grid;
  footprints.found_by = {};
  FrameCounts counts{.visible = splats.count};
  if (splats.pending) counts = cuda.read(splats.pending.counts), splats.pending = {};
  splats.count = footprints.count = std::size_t(counts.visible);
  if (!found) {
    footprints.each.reset(splats.count), footprints.counts.reset(1);
    cuda.clear(footprints.counts.data(), sizeof(FrameCounts));
    if (splats.count != 0)
      launch("find_footprints", find_footprints<Bounds>, blocks_for(splats.count, bin_threads), bin_threads,
             cuda.stream(), splats.view().shapes, grid, bounds, footprints.each.data(),
             footprints.counts.data());
    counts = cuda.read({footprints.counts.data()});
  }
  footprints.instances = counts.instances, footprints.grid = grid;
}

}  // namespace swiftgs::kernels
