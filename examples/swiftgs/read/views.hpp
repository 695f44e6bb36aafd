// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
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
  double to_find_at = 0;  ///< scale of a view that `place_views` has yet to find; 0 for any other
};

/// All cameras that there are for a scene, in the order of their names.
struct Cameras {
  std::vector<Camera> all;
  bool of_file = false;
  double frames_a_second = 24;  ///< for a video of them
  bool to_find = false;  ///< `all` is one camera that knows its image alone: the scene tells where it stands
};

/// The cameras of `scene`: those of the file or folder `cameras`; those of the folder, where `scene` is a
/// capture's; of the built-in scene a front view and an orbit of 24. Any other scene has one view, to be
/// found. It looks into no scene: cameras that cannot be read are refused before gigabytes of Gaussians are
/// read. Says the notes of their file, and adds them to `said` as `say_notes` does.
Cameras read_cameras_of(const SceneOptions& scene, const std::string& cameras,
                        std::vector<std::string>& said);

/// The numbers of the cameras that `text` chooses: `all`, `every:N` (0, N, 2N, ...), `except:N` (all others),
/// or a list of numbers, of ranges as `3-7`, and of images' names, with or without extension. An image's name
/// that begins with 0 is a name before it is a number. Throws `InvalidArgument` for anything else, for
/// what is not there, and where `except:N` leaves none.
std::vector<std::size_t> choose_views(std::string_view text, const std::vector<Camera>& cameras);

/// The views that `options` choose, scaled. Of cameras from a file `default_views` is the default, else the
/// first.
std::vector<View> views_of(const Cameras& cameras, const ViewOptions& options,
                           std::string_view default_views);

/// The views that `options.views`, which must not be empty, does not choose, scaled.
std::vector<View> views_left_out(const Cameras& cameras, const ViewOptions& options);

/// Moves cameras of the world to where `scene` has its Gaussians, relative to its origin: the one place where
/// cameras and scene meet. Finds what `views` have yet to find: the camera of the scene's file, or else one
/// for `scene`.
void place_views(std::vector<View>& views, const Scene& scene, const std::optional<Camera>& of_file);

/// Planes by their names, separated by commas; an empty text names none. Throws `std::invalid_argument`.
Outputs planes_of(const std::string& names);

/// What `options` say about conventions and background.
RenderSettings settings_of(const ViewOptions& options);

/// The same, with the times of stages.
inline RenderSettings timed(RenderSettings settings) {
  settings.time = true;
  return settings;
}

/// The share of one view in the times of a frame of so many.
inline StageTimes a_view(const StageTimes& frame, std::size_t views) {
  const double n = double(views);
  return {frame.project / n, frame.sort / n, frame.raster / n, frame.total / n};
}

}  // namespace swiftgs::cli
