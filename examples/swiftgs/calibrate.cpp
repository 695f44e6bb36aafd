// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/sort/adaptive.hpp>

#include "calibration_check.hpp"
#include "calibration_store.hpp"
#include "calibrations.hpp"
#include "choice.hpp"
#include "commands.hpp"
#include "distinct_files.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "renderer_words.hpp"
#include "scene_input.hpp"
#include "sort_timing.hpp"
#include "view_sizes.hpp"
#include "views.hpp"

namespace swiftgs::cli {
namespace {

struct CalibrateOptions {
  SceneOptions scene;
  ViewOptions view;
  std::string renderers;  ///< glob
  std::string out;        ///< file, or empty for the one beside the scene
  std::vector<double> scales{1};
  std::uint64_t seed = 1;
  bool check = false;
  std::string check_views;  ///< as `choose_views` takes them; empty for all
  std::string json;         ///< file for the rows of the check, or empty
};

/// The renderers that `render` would use, but for the sort.
std::string default_renderers() { return adaptive_renderers(default_renderer()); }

/// Names of adaptive renderers that match `pattern`, one for each backend and bounds: the rasterizer has no
/// part in the sort.
std::vector<std::string> distinct_sorts(const std::string& pattern) {
  std::map<std::pair<std::string, std::string>, std::string> names;
  for (const RendererEntry& entry : renderers_matching(pattern)) {
    const RendererWords words(entry.name);
    // Of the rasterizers the last: the quickest where a backend has them all.
    if (words.sort == AdaptiveSort::name) names[{words.backend, words.bounds}] = entry.name;
  }
  std::vector<std::string> distinct;
  for (auto& [key, name] : names) distinct.push_back(std::move(name));
  if (distinct.empty())
    throw std::invalid_argument("--renderers '" + pattern +
                                "': expected one with the sort 'adaptive', such as '" + default_renderers() +
                                "'");
  return distinct;
}

void print_strategy(const char* name, const StrategyTimes& times) {
  std::printf("  %-8s %8.3f ms +- %.3f, %zu %s:", name, mean_of(times.ms), spread_of(times.ms),
              times.ms.size(), times.ms.size() == 1 ? "view" : "views");
  for (const std::string& view : times.views) std::printf(" %s", view.c_str());
  std::printf("\n");
}

/// Prints what was measured of one sort at one image size.
void print_choice(const SortCalibrationKey& key, const SortCalibration& measured, const SortTimes& times) {
  std::printf("%s with %s, %dx%d, on %s\n", key.backend.c_str(), key.bounds.c_str(), measured.width,
              measured.height, key.device.c_str());
  print_strategy("standard", times.standard);
  print_strategy("early", times.early);
  std::printf("  choice   %s", measured.prefers_early() ? "early" : "standard");
  if (const std::optional<double> regret = expected_regret(times))
    std::printf(", expected regret %.2f %% of the sort\n", 100 * *regret);
  else
    std::printf(", expected regret unknown from one pair of views\n");
  std::fflush(stdout);
}

/// One sort at one image size: measures and prints.
SavedSortCalibration calibrate_size(const CalibrateOptions& options, const Scene& scene,
                                    const std::string& checksum, const std::vector<View>& views,
                                    const RenderSettings& settings, AnyRenderer& standard,
                                    AnyRenderer& early) {
  std::vector<View> chosen;
  for (const std::size_t number : random_fifth(views.size(), options.seed)) chosen.push_back(views[number]);
  Progress progress(chosen.size() + std::max<std::size_t>(2, chosen.size()));
  const SortTimes times = time_sorts(standard, early, chosen, settings, options.seed, progress);
  progress.clear();
  const SavedSortCalibration saved{.key = calibration_key(early, checksum),
                                   .measured = {.gaussians = scene.size(),
                                                .width = views.front().camera.width,
                                                .height = views.front().camera.height,
                                                .standard_ms = times.standard_ms(),
                                                .early_ms = times.early_ms()},
                                   .views = int(times.early.ms.size())};
  print_choice(saved.key, saved.measured, times);
  return saved;
}

/// Throws unless the options go together; `file` is where the calibration goes.
void check_options(const CalibrateOptions& options, const std::string& file) {
  if (file.empty())
    throw std::invalid_argument("--out: expected a file, as the built-in scene has none beside it");
  if (!options.check_views.empty() && !options.check)
    throw std::invalid_argument("--check-views: expected --check with it");
  if (!options.json.empty() && !options.check)
    throw std::invalid_argument("--json: expected --check with it");
  require_distinct({{"--out", file}, {"--json", options.json}},
                   {{"SCENE", capture_of(options.scene).scene.string()},
                    {"--cameras", cameras_of(options.scene, options.view.cameras)}});
}

void calibrate(const CalibrateOptions& options) {
  check_options(options, calibration_file(options.scene, options.out));
  const std::vector<std::string> names =
      distinct_sorts(options.renderers.empty() ? default_renderers() : options.renderers);
  ViewOptions view = options.view;
  if (options.check) view.views = options.check_views.empty() ? "all" : options.check_views;
  std::vector<std::string> notes;
  std::vector<SizeGroup> groups =
      group_by_size(read_cameras_of(options.scene, view.cameras, notes), view, options.scales);
  RenderSettings settings = settings_of(options.view);
  const DrawnScene drawn = load_to_draw(options.scene, notes);
  const auto scene = drawn.gaussians;
  for (SizeGroup& group : groups)
    find_views(group.views, *scene, drawn.camera), find_views(group.checked, *scene, drawn.camera);
  settings = settings_for(settings, *scene);
  const std::string checksum = scene_checksum(*scene);
  CalibrationStore store(calibration_files(options.scene, options.out));
  CalibrationCheck check(options.json, options.scene, std::move(notes));

  for (const std::string& name : names) {
    const RendererWords words(name);
    const std::unique_ptr<AnyRenderer> standard = make_renderer(words.with_sort(StandardSort::name)),
                                       early = make_renderer(words.with_sort(EarlySort::name));
    standard->set_scene(scene);
    early->share_scene(*standard);
    for (const SizeGroup& group : groups) {
      const SavedSortCalibration measured =
          calibrate_size(options, *scene, checksum, group.views, settings, *standard, *early);
      store.add(measured);
      if (!options.check) continue;
      if (group.checked.empty()) {
        const Camera& camera = group.views.front().camera;
        std::printf("  check    none: of --check-views %s none is %dx%d\n", options.check_views.c_str(),
                    camera.width, camera.height);
        continue;
      }
      const std::unique_ptr<AnyRenderer> adaptive = make_renderer(name);
      adaptive->share_scene(*standard);
      adaptive->use_calibrations({measured.measured});
      check.run({standard.get(), early.get(), adaptive.get()}, group.checked, settings, scene->size());
    }
  }
  check.finish();
  std::printf("%s\n", store.summary().c_str());
}

constexpr const char* more =
    R"(Picks a fifth of the views at random and sorts half of them with 'standard' and half with
'early'. The sort with the lower mean time wins. Renderers with the sort 'adaptive' use it for this
scene from then on. 'render', 'check' and 'bench' find it by themselves.
The result holds for one image size, device, backend and kind of bounds (the last word of a
renderer's name). A file keeps the results for all of them. It lies beside the scene, or in
~/.cache/swiftgs ($XDG_CACHE_HOME/swiftgs if set) if the scene's folder cannot be written.
Commands ignore a file that does not fit the scene, say so, and measure while they render.
+- is the standard deviation over the views.
--check renders views with 'standard', 'early' and 'adaptive' in turn. It prints how much longer
the frame and its sort took with 'adaptive' than with the better of the others, +- the standard
error.

Examples:
  swiftgs calibrate garden.spz --cameras cameras.json
  swiftgs calibrate garden.spz --cameras cameras.json --scale 0.5,1 --renderers 'cuda/adaptive/*/*'
  swiftgs calibrate builtin:1000000 --out builtin.sort.json --check)";

}  // namespace

void add_calibrate(CLI::App& app) {
  CLI::App* command = app.add_subcommand("calibrate", "Measures which sort strategy is better for a scene");
  command->footer(more);
  const auto options = std::make_shared<CalibrateOptions>();
  add_scene(*command, options->scene);
  add_cameras(*command, options->view);
  command->add_option("--scale", options->scales, "Factors of the images' sides, as 1,2")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--renderers", options->renderers,
                      "Names with * for any text; their backends and bounds count [those of 'render']");
  command->add_option("--seed", options->seed, "Seed of the random choice of views")->capture_default_str();
  command->add_option("--out", options->out,
                      "File to add to [SCENE.sort.json, else a file in ~/.cache/swiftgs]");
  command->add_flag("--check", options->check, "Compare the choice with both strategies, in frames");
  add_view_choice(*command, "--check-views", options->check_views, "Views to compare on")->default_str("all");
  add_json(*command, options->json, "the results of --check");
  command->callback([options] { calibrate(*options); });
}

}  // namespace swiftgs::cli
