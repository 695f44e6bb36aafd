// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/default_view.hpp>

#include "options.hpp"
#include "read/placed_input.hpp"
#include "read/views.hpp"
#include "view/camera_path.hpp"
#include "view/crop_error.hpp"
#include "view/drawing.hpp"
#include "view/messages.hpp"
#include "view/navigation.hpp"

namespace swiftgs::cli {

class Window;

/// All that the viewer shows and the user changes. Each turn of `run` changes it by what the user did, draws
/// a frame of it if that shows, and shows it in the panels, whose changes the next turn draws.
struct Viewer {
  explicit Viewer(Drawing drawn) : drawing(std::move(drawn)) {}

  Drawing drawing;
  SceneOptions reading{};       ///< how to read scenes that are dropped
  std::vector<View> cameras{};  ///< to jump to, one or more
  std::size_t camera = 0;       ///< that was jumped to last

  OrbitView view{};
  Navigation navigation = Navigation::orbit;
  double speed = 1;      ///< @units{world a second}
  double least_way = 1;  ///< from a camera to its target, at least

  CameraPath path{};
  std::string path_file{};  ///< where it is saved; a free name if empty
  bool has_edited_path = false;
  bool plays = false;
  double path_at = 0;  ///< of the camera on it, 0 to `path.seconds()` @units{seconds}

  std::string list_file{};  ///< where the list of scenes is saved; a free name if empty
  bool has_edited_scenes = false;

  std::string plane{};  ///< in place of colour
  std::optional<Picked> picked{};
  int crop_x = -1,
      crop_y = -1;  ///< in the middle of the crop that is compared; the image's middle if below 0
  bool compares = false, counts = false;
  CropError crop_error{};
  std::optional<CropError::Error> error{};

  Camera shown{};              ///< through which the last frame was drawn
  double scale = 1;            ///< of that frame's size
  double drawn_at = 0;         ///< by `window_time`
  double interval = 0;         ///< between the last two frames while they follow each other @units{seconds}
  bool saves_picture = false;  ///< when what was asked for before is drawn

  Messages messages{};
  bool has_panels = true;
  bool escapes = false;       ///< Esc was pressed, and nothing has taken it yet
  bool asks_to_quit = false;  ///< though something is not saved
  bool quits = false;
};

/// The scenes of `listed`, as they were read, for the list of the viewer.
std::vector<ShownScene> shown_scenes(const std::vector<ListedScene>& listed, const DrawnScenes& drawn);

/// Tells the user `text` for some seconds.
void note(Viewer& viewer, std::string text);
/// Tells the user `text` until it is dismissed.
void tell_error(Viewer& viewer, std::string text);

/// Runs `step`. An exception's text becomes an error of the viewer.
template <class F>
void attempt(Viewer& viewer, const F& step) {
  try {
    step();
  } catch (const std::exception& error) {
    tell_error(viewer, error.what());
  }
}

/// Goes to a camera of the list.
void jump_to(Viewer& viewer, std::size_t camera);
/// Goes to where the path is at `path_at`.
void follow_path(Viewer& viewer);
/// Adds the camera that shows to the path.
void add_key(Viewer& viewer);
/// Writes the path of `viewer` to its file.
void save_path(Viewer& viewer);
/// Writes the list of scenes to its file.
void save_scenes(Viewer& viewer);

inline bool has_unsaved_path(const Viewer& viewer) {
  return viewer.has_edited_path && !viewer.path.keys.empty();
}

/// Shows `viewer` until the window is closed.
void run(Window& window, Viewer viewer);

}  // namespace swiftgs::cli
