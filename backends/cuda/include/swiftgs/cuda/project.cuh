// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include <swiftgs/cuda/chunk_list.cuh>
#include <swiftgs/cuda/footprints.cuh>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/running_sum.cuh>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/cuda/view_source.cuh>
#include <swiftgs/error.hpp>
#include <swiftgs/project/project.hpp>

namespace swiftgs::kernels {

inline constexpr unsigned project_threads = chunk_size;
inline constexpr unsigned project_warps = project_threads / warp_size;

/// Where projection writes to.
struct ProjectOutput {
  SplatShape* shapes;
  float* depths;
  std::uint32_t* gaussians;
  std::uint16_t* of_view;  ///< null if there is one view
  Footprint* footprints;
  std::uint32_t* colourless;  ///< is cleared
  std::uint32_t capacity;     ///< splats beyond it are counted and left out
};

/// What the threads of a block tell each other.
template <class Bounds>
struct ProjectShared {
  std::uint32_t epoch, before;
  std::uint32_t visible[project_warps], tiles[project_warps];  ///< of each warp
  FootprintShared<Bounds> footprints[project_warps];
};

/// All that projection reads of a Gaussian, asked for at once: the compiler would wait for each array before
/// the next.
__device__ inline Gaussian load_gaussian(const SceneView& scene, std::size_t i) {
  return gaussian(scene, i, [](Gaussian& loaded) {
    asm volatile(""
                 : "+f"(loaded.mean.x), "+f"(loaded.scale.x), "+f"(loaded.rotation.w), "+f"(loaded.opacity));
  });
}

/// How many blocks ahead of its own a block prefetches Gaussians; so many blocks take 2.9 MB. On an H200,
/// projection takes as long with 256 and with 1,024, and longer with 2,400.
inline constexpr unsigned prefetch_ahead = 512;

/// Prefetches the values of the chunk that begins at `first` to the second-level cache, a line a thread.
template <class T>
__device__ void prefetch_chunk(const StridedSpan<T>& values, std::size_t first) {
  constexpr unsigned line = 128;
  const unsigned at = threadIdx.x * max(line, values.stride);
  if (at < chunk_size * values.stride)
    asm volatile("prefetch.global.L2 [%0];" ::"l"(reinterpret_cast<const char*>(values.at(first)) + at));
}

/// Prefetches all that projection reads of a chunk, if it is full. A block waits for all before it, so one
/// slow load would hold up all that run.
__device__ inline void prefetch_gaussians(const SceneView& scene, std::size_t chunk) {
  const std::size_t first = chunk * chunk_size;
  if (first + chunk_size > scene.size()) return;
  prefetch_chunk(scene.means, first), prefetch_chunk(scene.scales, first);
  prefetch_chunk(scene.rotations, first), prefetch_chunk(scene.opacities, first);
}

/// Constants of stored views in shared memory, where they cost fewer registers than from device memory.
struct SharedCamera {
  static constexpr unsigned words = sizeof(ViewConstants) / sizeof(std::uint32_t);
  static_assert(sizeof(ViewConstants) % sizeof(std::uint32_t) == 0 && words <= project_threads);
  alignas(ViewConstants) std::uint32_t of_camera[words];

  __device__ void load(const ViewConstants& camera) {
    if (threadIdx.x < words)
      of_camera[threadIdx.x] = reinterpret_cast<const std::uint32_t*>(&camera)[threadIdx.x];
  }
  /// As `eye` makes it, by threads that each find a number.
  __device__ void load_eye(const ViewConstants& camera, const PlacedScene& placed) {
    constexpr unsigned pose_words = offsetof(ViewConstants, pairs.cx) / sizeof(std::uint32_t);
    const Similarity& pose = placed.world_from_scene;
    const bool moved = !pose.is_identity();
    const unsigned k = threadIdx.x;
    if (k >= pose_words && k < words) of_camera[k] = reinterpret_cast<const std::uint32_t*>(&camera)[k];
    auto& eye = reinterpret_cast<ViewConstants&>(of_camera);
    if (k == 0) {
      eye.opacity = placed.opacity, eye.depth_scale = pose.scale;
      eye.blur = camera.blur, eye.antialiased = camera.antialiased;
      eye.blur_of_scene = camera.blur_of_scene, eye.antialiased_of_scene = camera.antialiased_of_scene;
      eye.follow(placed.scene.model);
    }
    if (k < 9) {
      const int row = int(k / 3), column = int(k % 3);
      const double element = moved ? eye_rotation(camera, pose, row, column) : camera.rotation[row][column];
      eye.rotation[row][column] = element, eye.axes[row][column] = float(element);
    } else if (k < 12) {
      eye.centre[k - 9] = moved ? eye_centre(camera, pose, int(k) - 9) : camera.centre[k - 9];
    } else if (k == 12) {
      eye.fx = eye_focal(camera, pose, camera.fx), eye.focal_x = float(eye.fx);
    } else if (k == 13) {
      eye.fy = eye_focal(camera, pose, camera.fy), eye.focal_y = float(eye.fy);
    }
    if constexpr (projects_in_pairs) {
      // Number k is the thread's own, and the depth's scale that of the first.
      if (k < 14) eye.set_pair(k);
      if (k == 0) eye.set_pair(14);
    }
  }
  __device__ const ViewConstants& camera() const { return reinterpret_cast<const ViewConstants&>(of_camera); }
};

/// Least thread blocks of a multiprocessor, for a lone view and for stored ones. A ninth is worth a few
/// spilled registers: two views of 1.5 M Gaussians take 0.159 ms instead of 0.166.
/// Lenses need more registers.
constexpr unsigned project_blocks(bool through_lens) { return through_lens ? 8 : 9; }

/// Projects the Gaussians of one block in one view and appends the visible ones to those of the blocks before
/// it. Without `through_lens` all views are pinholes that take depth z alone.
template <class Bounds, class ViewSource, class Scenes, bool through_lens>
__global__ void __launch_bounds__(project_threads,
                                  resident_blocks(project_blocks(through_lens), project_threads))
    project(const __grid_constant__ ViewSource views, const __grid_constant__ Scenes scenes,
            const Bounds bounds, const BlockList list, const std::uint32_t chunks_a_view,
            const ProjectOutput output, const EpochsView<FrameCounts> epochs) {
  __shared__ ProjectShared<Bounds> shared;
  await_earlier();
  // The first block counts even where none has something to show.
  const std::uint32_t listed = list.size(), last = max(listed, 1u) - 1;
  if (blockIdx.x > last) return;
  const unsigned warp = threadIdx.x / warp_size;
  const std::uint32_t loaded_epoch = threadIdx.x == 0 ? read_epoch(epochs) : 0;
  const std::uint32_t block = listed == 0 ? 0 : list[blockIdx.x];
  const std::uint32_t of_view = Scenes::only ? block % views.size() : block / chunks_a_view;

  // Project, and count the visible splats of the block.
  std::uint32_t gaussian_number = 0;
  const auto shape = [](const ViewConstants& camera, const Gaussian& gaussian) {
    if constexpr (through_lens)
      return project_shape(camera, gaussian);
    else
      return project_through_pinhole(camera, gaussian);
  };
  ProjectedShape splat;
  const std::uint32_t later = blockIdx.x + prefetch_ahead;
  if constexpr (Scenes::only) {
    const SceneView& scene = scenes.scene;
    if (later <= last) prefetch_gaussians(scene, list[later] / views.size());
    const std::size_t i = std::size_t(block / views.size()) * project_threads + threadIdx.x;
    gaussian_number = std::uint32_t(i);
    if constexpr (ViewSource::only) {
      if (i < scene.size()) splat = shape(views[0].camera, load_gaussian(scene, i));
    } else {
      __shared__ SharedCamera shared_camera;
      shared_camera.load(views[of_view].camera);
      const Gaussian gaussian = load_gaussian(scene, i < scene.size() ? i : 0);
      __syncthreads();
      if (i < scene.size()) splat = shape(shared_camera.camera(), gaussian);
    }
  } else {
    __shared__ SharedCamera shared_eye;
    __shared__ bool drawn;
    const PlacedChunk at = placed_chunk<true>(scenes, views[of_view], block % chunks_a_view);
    if (at.placed) {
      const StoredScene& placed = *at.placed;
      const SceneView& scene = placed.scene;
      shared_eye.load_eye(views[of_view].camera, placed);
      if (threadIdx.x == warp_size) drawn = can_be_drawn(placed, at.chunk);
      const std::size_t i = std::size_t(at.chunk) * project_threads + threadIdx.x;
      gaussian_number = placed.first_gaussian + std::uint32_t(i);
      const Gaussian gaussian = load_gaussian(scene, i < scene.size() ? i : 0);
      if (later <= last) prefetch_gaussians(scene, std::size_t(at.chunk) + (list[later] - block));
      __syncthreads();
      if (drawn && i < scene.size() && placed.clip.shows(gaussian.mean))
        splat = shape(shared_eye.camera(), gaussian);
    }
  }
  const unsigned visible_lanes = __ballot_sync(whole_warp, splat.visible);
  if (lane_index() == 0) shared.visible[warp] = std::uint32_t(__popc(visible_lanes));
  if (threadIdx.x == 0) shared.epoch = loaded_epoch;
  __syncthreads();
  std::uint32_t slot = std::uint32_t(__popc(visible_lanes & lanes_below())), visible = 0;
  for (unsigned w = 0; w < project_warps; ++w) {
    if (w < warp) slot += shared.visible[w];
    visible += shared.visible[w];
  }
  if (threadIdx.x == 0) {
    RunningSum(epochs.words, loaded_epoch).add(visible);
    if (blockIdx.x == 0) epochs.next_copy(loaded_epoch) = {}, *output.colourless = 0;
  }

  // Find their tiles.
  // Do so before the visible splats are compacted: after it, half of the warps wait. Measured on an H200 when
  // chosen: projection of garden takes 136 us so, and 156 with tiles found after it.
  const Footprint footprint =
      find_footprint(bounds, views[of_view].grid, splat.shape, splat.visible, shared.footprints[warp]);
  const std::uint32_t tiles_of_warp = warp_sum(footprint.count);
  if (lane_index() == 0) shared.tiles[warp] = tiles_of_warp;
  __syncthreads();

  // Find where the block's splats begin.
  if (warp == 0) {
    const std::uint32_t epoch = shared.epoch, before = RunningSum(epochs.words, epoch).before(visible);
    std::uint32_t tiles = 0;
    for (const std::uint32_t of_warp : shared.tiles) tiles += of_warp;
    if (lane_index() == 0) {
      shared.before = before;
      add_intersections(epochs.copy(epoch), tiles);
      if (blockIdx.x == last) {
        epochs.copy(epoch).visible = before + visible;
        end_epoch(epochs, epoch, last + 1);
      }
    }
  }
  __syncthreads();

  // Append them.
  const std::size_t at = std::size_t(shared.before) + slot;
  if (!splat.visible || at >= output.capacity) return;
  output.shapes[at] = splat.shape;
  output.footprints[at] = footprint;
  output.depths[at] = splat.depth;
  output.gaussians[at] = gaussian_number;
  if constexpr (!ViewSource::only)
    if (output.of_view) output.of_view[at] = std::uint16_t(of_view);
}

template <BoundsPolicy Bounds>
void run_project(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, ProjectScratch<Cuda>& scratch,
                 Splats<Cuda>& splats, Footprints<Cuda>& footprints) {
  footprints.views = plan.views;
  const std::size_t n = plan.candidates();
  const std::size_t most_splats = std::numeric_limits<std::uint32_t>::max();
  if (n > most_splats) throw CapacityError("Gaussians in all views", n, most_splats);
  const std::size_t limit = plan.limits.capacity.splats, capacity = limit == 0 ? n : std::min(limit, n);
  splats.count = footprints.count = 0, footprints.intersections = 0;
  splats.exact = nullptr, footprints.overflowed = nullptr;
  splats.pending = footprints.found_by = {};
  splats.reset(capacity, plan.views.size()), footprints.each.reset(capacity);
  scratch.colourless.reset(1), scratch.totals.reset(1);
  // An empty scene needs these, and a recorded frame of one must not allocate.
  footprints.counts.reset(1), footprints.totals.reset(1);
  if (n == 0) return;
  const ProjectOutput output{splats.shapes.data(),    splats.depths.data(),
                             splats.gaussians.data(), plan.views.size() > 1 ? splats.of_view.data() : nullptr,
                             footprints.each.data(),  scratch.colourless.data(),
                             std::uint32_t(capacity)};
  std::size_t chunks_a_view = 0;
  for (const View& view : plan.views)
    chunks_a_view = std::max(chunks_a_view, plan.scenes.chunks_of(view).size());
  const std::size_t all_blocks = chunks_a_view * plan.views.size();
  const std::size_t most_blocks = std::numeric_limits<std::int32_t>::max();
  if (all_blocks > most_blocks) throw CapacityError("chunks in all views", all_blocks, most_blocks);
  const unsigned blocks = unsigned(all_blocks);
  const BlockList list = run_list_blocks(cuda, plan, blocks, unsigned(chunks_a_view), scratch.shown);
  const EpochsView<FrameCounts> epochs = scratch.epochs.begin(cuda, blocks);
  with_views_and_scenes(plan.views, plan.scenes,
                        [&]<class ViewSource, class Scenes>(const ViewSource& views, const Scenes& scenes) {
                          const auto kernel = plan.views.through_lens
                                                  ? project<Bounds, ViewSource, Scenes, true>
                                                  : project<Bounds, ViewSource, Scenes, false>;
                          launch_early(cuda, "project", kernel, blocks, project_threads, views, scenes,
                                       bounds, list, std::uint32_t(chunks_a_view), output, epochs);
                        });
  scratch.epochs.end();
  splats.pending = footprints.found_by = {epochs.last(), scratch.colourless.data(), scratch.totals.data(),
                                          ++scratch.projections};
  footprints.found_within = Bounds::name;
}

/// Whether footprints of one are footprints of the other.
inline bool same_grids(const Views& a, const Views& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const View& one, const View& other) { return one.grid == other.grid; });
}

/// Finds the footprints of all splats, whose number the host knows.
template <BoundsPolicy Bounds>
void run_find_footprints(Cuda& cuda, const Views& views, const Bounds& bounds, const Splats<Cuda>& splats,
                         Footprints<Cuda>& footprints) {
  footprints.each.reset(splats.count), footprints.counts.reset(1), footprints.totals.reset(1);
  cuda.clear(footprints.counts.data(), sizeof(FrameCounts));
  if (splats.count == 0) return;
  with_views(views, [&]<class ViewSource>(const ViewSource& source) {
    launch("find_footprints", find_footprints<Bounds, ViewSource>, blocks_for(splats.count, bin_threads),
           bin_threads, cuda.stream(), splats.view(), source, bounds, footprints.each.data(),
           footprints.counts.data());
  });
}

template <BoundsPolicy Bounds>
void run_bin(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, Splats<Cuda>& splats,
             Footprints<Cuda>& footprints) {
  const Views& views = plan.views;
  const Limits& limits = plan.limits;
  const bool waits = limits.capacity.intersections == 0;
  if (waits) cuda.check_not_captured("bin");
  const PendingProjection pending = std::exchange(splats.pending, {});
  const PendingProjection found_by = std::exchange(footprints.found_by, {});
  const bool found = pending && found_by == pending && footprints.found_within == Bounds::name &&
                     same_grids(views, footprints.views);
  footprints.views = views;
  LastCounters<FrameCounts> counts = pending.counts;
  FrameTotals* totals = pending.totals;
  if (!found) {
    if (pending) {
      cuda.settle(counts, {}, totals);
      const std::size_t visible = std::size_t(cuda.await_report().visible);
      splats.count = std::min(visible, splats.shapes.size()), splats.exact = nullptr;
    }
    run_find_footprints(cuda, views, bounds, splats, footprints);
    counts = {footprints.counts.data()}, totals = footprints.totals.data();
  }
  cuda.settle(counts, waits ? Limits{} : limits, totals);
  if (waits) {
    const FrameReport report = cuda.await_report();
    splats.count = footprints.count = std::size_t(report.visible), splats.exact = nullptr;
    footprints.intersections = std::size_t(report.intersections), footprints.overflowed = nullptr;
    return;
  }
  if (found) splats.count = splats.shapes.size();
  footprints.count = splats.count, splats.exact = &totals->splats;
  footprints.intersections = {limits.capacity.intersections, &totals->intersections};
  footprints.overflowed = &totals->report.overflowed;
}

}  // namespace swiftgs::kernels
