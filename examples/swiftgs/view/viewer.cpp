// SPDX-License-Identifier: Apache-2.0
#include "view/viewer.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <utility>

#include <imgui.h>

#include <swiftgs/io/image.hpp>
#include <swiftgs/scene_bounds.hpp>

#include "view/resolution.hpp"
#include "view/window.hpp"

namespace swiftgs::cli {
namespace {

namespace fs = std::filesystem;

/// Between frames that follow each other. @units{seconds}
constexpr double longest_interval = 0.5;

/// Adds scenes of a file, in the world of the first one.
void add_scenes(Viewer& viewer, const std::string& file) {
  const std::vector<ListedScene> listed = scenes_of({file}, true);
  std::vector<std::string> notes;
  const DrawnScenes drawn = load_to_place(listed, viewer.reading, notes);
  const dvec3 apart = drawn.gaussians[0]->origin - viewer.drawing.scenes[0].gaussians->origin;
  for (ShownScene& scene : shown_scenes(listed, drawn)) {
    scene.placement.world_from_scene.translation += apart;
    viewer.drawing.add(std::move(scene));
  }
  viewer.picked.reset();
}

/// Opens a path, or else scenes.
void open(Viewer& viewer, const std::string& file) {
  if (is_camera_path(file))
    viewer.path = read_camera_path(file, viewer.drawing.scenes[0].gaussians->origin), viewer.path_at = 0;
  else
    add_scenes(viewer, file);
  viewer.message = "opened " + file;
}

/// The first of swiftgs-1.png, swiftgs-2.png and so on that is not there.
std::string free_name() {
  for (int number = 1;; ++number)
    if (std::string name = "swiftgs-" + std::to_string(number) + ".png"; !fs::exists(name)) return name;
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
      viewer.path.keys.push_back(viewer.shown);
      break;
    case ' ':
      viewer.plays = !viewer.plays && !viewer.path.keys.empty();
      break;
    case 'H':
      viewer.has_panels = !viewer.has_panels;
      break;
    case 'P': {
      const std::string name = free_name();
      if (viewer.scale < 1) viewer.drawing.draw(viewer.shown, viewer.counts), viewer.scale = 1;
      write_png(name, viewer.drawing.picture());
      viewer.message = "wrote " + name;
      break;
    }
    case 'F':
      if (!viewer.path.keys.empty()) save_path(viewer);
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
  const ShownScene& scene = viewer.drawing.scenes[viewer.picked->scene];
  const dvec3 mean(scene.gaussians->means[viewer.picked->gaussian]);
  viewer.view.target = scene.placement.world_from_scene(mean);
  viewer.navigation = Navigation::orbit;
}

/// Applies `events` to `viewer`. Returns whether a new frame is needed.
bool act(Viewer& viewer, const Events& events) {
  bool changed = false;
  if (!events.keys.empty() || events.clicked) viewer.message.clear();  // it was read
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
  if (viewer.plays) {
    viewer.path_at = viewer.path_at >= viewer.path.seconds() ? 0 : viewer.path_at + events.seconds;
    viewer.plays = viewer.path_at < viewer.path.seconds();
    follow_path(viewer), changed = true;
  }
  return changed;
}

/// Marks the crop that is compared, and the Gaussian that was picked.
void draw_marks(const Viewer& viewer) {
  const ImVec2 points = ImGui::GetIO().DisplayFramebufferScale;
  ImDrawList& marks = *ImGui::GetBackgroundDrawList();
  const auto at = [&](double x, double y) { return ImVec2(float(x) / points.x, float(y) / points.y); };
  if (viewer.compares) {
    const Camera crop = crop_around(viewer.shown, viewer.crop_x, viewer.crop_y, CropError::side);
    const double x = viewer.shown.cx - crop.cx, y = viewer.shown.cy - crop.cy;
    marks.AddRect(at(x, y), at(x + crop.width, y + crop.height), IM_COL32(255, 255, 255, 255));
  }
  if (!viewer.picked || !viewer.shown.lens.is_pinhole()) return;
  const ShownScene& scene = viewer.drawing.scenes[viewer.picked->scene];
  const dvec3 mean(scene.gaussians->means[viewer.picked->gaussian]);
  const Camera& camera = viewer.shown;
  const dvec3 p = camera.rotation * scene.placement.world_from_scene(mean) + camera.translation;
  if (p.z > 0)
    marks.AddCircle(at(camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy), 6,
                    IM_COL32(255, 255, 0, 255));
}

void draw_message(const std::string& message) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x - 8, size.y - 8), ImGuiCond_Always, ImVec2(1, 1));
  ImGui::Begin("message", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoInputs);
  ImGui::TextUnformatted(message.c_str());
  ImGui::End();
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

}  // namespace

std::vector<ShownScene> shown_scenes(const std::vector<ListedScene>& listed, const DrawnScenes& drawn) {
  std::vector<ShownScene> scenes;
  for (std::size_t i = 0; i < listed.size(); ++i)
    scenes.push_back({.name = fs::path(listed[i].file).filename().string(),
                      .gaussians = drawn.gaussians[drawn.placements[i].scene],
                      .placement = drawn.placements[i]});
  return scenes;
}

void jump_to(Viewer& viewer, std::size_t camera) {
  const Scene& first = *viewer.drawing.scenes[0].gaussians;
  const dvec3 middle = viewer.drawing.scenes[0].placement.world_from_scene(robust_bounds(first).centre);
  viewer.camera = camera;
  viewer.view = view_through(viewer.cameras[camera].camera, viewer.view.up, middle, viewer.least_way);
}

void follow_path(Viewer& viewer) {
  const Camera camera = camera_at(viewer.path, viewer.path_at, viewer.shown.width, viewer.shown.height);
  const dvec3 ahead = viewer.view.target;
  viewer.view = view_through(camera, viewer.view.up, ahead, viewer.least_way);
}

void save_path(Viewer& viewer) {
  write_camera_path(viewer.path_file, viewer.path, viewer.shown.width, viewer.shown.height,
                    viewer.drawing.scenes[0].gaussians->origin);
  viewer.message = "wrote " + viewer.path_file;
}

void run(Window& window, Viewer viewer) {
  Resolution resolution;
  bool busy = true;  // something changes without the user
  while (window.is_open()) {
    const Events events = window.begin_frame(busy);
    bool changed = act(viewer, events);
    if (viewer.has_panels) changed |= draw_panels(viewer);
    if (changed) resolution.changed(window_time());
    attempt(viewer, [&] { draw_picture(window, viewer, resolution); });
    draw_marks(viewer);
    if (!viewer.message.empty()) draw_message(viewer.message);
    window.end_frame();
    busy = changed || viewer.crop_error.is_under_way() ||
           resolution.due(window_time() + Resolution::settles_after);
  }
}

}  // namespace swiftgs::cli
