// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/edit/pruning.hpp>
#include <swiftgs/io/replace_file.hpp>

#include "commands.hpp"
#include "draw/choice.hpp"
#include "draw/team.hpp"
#include "measure/photos.hpp"
#include "measure/prune_judge.hpp"
#include "notes.hpp"
#include "options.hpp"
#include "read/distinct_files.hpp"
#include "read/scene_input.hpp"
#include "read/views.hpp"
#include "result_file.hpp"

namespace swiftgs::cli {
namespace {

constexpr const char* training_views = "except:8";  ///< of the captures that scenes are usually trained with

struct PruneOptions {
  SceneOptions scene;
  ViewOptions view;
  double keep = 0;
  std::string score = "contribution";
  std::string backend;  ///< empty for the first that can run
  std::string out, photos, json;
};

bool has_cameras(const PruneOptions& options) {
  return builtin_size(options.scene.scene) || !cameras_of(options.scene, options.view.cameras).empty();
}

/// Throws unless the options go together.
void check_options(const PruneOptions& options) {
  require_keep(options.keep);
  if (options.score != "contribution" && options.score != "opacity-volume")
    throw std::invalid_argument("--score '" + options.score + "': expected contribution or opacity-volume");
  if (std::filesystem::path(options.out).extension() != ".ply")
    throw std::invalid_argument("--out '" + options.out + "': expected a name that ends in .ply");
  require_distinct({{"--out", options.out}, {"--json", options.json}},
                   {{"SCENE", capture_of(options.scene).scene.string()},
                    {"--cameras", cameras_of(options.scene, options.view.cameras)}});
  if (has_cameras(options)) return;
  if (options.score == "contribution")
    throw std::invalid_argument(
        "--score contribution: expected --cameras, as it sums weights in views of the scene");
  if (!options.photos.empty() || !options.view.views.empty())
    throw std::invalid_argument("--photos and --views: expected --cameras with them");
}

/// Indices of the Gaussians to keep, and the share of all scores that they have.
template <class Score>
std::vector<std::uint32_t> choose(const std::vector<Score>& scores, double keep, double& kept_weight) {
  const std::vector<std::uint32_t> kept = highest(scores, kept_count(keep, scores.size()));
  const double all = std::accumulate(scores.begin(), scores.end(), 0.0,
                                     [](double sum, Score score) { return sum + double(score); });
  const double of_kept = std::accumulate(
      kept.begin(), kept.end(), 0.0, [&](double sum, std::uint32_t i) { return sum + double(scores[i]); });
  if (!scores.empty() && !(all > 0))
    throw std::runtime_error("no Gaussian has a score above 0; expected views that show the scene");
  kept_weight = all > 0 ? of_kept / all : 1;
  return kept;
}

/// Sums of the blending weights over `views`.
std::vector<std::uint64_t> contributions_of(const ContributionsEntry& backend,
                                            const std::shared_ptr<const Scene>& scene,
                                            const std::vector<View>& views, const Conventions& conventions,
                                            Progress& progress) {
  const std::unique_ptr<AnyContributions> contributions = backend.make(scene);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!Team::here().takes(i)) continue;
    progress.start("weights in " + views[i].name);
    contributions->add(views[i].camera, conventions);
    progress.step();
  }
  progress.await_others();
  std::vector<std::uint64_t> sums = contributions->sums();
  Team::here().add_up(sums);
  return sums;
}

HeldOut held_out_of(const PruneOptions& options, const ViewOptions& view, const Cameras& cameras,
                    const std::string& backend, std::vector<std::string>& notes) {
  HeldOut held_out{
      .views = {}, .photos = {}, .settings = settings_of(view), .renderer = exact_renderer(backend)};
  if (view.views.empty()) return held_out;
  held_out.views = views_left_out(cameras, view);
  held_out.photos = photographs_of(held_out.views, cameras, photos_of(options.scene, view, options.photos),
                                   view.scale, held_out.settings.background, notes);
  if (held_out.photos.empty() && !options.photos.empty())
    throw std::invalid_argument(options.photos + ": expected photographs of views that --views '" +
                                view.views + "' leaves out");
  return held_out;
}

void prune(const PruneOptions& options) {
  check_options(options);
  const ContributionsEntry& backend = contribution_backend(options.backend);
  ViewOptions view = options.view;
  if (view.views.empty() && has_cameras(options)) view.views = training_views;
  std::vector<std::string> notes;
  const Cameras cameras = read_cameras_of(options.scene, view.cameras, notes);
  HeldOut held_out = held_out_of(options, view, cameras, std::string(backend.backend), notes);
  const bool by_contribution = options.score == "contribution";
  std::vector<View> views = by_contribution ? views_of(cameras, view, training_views) : std::vector<View>();
  const auto scene = load_to_draw(options.scene, notes).gaussians;
  place_views(views, *scene, std::nullopt), place_views(held_out.views, *scene, std::nullopt);
  if (Team::here().leads()) require_replaceable(options.out);
  ResultFile json(options.json);

  PruneResult result{.scene = capture_of(options.scene).name,
                     .score = options.score,
                     .backend = std::string(backend.backend),
                     .conventions = view.conventions,
                     .keep = options.keep,
                     .views = views.size(),
                     .held_out = held_out.views.size()};
  if (!options.json.empty()) result.head = head_of("swiftgs-prune");
  Progress progress(views.size() + 2 * held_out.views.size());
  const std::vector<std::uint32_t> kept =
      by_contribution
          ? choose(contributions_of(backend, scene, views, held_out.settings.conventions, progress),
                   options.keep, result.kept_weight)
          : choose(opacity_volumes(*scene), options.keep, result.kept_weight);
  const auto pruned = std::make_shared<const Scene>(subset(*scene, kept));
  progress.clear();
  if (Team::here().leads())
    say_notes(options.out, write_scene(options.out, *pruned, {.ending = ".ply"}).notes, notes);
  result.head.notes = std::move(notes);
  std::printf("%s: kept %zu of %zu Gaussians, with %.2f %% of the %s\n", options.out.c_str(), kept.size(),
              scene->size(), 100 * result.kept_weight,
              by_contribution ? "weight in the views" : "opacity times volume");
  std::fflush(stdout);

  std::vector<std::vector<float>> unpruned;
  result.before = judge(held_out, scene, unpruned, progress);
  result.after = judge(held_out, pruned, unpruned, progress);
  progress.clear();
  if (!held_out.views.empty()) print_table(result);
  json.write(to_json(result));
  json.finish();
}

constexpr const char* prune_help =
    R"(Scores: 'contribution' is the blending weight of a Gaussian, alpha times transmittance, summed over
all pixels of the views. 'opacity-volume' is opacity times the product of the scales, and needs no
views. The highest scores are kept, in the order of the scene; of equal ones those that come first.

Views that --views leaves out are rendered before and after: their mean time, PSNR of the frames
after against those before, and PSNR and SSIM against the photographs that have the cameras' names:
those of --photos, or those in 'photos' of a capture at its own size.

Examples:
  swiftgs prune builtin --keep 0.3 --out small.ply
  swiftgs prune garden.spz --keep 0.1 --cameras cameras.json --photos photos --out small.ply
  swiftgs prune garden.spz --keep 0.1 --score opacity-volume --out small.ply)";

}  // namespace

void add_prune(CLI::App& app) {
  CLI::App* command = app.add_subcommand("prune", "Writes a scene of the Gaussians that matter most");
  command->footer(prune_help);
  const auto options = std::make_shared<PruneOptions>();
  add_scene(*command, options->scene);
  command->add_option("--keep", options->keep, "Part of the Gaussians to keep, above 0 and at most 1")
      ->required();
  command->add_option("--score", options->score, "Score that decides which: contribution or opacity-volume")
      ->capture_default_str();
  command->add_option("--out", options->out, "The .ply file to write")->required();
  add_views(*command, options->view, training_views);
  command->get_option("--views")->default_str(training_views);
  command->add_option(
      "--photos", options->photos,
      "Folder with photographs of the views that are left out\n[photos in SCENE where it is a "
      "folder, without --cameras]");
  command->add_option("--backend", options->backend,
                      "cuda, cpu, vulkan or serial [the first that runs here]");
  add_json(*command, options->json);
  command->callback([options] { prune(*options); });
}

}  // namespace swiftgs::cli
