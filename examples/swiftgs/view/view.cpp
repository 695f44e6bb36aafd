// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/io/scene_file.hpp>

#include "commands.hpp"
#include "draw/page_frames.hpp"
#include "draw/team.hpp"
#include "options.hpp"
#if !defined(SWIFTGS_VIEW_LACKS)
#include <utility>

#include <glm/geometric.hpp>

#include <swiftgs/default_view.hpp>

#include "read/placed_input.hpp"
#include "read/scene_input.hpp"
#include "view/viewer.hpp"
#include "view/window.hpp"
#endif

namespace swiftgs::cli {
namespace {

struct ViewCommand {
  std::vector<std::string> scenes;
  SceneOptions scene;  ///< how to read them; of the first one
  ViewOptions view;
  std::string renderer, path;
  PageOptions pages;
};

#if !defined(SWIFTGS_VIEW_LACKS)

/// The world's up: that of most cameras, or without cameras that of `default_view`.
dvec3 up_of(const std::vector<View>& views, bool to_find, const ShownScene& first) {
  dvec3 up(0);
  for (const View& view : views)
    up -= dvec3(view.camera.rotation[0][1], view.camera.rotation[1][1], view.camera.rotation[2][1]);
  if (!to_find && glm::length(up) > 0.1 * double(views.size())) return glm::normalize(up);
  return first.listed.world_from_scene.rotation * default_view(*first.gaussians).up;
}

void view(ViewCommand options) {
  if (Team::here().is_shared()) throw std::invalid_argument("view: found several processes, expected one");
  Window window("SwiftGS", 1280, 720);  // where there is no display, nothing is read
  const std::vector<ListedScene> listed = scenes_of(options.scenes, true);
  options.scene.scene = listed[0].file;
  std::vector<std::string> notes;
  const Cameras cameras = read_cameras_of(options.scene, options.view.cameras, notes);
  options.view.views = "all";
  std::vector<View> views = views_of(cameras, options.view, "all");
  const DrawnScenes drawn = load_to_place(listed, options.scene, notes);
  place_views(views, drawn);
  const Scene& first = *drawn.gaussians[0];
  const RenderSettings settings = settings_of(options.view);
  std::vector<ShownScene> scenes = shown_scenes(listed, drawn);
  const std::string title = "SwiftGS - " + scenes[0].name();
  const double radius = robust_bounds(first).radius * listed[0].world_from_scene.scale;
  const dvec3 up = up_of(views, cameras.to_find, scenes[0]);
  Viewer viewer(Drawing(find_renderer(options.renderer).name, settings, options.pages, std::move(scenes)));
  viewer.reading = options.scene, viewer.cameras = std::move(views);
  viewer.view.up = up, viewer.speed = radius, viewer.least_way = 0.2 * radius;
  if (options.scenes.size() == 1 && is_scene_list(options.scenes[0])) viewer.list_file = options.scenes[0];
  if (!options.path.empty()) {
    viewer.path_file = options.path;
    if (std::filesystem::exists(options.path)) viewer.path = read_camera_path(options.path, first.origin);
  }
  jump_to(viewer, 0);
  window.show(title);
  run(window, std::move(viewer));
}

#else

void view(const ViewCommand&) {
  throw std::runtime_error("view: built without " SWIFTGS_VIEW_LACKS
                           ": install them, then configure and build again");
}

#endif

constexpr const char* view_help =
    R"(Opens a window. Drag to turn, with the right button to pan; the wheel and W, A, S, D, Q, E move,
as orbit, fly or walk (1, 2, 3). Click on a Gaussian to see its numbers, twice to orbit it. Panels
have the cameras to jump to (N, B, R), each scene's place, clip and visibility, the renderer, a
plane, the error beside float64 in a square, what a frame had to do, and a path of keys (K) to play
(space) and save (F). L saves the list of scenes as they are placed, to the list that was opened or
to scenes-1.json and so on, for 'swiftgs render'. P writes the picture to swiftgs-1.png and so on,
H hides the panels, Esc closes a list or dismisses an error. Dropped files are added: scenes, or a
camera_path.json. While the camera moves or pages come, the picture has half the size if it is slow.

Examples:
  swiftgs view garden/
  swiftgs view room.spz chair.ply
  swiftgs view city.sgp --pool 4000
  swiftgs view garden.spz --path camera_path.json)";

}  // namespace

void add_view(CLI::App& app) {
  CLI::App* command = app.add_subcommand("view", "Shows scenes in a window");
  command->footer(view_help);
  const auto options = std::make_shared<ViewCommand>();
  command
      ->add_option(
          "SCENE", options->scenes,
          std::string("Files, folders of captures, builtin, or builtin:N for N Gaussians; files are\n") +
              readable_scenes() + ",\nor a .json list of scenes; each stands where its file has it")
      ->required();
  add_scene_reading(*command, options->scene);
  add_cameras(*command, options->view);
  command->add_option("--renderer", options->renderer,
                      "A name from 'swiftgs list' [that of the quickest backend]");
  add_page_options(*command, options->pages, options->scene);
  command->add_option("--path", options->path,
                      "A camera_path.json: read if it is there, and saved to [camera_path-1.json or\n"
                      "another number, whichever is free]");
  command->callback([options] { view(*options); });
}

}  // namespace swiftgs::cli
