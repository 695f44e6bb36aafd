// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

#include <CLI/CLI.hpp>

#include <swiftgs/io/replace_file.hpp>
#include <swiftgs/io/sort_calibrations.hpp>
#include <swiftgs/sort/adaptive.hpp>

#include "bench/measure.hpp"
#include "commands.hpp"
#include "draw/choice.hpp"
#include "draw/renderer_words.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "read/scene_input.hpp"
#include "read/views.hpp"

namespace swiftgs::cli {
namespace {

struct CalibrateOptions {
  SceneOptions scene;
  ViewOptions view;
  std::string renderer;  ///< empty for the adaptive form of `default_renderer()`
  std::string out;
};

void calibrate(const CalibrateOptions& options) {
  const std::string usual = RendererWords(default_renderer()).with_sort(AdaptiveSort::name);
  const std::string name = options.renderer.empty() ? usual : options.renderer;
  const RendererWords words(name);
  if (words.sort != AdaptiveSort::name)
    throw std::invalid_argument("--renderer " + name + ": expected the sort 'adaptive', as in " + usual);
  require_replaceable(options.out);
  if (std::filesystem::exists(options.out)) read_sort_calibrations(options.out);  // refuses other files
  const auto standard = make_renderer(words.with_sort(StandardSort::name));
  const auto early = make_renderer(words.with_sort(EarlySort::name));
  std::vector<std::string> notes;
  std::vector<View> views =
      views_of(read_cameras_of(options.scene, options.view.cameras, notes), options.view, "every:5");
  const DrawnScene drawn = load_to_draw(options.scene, notes);
  place_views(views, *drawn.gaussians, drawn.camera);
  const RenderSettings settings = settings_of(options.view);
  standard->set_scene(drawn.gaussians);
  early->share_scene(*standard);

  std::map<std::pair<int, int>, std::vector<Camera>> sizes;
  for (const View& view : views) sizes[{view.camera.width, view.camera.height}].push_back(view.camera);
  Progress progress(views.size());
  for (const auto& [size, cameras] : sizes) {
    SavedSortCalibration saved{{geometry_checksum(*drawn.gaussians), early->device_name(), name},
                               {drawn.gaussians->size(), size.first, size.second}};
    for (const Camera& camera : cameras) {
      progress.start(camera.name);
      const auto taken = measure({standard.get(), early.get()}, {&camera, 1}, settings, {});
      saved.measured.standard_ms += taken[0].summary().sort.median / double(cameras.size());
      saved.measured.early_ms += taken[1].summary().sort.median / double(cameras.size());
      progress.step();
    }
    add_sort_calibration(options.out, saved);
    progress.clear();
    std::printf("%s, %dx%d, %zu %s: standard %.3f ms, early %.3f ms, choice %s\n", name.c_str(), size.first,
                size.second, cameras.size(), cameras.size() == 1 ? "view" : "views",
                saved.measured.standard_ms, saved.measured.early_ms,
                saved.measured.prefers_early() ? "early" : "standard");
  }
}

constexpr const char* calibrate_help =
    R"(Sorts each view with 'standard' and with 'early', in turn, and adds the mean times to a file, for
'swiftgs render --calibration'. A file may hold any number of scenes, sizes, devices and renderers.

Examples:
  swiftgs calibrate garden.spz --cameras cameras.json --out garden.sort.json
  swiftgs calibrate garden/ --renderer cuda/adaptive/per-pixel/ellipse --out sorts.json)";

}  // namespace

void add_calibrate(CLI::App& app) {
  CLI::App* command = app.add_subcommand("calibrate", "Measures which sort is quicker for a scene");
  command->footer(calibrate_help);
  const auto options = std::make_shared<CalibrateOptions>();
  add_scene(*command, options->scene);
  add_views(*command, options->view, "every:5");
  command->add_option("--renderer", options->renderer,
                      "A name from 'swiftgs list' with the sort 'adaptive'\n[the quickest on the CPU]");
  command->add_option("--out", options->out, "File to add to")->required();
  command->callback([options] { calibrate(*options); });
}

}  // namespace swiftgs::cli
