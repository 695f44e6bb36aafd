// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/api.hpp>
#include <swiftgs/backend.hpp>
#include <swiftgs/bounds/bounds.hpp>
#include <swiftgs/footprint.hpp>
#include <swiftgs/project.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

/// Input of projection.
struct ProjectJob {
  ViewConstants constants;
  SceneView scene;
  TileGrid grid;
};

/// Memory of the projection stage between its two steps.
template <class B>
struct ProjectScratch {
  typename B::template Buffer<ProjectedShape> projected;
  typename B::template Buffer<std::uint32_t> slots;

  std::size_t bytes() const { return bytes_of(projected, slots); }
};

/// Projects Gaussian i and marks it with 1 where it is visible.
struct SWIFTGS_API ProjectShapes {
  ViewConstants constants;
  SceneView scene;
  ProjectedShape* projected;
  std::uint32_t* slots;

  SWIFTGS_HD void operator()(std::size_t i) const {
    projected[i] = project_shape(constants, gaussian(scene, i));
    slots[i] = projected[i].visible;
  }
};

/// Moves visible Gaussian i to its slot and evaluates its colour. Nothing else in the generic form reads
/// spherical harmonics.
struct CompactSplats {
  ViewConstants constants;
  SceneView scene;
  const ProjectedShape* projected;
  const std::uint32_t* slots;
  SplatShape* shapes;
  SplatColour* colours;

  SWIFTGS_HD void operator()(std::size_t i) const {
    if (!projected[i].visible) return;
    SplatShape shape = projected[i].shape;
    SplatColour colour{vec3(0), projected[i].depth};
    if (!set_colour(shape, colour, project_colour(constants, scene, i))) shape.reach = -1;
    shapes[slots[i]] = shape, colours[slots[i]] = colour;
  }
};

/// Projects the scene of `job`: one splat for each visible Gaussian, in the order of the Gaussians. Backends
/// overload this. If the host's read of a count is slow, a backend also counts the tiles within `bounds`
/// here, so that one read serves this stage and the next.
template <BackendPolicy B, BoundsPolicy Bounds>
void project(B& b, const ProjectJob& job, const Bounds&, ProjectScratch<B>& scratch, Splats<B>& splats,
             Footprints<B, Bounds>& footprints) {
  footprints.grid = job.grid;
  const std::size_t n = job.scene.size();
  scratch.projected.reset(n), scratch.slots.reset(n);
  b.for_each(n, ProjectShapes{job.constants, job.scene, scratch.projected.data(), scratch.slots.data()});
  splats.count = 0;
  const std::size_t visible = std::size_t(b.exclusive_scan(Span{scratch.slots.data(), n}));
  splats.shapes.reset(visible), splats.colours.reset(visible);
  b.for_each(n, CompactSplats{job.constants, job.scene, scratch.projected.data(), scratch.slots.data(),
                              splats.shapes.data(), splats.colours.data()});
  splats.count = visible;
}

/// Orders later work after the splats' colours. Overload it if `project` may return before they are
/// evaluated. The sort reads only `depth` of colours, which is always written.
template <BackendPolicy B>
void finish_colours(B&, Splats<B>&) {}

}  // namespace swiftgs
