// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames of one view, as the stages take them.

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/frame_plan.hpp>
#include <swiftgs/lens/view.hpp>

namespace swiftgs::test {

/// One view of one scene.
struct OneView {
  View view;
  SceneView scene;

  OneView(const Camera& camera, const Conventions& conventions, const SceneView& of)
      : view(make_view(camera, conventions, {.width = camera.width, .height = camera.height})), scene{of} {}

  Span<const View> views() const { return {&view, 1}; }
  FramePlan plan(const Limits& limits = {}) const { return {views(), scene, limits}; }
};

/// A view of splats that no camera projected.
inline View view_without_camera(int width, int height, int tile_side = default_tile_side) {
  return {.grid = TileGrid::covering(width, height, tile_side), .frame = {.width = width, .height = height}};
}

/// Plan of stages that look at views alone.
inline FramePlan plan_without_scene(const Views& views) { return {views, {}}; }

/// The tiles of a frame of one view.
inline FrameTiles tiles_of_frame(const View& view) { return Views(&view, 1).tiles; }

}  // namespace swiftgs::test
