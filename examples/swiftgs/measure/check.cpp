// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "commands.hpp"
#include "draw/choice.hpp"
#include "draw/team.hpp"
#include "json.hpp"
#include "measure/photos.hpp"
#include "notes.hpp"
#include "options.hpp"
#include "read/distinct_files.hpp"
#include "read/scene_input.hpp"
#include "read/views.hpp"
#include "result_file.hpp"

namespace swiftgs::cli {
namespace {

struct CheckOptions {
  SceneOptions scene;
  ViewOptions view;
  std::string renderers = "*";  ///< glob
  std::string photos;           ///< folder of photographs, or empty for that of the capture
  std::string json;             ///< file to write, or empty
  int repeats = 3;              ///< frames that are timed, after one that is not
};

/// What every renderer is given and judged by.
struct Task {
  std::string scene_name;
  std::shared_ptr<const Scene> scene;
  std::vector<View> views;
  RenderSettings settings;
  std::vector<std::vector<double>> references;  ///< colours of the float64 frame of each view
  std::vector<std::optional<Image>> photos;     ///< of each view, or empty
  int repeats = 3;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

/// Renders one view `repeats` times after a frame that is not timed; each stage's median.
StageTimes times_of(AnyRenderer& renderer, const Camera& camera, const RenderSettings& settings, int repeats,
                    Frame& frame) {
  std::vector<double> project, sort, raster, total;
  renderer.render(camera, settings, frame);
  for (int i = 0; i < repeats; ++i) {
    renderer.render(camera, timed(settings), frame);
    const StageTimes ms = renderer.times();
    project.push_back(ms.project), sort.push_back(ms.sort);
    raster.push_back(ms.raster), total.push_back(ms.total);
  }
  return {median(project), median(sort), median(raster), median(total)};
}

CheckResult judge(const Task& task, std::size_t view, AnyRenderer& renderer, Frame& frame) {
  const Camera& camera = task.views[view].camera;
  CheckResult result{.renderer = std::string(renderer.name()),
                     .scene = task.scene_name,
                     .view = task.views[view].name,
                     .width = camera.width,
                     .height = camera.height,
                     .ms = times_of(renderer, camera, task.settings, task.repeats, frame),
                     .psnr_db = psnr(frame.colour, task.references[view]),
                     .max_abs = max_abs_difference(frame.colour, task.references[view]),
                     .photo_psnr_db = std::nullopt};
  if (!task.photos.empty() && task.photos[view])
    result.photo_psnr_db = psnr_against(*task.photos[view], frame);
  return result;
}

void print_header(std::size_t name_width, bool with_photos) {
  std::printf("%-*s %-14s %11s %8s %8s %8s %8s %8s %9s", int(name_width), "renderer", "view", "size",
              "project", "sort", "raster", "total ms", "PSNR dB", "max abs");
  std::printf(with_photos ? " %8s\n" : "\n", "photo dB");
}

void print_row(const CheckResult& r, std::size_t name_width, bool with_photos) {
  const std::string size = std::to_string(r.width) + "x" + std::to_string(r.height);
  std::printf("%-*s %-14s %11s %8.2f %8.2f %8.2f %8.2f %8.2f %9.2e", int(name_width), r.renderer.c_str(),
              r.view.c_str(), size.c_str(), r.ms.project, r.ms.sort, r.ms.raster, r.ms.total, r.psnr_db,
              r.max_abs);
  if (with_photos && r.photo_psnr_db) std::printf(" %8.3f", *r.photo_psnr_db);
  if (with_photos && !r.photo_psnr_db) std::printf(" %8s", "-");
  std::printf("\n");
  std::fflush(stdout);
}

/// Means over the views of one renderer; the largest of the largest differences. The photographs' mean is
/// over the views that have one.
CheckResult mean_of(Span<const CheckResult> results) {
  CheckResult mean = results[0];
  mean.view = "mean";
  mean.ms = {}, mean.psnr_db = 0, mean.photo_psnr_db.reset();
  const double part = 1 / double(results.size);
  double photo_sum = 0, photos = 0;
  for (const CheckResult& r : results) {
    mean.ms.project += part * r.ms.project, mean.ms.sort += part * r.ms.sort;
    mean.ms.raster += part * r.ms.raster, mean.ms.total += part * r.ms.total;
    mean.psnr_db += part * r.psnr_db;
    mean.max_abs = std::max(mean.max_abs, r.max_abs);
    if (r.photo_psnr_db) photo_sum += *r.photo_psnr_db, ++photos;
  }
  if (photos > 0) mean.photo_psnr_db = photo_sum / photos;
  return mean;
}

void check(const CheckOptions& options) {
  if (options.repeats < 1)
    throw std::invalid_argument("--repeats " + std::to_string(options.repeats) + ": expected at least 1");
  require_distinct({{"--json", options.json}},
                   {{"SCENE", capture_of(options.scene).scene.string()},
                    {"--cameras", cameras_of(options.scene, options.view.cameras)}});
  const std::vector<RendererEntry> entries = renderers_matching(options.renderers);
  Task task;
  task.scene_name = capture_of(options.scene).name;
  task.repeats = options.repeats;
  std::vector<std::string> notes;
  const Cameras cameras = read_cameras_of(options.scene, options.view.cameras, notes);
  task.views = views_of(cameras, options.view, "every:8");
  task.settings = settings_of(options.view);
  const DrawnScene drawn = load_to_draw(options.scene, notes);
  task.scene = drawn.gaussians;
  place_views(task.views, *task.scene, drawn.camera);
  task.photos = photographs_of(task.views, cameras, photos_of(options.scene, options.view, options.photos),
                               options.view.scale, task.settings.background, notes);
  if (task.photos.empty() && !options.photos.empty())
    throw std::invalid_argument(options.photos + ": expected a photograph with the path of a view, such as " +
                                task.views.front().camera.name);
  ResultFile json(options.json);
  ResultHead head = json.is_wanted() ? head_of("swiftgs-check") : ResultHead();
  head.notes = std::move(notes);

  Progress progress(task.views.size() * (1 + entries.size()));
  const dvec3 background(task.settings.background);
  const Team& team = Team::here();
  for (std::size_t i = 0; i < task.views.size(); ++i) {
    task.references.emplace_back();
    if (!team.takes(i)) continue;
    const View& view = task.views[i];
    progress.start("reference " + view.name);
    task.references.back() =
        render_reference(*task.scene, view.camera, task.settings.conventions, background).colour;
    progress.step();
  }

  std::size_t width = 8;
  for (const RendererEntry& entry : entries) width = std::max(width, entry.name.size());
  const bool with_photos = !task.photos.empty();
  const std::size_t views = task.views.size();
  Numbered<CheckResult> numbered;
  // Rows of a process alone are printed as they come.
  const auto print = [&](const CheckResult& row) { print_row(row, width, with_photos); };
  const auto print_mean = [&](const std::vector<CheckResult>& rows) {
    if (views > 1) print(mean_of({rows.data(), views}));
  };
  progress.clear();
  print_header(width, with_photos);
  std::uint64_t numbered_from = 0;
  for (const RendererEntry& entry : entries) {
    // Only one renderer at a time holds memory.
    const std::unique_ptr<AnyRenderer> renderer = entry.make();
    renderer->set_scene(task.scene);
    Frame frame;
    std::vector<CheckResult> of_renderer;
    for (std::size_t view = 0; view < views; ++view) {
      if (!team.takes(view)) continue;
      progress.start(entry.name);
      const CheckResult row = judge(task, view, *renderer, frame);
      numbered.emplace_back(numbered_from + view, row);
      progress.step();
      progress.clear();
      if (team.is_shared()) continue;
      print(row);
      of_renderer.push_back(row);
    }
    if (!team.is_shared()) print_mean(of_renderer);
    numbered_from += views;
  }
  progress.await_others();
  progress.clear();
  team.join(numbered);
  const std::vector<CheckResult> results = rows_of(std::move(numbered));
  if (!team.leads()) return;
  for (std::size_t first = 0; team.is_shared() && first < results.size(); first += views) {
    const std::vector<CheckResult> rows(results.begin() + std::ptrdiff_t(first),
                                        results.begin() + std::ptrdiff_t(first + views));
    for (const CheckResult& row : rows) print(row);
    print_mean(rows);
  }
  if (json.is_wanted()) json.write(to_json(head, results, with_photos));
  json.finish();
}

constexpr const char* check_help =
    R"(Times are medians of --repeats frames after one that is not counted. PSNR and the largest
difference are against the float64 reference with the same conventions. The table has a row
of means for each renderer, with the worst difference. In JSON, an infinite PSNR is null.
Frames are also compared with photographs, and results gain photo_psnr_db: with those of
--photos, or those in 'photos' of a capture. An image has the photograph of its path below
that folder, or of its name if no other image is called so. --scale scales photographs too,
unless they have the scaled size; those with alpha are laid over the background.

Examples:
  swiftgs check builtin:20000 --renderers 'serial/early/per-pixel/*'
  swiftgs check garden.spz --cameras cameras.json --photos photos --json results.json)";

}  // namespace

void add_check(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("check", "Errors and times of renderers, against a float64 reference");
  command->footer(check_help);
  const auto options = std::make_shared<CheckOptions>();
  add_scene(*command, options->scene);
  add_views(*command, options->view, "every:8");
  command->add_option("--renderers", options->renderers, "Names with * for any text, separated by commas")
      ->capture_default_str();
  command->add_option(
      "--photos", options->photos,
      "Folder with photographs that have the paths of the images\n[photos in SCENE where it is "
      "a folder, without --cameras]");
  add_json(*command, options->json);
  command->add_option("--repeats", options->repeats, "How many frames are timed")->capture_default_str();
  command->callback([options] { check(*options); });
}

}  // namespace swiftgs::cli
