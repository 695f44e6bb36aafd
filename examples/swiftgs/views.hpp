// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/scene.hpp>

#include "options.hpp"

namespace swiftgs::cli {

/// One image to make.
struct View {
  Camera camera;
  std::string name;  ///< the camera's name without extension, made a plain file name; or the view's number
};

/// The numbers below `count` that `text` chooses: `all`, `every:N` (0, N, 2N, ...), `except:N` (all others),
/// or a list as `0,8`. Throws `std::invalid_argument` for anything else, for a number that is not below
/// `count`, and where `except:N` leaves none.
std::vector<std::size_t> choose_views(std::string_view text, std::size_t count);

/// The views that `options` ask for, scaled. Without cameras the built-in scene has a front view and an orbit
/// of 24, any other scene has one view that is found for it; then the first is the default. With cameras
/// `default_views` is.
std::vector<View> views_of(const SceneOptions& scene_options, const ViewOptions& options, const Scene& scene,
                           std::string_view default_views);

/// The views that `options.views`, which must not be empty, does not choose, scaled.
std::vector<View> views_left_out(const SceneOptions& scene_options, const ViewOptions& options,
                                 const Scene& scene);

/// What `options` say about conventions and background; anti-aliased if `scene` was trained so.
RenderSettings settings_of(const ViewOptions& options, const Scene& scene);

}  // namespace swiftgs::cli
