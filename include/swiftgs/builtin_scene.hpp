// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A scene that needs no file: a still life on a terrace above a valley, in as many Gaussians as asked for.
/// Part of swiftgs::builtin.

#include <cstddef>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/tools/scene_part.hpp>

namespace swiftgs {

/// Default number of Gaussians in the built-in scene.
inline constexpr std::size_t builtin_scene_size = 200'000;

/// The built-in scene in exactly `count` Gaussians of SH degree 3. One unit is a metre, y points down, the
/// still life stands at the origin, the sky is 190 m away. The same picture at any count: standard deviations
/// shrink as count^(-1/2). Scales, opacities and anisotropy are spread as in trained captures.
///
/// The scene is reproducible: integers decide everything random, it avoids functions that differ between C
/// libraries, and multiplications and additions are not contracted.
///
/// Makes a `part` of the scene without the rest. Throws `InvalidArgument` for an unknown part.
SWIFTGS_API Scene make_builtin_scene(std::size_t count = builtin_scene_size, const ScenePart& part = {});

/// The view that the built-in scene is composed for.
SWIFTGS_API Camera builtin_camera(int width = 1280, int height = 720);

/// `views` cameras in a circle around the still life, the first at the front.
SWIFTGS_API std::vector<Camera> builtin_cameras(int views = 24, int width = 1280, int height = 720);

}  // namespace swiftgs
