// SPDX-License-Identifier: Apache-2.0
#include "view/viewer.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include <swiftgs/io/image.hpp>
#include <swiftgs/tools/scene_bounds.hpp>

#include "view/panels.hpp"
#include "view/resolution.hpp"
#include "view/window.hpp"

namespace swiftgs::cli {
namespace {

namespace fs = std::filesystem;

/// Between frames that follow each other. @units{seconds}
constexpr double longest_interval = 0.5;

/// Adds scenes of a file, where it has them.
void add_scenes(Viewer& viewer, const std::string& file) {
  const std::vector<ListedScene> listed = scenes_of({file}, true);
  std::vector<std::string> notes;
  const DrawnScenes drawn = load_to_place(listed, viewer.reading, notes);
  viewer.drawing.add(shown_scenes(listed, drawn));
  viewer.picked.reset();
  viewer.compares = viewer.compares && !viewer.drawing.pages();
}

/// Opens a path, or else scenes.
void open(Viewer& viewer, const std::string& file) {
  if (is_camera_path(file)) {
    if (has_unsaved_path(viewer))
      throw std::invalid_argument(file +
                                  ": found a path, expected the keys of the old one to be saved or dropped");
    viewer.path = read_camera_path(file, viewer.drawing.scenes()[0].gaussians->origin);
    viewer.path_file = file, viewer.path_at = 0, viewer.has_edited_path = false;
  } else {
    add_scenes(viewer, file);
  }
  note(viewer, "opened " + file);
}

/// The first of swiftgs-1.png, swiftgs-2.png and so on that is not there, of `stem` swiftgs.
std::string free_name(const std::string& stem, const char* extension) {
  for (int number = 1;; ++number)
    if (std::string name = stem + "-" + std::to_string(number) + extension; !fs::exists(name)) return name;
}

/// `name`, or a free one if that is empty.
std::string name_or_free(const std::string& name, const char* stem) {
  return name.empty() ? free_name(stem, ".json") : name;
}

/// Acts on a key. Returns whether what shows may have changed.
bool press(Viewer& viewer, char key) {
  switch (key) {
    case '1':
    case '2':
    case '3':
      viewer.navigation = Navigation(key - '1');
      break;
    case 'K':
      add_key(viewer);
      break;
    case ' ':
      viewer.plays = !viewer.plays && !viewer.path.keys.empty();
      break;
    case 'H':
      viewer.has_panels = !viewer.has_panels;
      break;
    case 'P':
      viewer.saves_picture = true;
      break;
    case 'F':
      if (!viewer.path.keys.empty()) save_path(viewer);
      break;
    case 'L':
      save_scenes(viewer);
      break;
    case 'R':
      jump_to(viewer, viewer.camera);
      return true;
    case 'N':
    case 'B':
      jump_to(viewer, (viewer.camera + (key == 'N' ? 1 : viewer.cameras.size() - 1)) % viewer.cameras.size());
      return true;
    default:
      break;
  }
  return false;
}

/// Picks the Gaussian under the mouse. A double click makes it the target of orbits.
void pick(Viewer& viewer, const Events& events) {
  const int x = int(viewer.scale * events.x), y = int(viewer.scale * events.y);
  const Frame& picture = viewer.drawing.picture();
  if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return;
  viewer.picked = viewer.drawing.pick(x, y);
  viewer.crop_x = events.x, viewer.crop_y = events.y;
  if (!events.double_clicked || !viewer.picked) return;
  viewer.view.target = viewer.drawing.in_world(viewer.picked->scene, viewer.picked->position);
  viewer.navigation = Navigation::orbit;
}

/// Goes on along the path, to its end.
void play(Viewer& viewer, double seconds) {
  const double last = viewer.path.seconds();
  viewer.path_at = viewer.path_at >= last ? 0 : std::min(viewer.path_at + seconds, last);
  viewer.plays = viewer.path_at < last;
  follow_path(viewer);
}

/// Applies `events` to `viewer`. Returns whether a new frame is needed.
bool act(Viewer& viewer, const Events& events) {
  bool changed = false;
  viewer.escapes = events.escape;
  if (!events.keys.empty() || !events.dropped.empty() || events.clicked) viewer.messages.act();
  for (const std::string& file : events.dropped) attempt(viewer, [&] { open(viewer, file), changed = true; });
  for (const char key : events.keys) attempt(viewer, [&] { changed |= press(viewer, key); });
  if (events.clicked || events.double_clicked) attempt(viewer, [&] { pick(viewer, events); });
  if (events.input.moves()) {
    // The window shows the camera's image larger or smaller.
    const float scale = float(viewer.view.camera.fx / viewer.shown.fx);
    Input input = events.input;
    input.move *= viewer.speed, input.pan *= scale;
    attempt(viewer, [&] { viewer.view = moved(viewer.view, viewer.navigation, input); });
    viewer.plays = false, changed = true;
  }
  if (viewer.plays) play(viewer, events.seconds), changed = true;
  return changed;
}

/// Draws the frame that is due, if one is.
void draw_picture(Window& window, Viewer& viewer, Resolution& resolution) {
  const int width = window.width(), height = window.height();
  if (width == 0 || height == 0) return;  // minimised
  const double now = window_time();
  if (width != viewer.shown.width || height != viewer.shown.height) resolution.changed(now);
  const std::optional<double> scale = resolution.due(now);
  if (scale) {
    const bool follows = *scale == viewer.scale;  // a whole frame behind a movement is none of its frames
    viewer.shown = fitted(viewer.view.camera, width, height), viewer.scale = *scale;
    resolution.drew(*scale, Resolution::quick_frame);  // what cannot be drawn is not tried again
    viewer.drawing.draw(scaled(viewer.shown, *scale), viewer.counts);
    window.set_picture(viewer.drawing.picture());
    const double done = window_time(), apart = done - std::exchange(viewer.drawn_at, done);
    viewer.interval = follows && apart < longest_interval ? apart : 0;
    resolution.drew(*scale, done - now);
  }
  if (!viewer.compares || viewer.scale < 1) return viewer.error.reset();
  if (viewer.crop_x < 0) viewer.crop_x = width / 2, viewer.crop_y = height / 2;
  viewer.error = viewer.crop_error.of(
      viewer.drawing, crop_around(viewer.shown, viewer.crop_x, viewer.crop_y, CropError::side));
}

/// Writes the whole picture to a new file.
void save_picture(Viewer& viewer) {
  const std::string name = free_name("swiftgs", ".png");
  if (viewer.scale < 1) viewer.drawing.draw(viewer.shown, viewer.counts), viewer.scale = 1;
  write_png(name, viewer.drawing.picture());
  note(viewer, "wrote " + name);
}

/// Draws all that stands before the picture. Returns whether a new frame is needed.
bool draw_overlays(Viewer& viewer) {
  draw_marks(viewer);
  ask_to_quit(viewer);
  const bool changed = viewer.has_panels && draw_panels(viewer);
  if (viewer.has_panels) draw_legend(viewer);
  if (std::exchange(viewer.escapes, false)) viewer.messages.dismiss_last();  // nothing else took it
  viewer.messages.expire(window_time());
  draw_messages(viewer);
  return changed;
}

}  // namespace

std::vector<ShownScene> shown_scenes(const std::vector<ListedScene>& listed, const DrawnScenes& drawn) {
  std::vector<ShownScene> scenes;
  for (std::size_t i = 0; i < listed.size(); ++i)
    scenes.push_back(
        {listed[i], drawn.gaussians[drawn.placements[i].scene], drawn.pages[drawn.placements[i].scene]});
  return scenes;
}

void jump_to(Viewer& viewer, std::size_t camera) {
  const Scene& first = *viewer.drawing.scenes()[0].gaussians;
  const dvec3 middle = viewer.drawing.in_world(0, first.origin + robust_bounds(first).centre);
  viewer.camera = camera;
  viewer.view = view_through(viewer.cameras[camera].camera, viewer.view.up, middle, viewer.least_way);
}

void follow_path(Viewer& viewer) {
  const Camera camera = camera_at(viewer.path, viewer.path_at, viewer.shown.width, viewer.shown.height);
  const dvec3 ahead = viewer.view.target;
  viewer.view = view_through(camera, viewer.view.up, ahead, viewer.least_way);
}

void add_key(Viewer& viewer) {
  viewer.path.keys.push_back(viewer.shown);
  viewer.has_edited_path = true;
}

void save_path(Viewer& viewer) {
  const std::string file = name_or_free(viewer.path_file, "camera_path");
  write_camera_path(file, viewer.path, viewer.shown.width, viewer.shown.height,
                    viewer.drawing.scenes()[0].gaussians->origin);
  viewer.path_file = file, viewer.has_edited_path = false;
  note(viewer, "wrote " + file);
}

void save_scenes(Viewer& viewer) {
  const std::string file = name_or_free(viewer.list_file, "scenes");
  std::vector<ListedScene> listed;
  for (const ShownScene& scene : viewer.drawing.scenes()) listed.push_back(scene.listed);
  write_scenes(file, std::move(listed));
  viewer.list_file = file, viewer.has_edited_scenes = false;
  note(viewer, "wrote " + file);
}

void note(Viewer& viewer, std::string text) { viewer.messages.note(std::move(text), window_time()); }
void tell_error(Viewer& viewer, std::string text) { viewer.messages.error(std::move(text), window_time()); }

void run(Window& window, Viewer viewer) {
  Resolution resolution;
  bool busy = true;  // something changes without the user
  while (!viewer.quits) {
    Events events = window.begin_frame(busy);
    if (viewer.asks_to_quit) events.keys.clear();
    bool changed = act(viewer, events) || viewer.drawing.is_loading();
    if (events.closes) viewer.asks_to_quit = viewer.has_edited_scenes || has_unsaved_path(viewer);
    if (events.closes && !viewer.asks_to_quit) break;
    if (changed) resolution.changed(window_time());
    attempt(viewer, [&] { draw_picture(window, viewer, resolution); });
    if (std::exchange(viewer.saves_picture, false)) attempt(viewer, [&] { save_picture(viewer); });
    if (draw_overlays(viewer)) changed = true, resolution.changed(window_time());
    window.end_frame();
    busy = changed || viewer.crop_error.is_under_way() ||
           resolution.due(window_time() + Resolution::settles_after);
  }
}

}  // namespace swiftgs::cli
