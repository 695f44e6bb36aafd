// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames of one view, as the stages take them.

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/view.hpp>

namespace swiftgs::test {

/// One view of one scene.
struct OneView {
  View view;
  PlacedScene scene;

  OneView(const Camera& camera, const Conventions& conventions, const SceneView& of)
      : view(make_view(camera, conventions, {.width = camera.width, .height = camera.height})), scene{of} {}

  Span<const View> views() const { return {&view, 1}; }
  FrameInput input() const { return {views(), {&scene, 1}}; }
};

/// A view of splats that no camera projected.
inline View view_without_camera(int width, int height, int tile_side = default_tile_side) {
  return {.grid = TileGrid::covering(width, height, tile_side), .frame = {.width = width, .height = height}};
}

/// The tiles of a frame of one view.
inline FrameTiles tiles_of_frame(const View& view) { return frame_tiles({&view, 1}); }

}  // namespace swiftgs::test
