// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include <swiftgs/cpu/stages.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/project/project.hpp>

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "project.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "project_group-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// Projects Gaussians [begin, end) of a placed scene, at most a chunk of them, for its eye `v`.
template <bool through_lens>
void ProjectChunk(const ViewConstants& v, const StoredScene& placed, std::size_t begin, std::size_t end,
                  VisibleSplats& out) {
  const SceneView& scene = placed.scene;
  const std::uint32_t first = placed.first_gaussian;
  const bool as_they_lie = scene.means.is_dense() && scene.scales.is_dense() && scene.rotations.is_dense() &&
                           scene.opacities.is_dense() && !scene.any_rotations;
  std::size_t i = begin;
  for (; as_they_lie && i + lanes <= end; i += lanes)
    ProjectGroup<through_lens>(v, placed.clip,
                               {&scene.means[i], &scene.scales[i], &scene.rotations[i], &scene.opacities[i]},
                               first + std::uint32_t(i), out);

  // The scene's arrays end with it, and others have gaps: copy these to where a whole group can be read.
  // Lanes beyond the end are transparent.
  for (; i < end; i += lanes) {
    vec3 means[lanes], scales[lanes];
    Quaternion rotations[lanes];
    float opacities[lanes] = {};
    for (std::size_t k = 0; k < lanes; ++k) means[k] = scales[k] = vec3(0);
    for (std::size_t k = 0; k < std::min(lanes, end - i); ++k) {
      const Gaussian g = gaussian(scene, i + k);
      means[k] = g.mean, scales[k] = g.scale, rotations[k] = g.rotation, opacities[k] = g.opacity;
    }
    ProjectGroup<through_lens>(v, placed.clip, {means, scales, rotations, opacities},
                               first + std::uint32_t(i), out);
  }
}

/// Projects the Gaussians of chunks [begin, end) of the frame, and returns how many are visible.
std::size_t ProjectTask(const ViewConstants& camera, const SeveralScenes& scenes, std::size_t begin,
                        std::size_t end, SplatShape* shapes, float* depths, std::uint32_t* ids) {
  VisibleSplats out{shapes, depths, ids};
  const auto project_chunk = camera.through_lens ? ProjectChunk<true> : ProjectChunk<false>;
  while (begin < end) {
    const StoredScene& placed = scenes.of_chunk(std::uint32_t(begin));
    const SceneView& scene = placed.scene;
    const ViewConstants v = eye(camera, placed);
    const ChunkCuller culler(v);
    const std::size_t until = std::min(end, std::size_t(placed.first_chunk) + placed.chunks());
    for (; begin < until; ++begin) {
      const std::size_t chunk = begin - placed.first_chunk, i = chunk * chunk_size;
      if (scene.chunks.empty() || !culler.culls(scene.chunks[chunk]))
        project_chunk(v, placed, i, std::min(i + chunk_size, scene.size()), out);
    }
  }
  return out.count;
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {

HWY_EXPORT(ProjectTask);

/// Chunks that one task projects; fixed, so that the order of the splats does not depend on the threads.
constexpr std::size_t task_chunks = 32;

constexpr std::size_t task_count(std::size_t chunks) { return (chunks + task_chunks - 1) / task_chunks; }

/// Appends the splats of one view, if they fit.
void project_view(Cpu& cpu, const FramePlan& plan, std::size_t view, ProjectScratch<Cpu>& scratch,
                  Splats<Cpu>& splats) {
  const Views& views = plan.views;
  const std::size_t capacity = plan.limits.capacity.splats;
  const ViewConstants& camera = views.each[view].camera;
  const SeveralScenes scenes{plan.scenes.reachable(), std::uint32_t(plan.scenes.size())};
  const ChunkRange chunks = plan.scenes.chunks_of(views[view]);
  // Each task projects to a place of its own.
  const std::size_t n = chunks.size() * chunk_size, tasks = task_count(chunks.size());
  scratch.shapes.reset(n), scratch.depths.reset(n), scratch.gaussians.reset(n), scratch.counts.reset(tasks);
  cpu.for_parts(tasks, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t task = first; task < last; ++task) {
      const std::size_t begin = chunks.begin + task * task_chunks, at = task * task_chunks * chunk_size;
      scratch.counts.data()[task] = HWY_DYNAMIC_DISPATCH(ProjectTask)(
          camera, scenes, begin, std::min(begin + task_chunks, chunks.end), scratch.shapes.data() + at,
          scratch.depths.data() + at, scratch.gaussians.data() + at);
    }
  });

  // Move their splats together.
  std::size_t* offsets = scratch.counts.data();
  std::size_t end_of_view = splats.count;
  for (std::size_t task = 0; task < tasks; ++task) end_of_view += std::exchange(offsets[task], end_of_view);
  splats.visible += end_of_view - splats.count;
  if (capacity != 0 && splats.visible > capacity) return;
  splats.resize(end_of_view, views.size());
  cpu.for_parts(tasks, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t task = first; task < last; ++task) {
      const std::size_t begin = task * task_chunks * chunk_size, to = offsets[task];
      const std::size_t count = (task + 1 < tasks ? offsets[task + 1] : end_of_view) - to;
      std::copy_n(scratch.shapes.data() + begin, count, splats.shapes.data() + to);
      std::copy_n(scratch.depths.data() + begin, count, splats.depths.data() + to);
      std::copy_n(scratch.gaussians.data() + begin, count, splats.gaussians.data() + to);
      if (views.size() > 1) std::fill_n(splats.of_view.data() + to, count, std::uint16_t(view));
    }
  });
  splats.count = end_of_view;
}

}  // namespace

void ProjectScratch<Cpu>::reserve(Cpu&, const Reservation& reserved) {
  const std::size_t n = reserved.chunks * chunk_size;
  shapes.reset_exactly(n), depths.reset_exactly(n), gaussians.reset_exactly(n);
  counts.reset_exactly(task_count(reserved.chunks));
}

void project(Cpu& cpu, const FramePlan& plan, ProjectScratch<Cpu>& scratch, Splats<Cpu>& splats) {
  splats.count = splats.visible = 0;
  for (std::size_t view = 0; view < plan.views.size(); ++view) project_view(cpu, plan, view, scratch, splats);
}

}  // namespace swiftgs
#endif
