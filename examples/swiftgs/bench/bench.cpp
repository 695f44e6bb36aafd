// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/io/scene_file.hpp>

#include "bench/profile.hpp"
#include "bench/results.hpp"
#include "bench/runner.hpp"
#include "bench/table.hpp"
#include "bench/threads.hpp"
#include "bench/variants.hpp"
#include "commands.hpp"
#include "draw/choice.hpp"
#include "interruptible.hpp"
#include "measure/photos.hpp"
#include "read/distinct_files.hpp"
#include "read/scene_input.hpp"

namespace swiftgs::cli {
namespace {

/// Tells scenes apart, whatever their models.
std::string checksum_of(const Scene& scene) {
  std::size_t checksum = 0;
  const auto add = [&](const auto& array) {
    const auto* const bytes = reinterpret_cast<const char*>(array.data());
    checksum = checksum * 31 + std::hash<std::string_view>()({bytes, array.size() * sizeof(array[0])});
  };
  add(scene.means), add(scene.scales), add(scene.rotations), add(scene.opacities);
  return std::to_string(checksum);
}

struct BenchOptions {
  std::vector<std::string> scenes;
  std::string renderers = "*";
  std::string views = "every:8";
  std::string scales = "1", gaussians, enlarge = "1", threads, conventions = "gsplat";
  std::string errors = "all";
  std::string json;
  Plan plan;
  int batch = 1;
  std::string planes, harmonics = "smallest", model;
  bool profile = false, resume = false;
};

constexpr const char* bench_help =
    R"(SCENE is builtin, builtin:N, a file of Gaussians, or the folder of a capture: one such file with
cameras beside it, and photographs in photos. Lists are separated by commas; every combination is
measured. Frames are not copied from the GPU. Renderers alternate in a random order. Each is timed
until its median is as certain as --precision asks, or until --max-frames are drawn.
--gaussians splits or thins a scene, --enlarge multiplies the scales of its Gaussians.
With --batch N a frame has N views, the one that a row is of and those after it, and the row's
times are those of the frame divided by N.
--errors is all, none, or how many views of each scene are compared with float64.
The columns are means over views; docs/results.md describes the JSON.
The file of --json is written anew after every row. --resume goes on where a run of the same command
on the same machine, build and scenes has stopped; a file of another one is refused.
With --profile nothing is timed or compared: after frames that warm up, each renderer draws each
view once, and a profiler of CUDA records these frames alone; vulkan prints the time of each kernel.

Examples:
  swiftgs bench builtin garden/ --renderers 'cuda/*' --json results.json
  swiftgs bench garden/ --renderers 'cpu/early/*/ellipse' --views 0,8 --scales 0.5,1,2
  swiftgs bench builtin --gaussians 100000,1000000 --threads 1,2,4 --errors none
  ncu --profile-from-start off swiftgs bench garden/ --profile --views 0 --renderers 'cuda/early/*'
  nsys profile --capture-range=cudaProfilerApi --capture-range-end=repeat
       swiftgs bench garden/ --profile --renderers 'cuda/*/per-pixel/ellipse')";

std::size_t judged_views(const std::string& errors) {
  if (errors == "all") return std::numeric_limits<std::size_t>::max();
  if (errors == "none") return 0;
  const std::vector<std::size_t> count = counts_of("--errors", errors);
  if (count.size() != 1)
    throw std::invalid_argument("--errors '" + errors + "': expected all, none or a number of views");
  return count.front();
}

/// What is not asked for is one case: what the scene or the machine has.
std::vector<std::optional<std::size_t>> counts_or_one_case(const std::string& option,
                                                           const std::string& list) {
  if (list.empty()) return {std::nullopt};
  const std::vector<std::size_t> counts = counts_of(option, list);
  return {counts.begin(), counts.end()};
}

/// A scene with what lies beside it.
struct Input {
  Input(const std::string& name, const std::string& model) : capture(capture_of({.scene = name})) {
    scene.scene = name, scene.model = model;
    // A folder brings its own.
    if (!capture.cameras.empty() && !std::filesystem::is_directory(name))
      cameras_file = capture.cameras.string();
    cameras = read_cameras_of(scene, cameras_file, notes);
  }

  SceneOptions scene;
  Capture capture;
  std::string cameras_file;
  std::vector<std::string> notes;  ///< of the cameras
  Cameras cameras;
};

/// Every combination of what the options list, scene by scene.
class Matrix {
 public:
  explicit Matrix(const BenchOptions& options)
      : options_(options),
        scales_(numbers_of("--scales", options.scales)),
        enlarge_(numbers_of("--enlarge", options.enlarge)),
        gaussians_(counts_or_one_case("--gaussians", options.gaussians)),
        threads_(counts_or_one_case("--threads", options.threads)),
        conventions_(list_of("--conventions", options.conventions)),
        harmonics_(harmonics_of(options.harmonics)) {
    check_values();
    // In results a scene goes by its name and its number of Gaussians.
    std::set<std::pair<std::string, std::size_t>> names;
    for (const std::string& scene : options.scenes) {
      inputs_.emplace_back(scene, options.model);
      const std::size_t built_in = options.gaussians.empty() ? builtin_size(scene).value_or(0) : 0;
      if (!names.emplace(name_of(inputs_.back()), built_in).second)
        throw std::invalid_argument("SCENE '" + scene +
                                    "': expected another name than that of a scene before it");
    }
  }

  const std::vector<Input>& inputs() const { return inputs_; }

  /// How many there are, for the progress. Throws for views that there are not.
  std::size_t images() const {
    std::size_t count = 0;
    for (const Input& input : inputs_) count += views_of(input.cameras, view_options(input), "").size();
    return count * scales_.size() * enlarge_.size() * gaussians_.size() * threads_.size() *
           conventions_.size();
  }

  template <class Run>
  void for_each_session(Results& results, Progress& progress, const Run& run) const {
    for (const Input& input : inputs_) {
      progress.clear();
      std::vector<std::string>& notes = results.head.notes;
      notes.insert(notes.end(), input.notes.begin(), input.notes.end());
      const DrawnScene drawn = load_to_draw(input.scene, notes);
      const Scene& original = *drawn.gaussians;
      for (const std::optional<std::size_t> count : gaussians_)
        for (const double factor : enlarge_) {
          Session session;
          session.harmonics = harmonics_;
          session.gaussians = variant(drawn.gaussians, count, factor);
          session.scene = {name_of(input),
                           session.gaussians->size(),
                           original.size(),
                           factor,
                           original.sh_degree,
                           text_of(original.model),
                           options_.json.empty() ? "" : checksum_of(*session.gaussians)};
          if (options_.resume) require_same_scene(options_.json, results, session.scene);
          std::vector<SceneResult>& scenes = results.scenes;
          if (std::find(scenes.begin(), scenes.end(), session.scene) == scenes.end())
            scenes.push_back(session.scene);
          for_each_view_set(input, drawn.camera, session, [&] {
            progress.clear();
            const bool photographed = !options_.profile && session.scale == 1;
            session.photos = photographs_of(session.views, input.cameras,
                                            photographed ? input.capture.photos.string() : "", session.scale,
                                            session.settings.background, notes);
            run(session);
          });
        }
    }
  }

 private:
  /// Throws before anything is measured what would be thrown later.
  void check_values() const {
    for (const double scale : scales_)
      if (!(scale > 0) || !std::isfinite(scale))
        throw std::invalid_argument("--scales '" + options_.scales + "': expected finite factors above 0");
    for (const double factor : enlarge_) require_factor(factor);
    for (const std::optional<std::size_t> count : gaussians_)
      if (count) require_count(*count);
    for (const std::optional<std::size_t> threads : threads_) ThreadLimit limit(threads);
    for (const std::string& name : conventions_) conventions_named(name);
    ViewOptions named;
    named.planes = options_.planes;
    settings_of(named);
  }

  static std::string name_of(const Input& input) {
    return builtin_size(input.scene.scene) ? "builtin" : input.capture.name;
  }

  ViewOptions view_options(const Input& input) const {
    ViewOptions view;
    view.cameras = input.cameras_file;
    view.views = options_.views;
    return view;
  }

  /// The scene itself where nothing changes: one from a file lies in large pages, and a copy does not.
  std::shared_ptr<const Scene> variant(const std::shared_ptr<const Scene>& original,
                                       std::optional<std::size_t> count, double factor) const {
    if (count == original->size()) count.reset();
    if (!count && factor == 1) return original;
    Scene scene = count ? with_count(*original, *count, options_.plan.seed) : *original;
    return std::make_shared<const Scene>(factor == 1 ? std::move(scene) : enlarged(std::move(scene), factor));
  }

  template <class Run>
  void for_each_view_set(const Input& input, const std::optional<Camera>& camera, Session& session,
                         const Run& run) const {
    for (const std::optional<std::size_t> threads : threads_) {
      const ThreadLimit limit(threads);
      session.threads = limit.threads();
      for (const std::string& conventions : conventions_)
        for (const double scale : scales_) {
          ViewOptions view = view_options(input);
          view.scale = scale, view.conventions = conventions, view.planes = options_.planes;
          session.views = views_of(input.cameras, view, "");
          place_views(session.views, *session.gaussians, camera);
          session.settings = settings_of(view);
          session.scale = scale, session.conventions = conventions;
          run();
        }
    }
  }

  const BenchOptions& options_;
  std::vector<double> scales_, enlarge_;
  std::vector<std::optional<std::size_t>> gaussians_, threads_;
  std::vector<std::string> conventions_;
  HarmonicsKept harmonics_;
  std::vector<Input> inputs_;
};

/// Throws if an option was given that says how to measure.
void require_nothing_measured(const CLI::App& command) {
  for (const char* option :
       {"--errors", "--precision", "--min-frames", "--max-frames", "--batch", "--json", "--resume"})
    if (command.count(option) > 0)
      throw std::invalid_argument(std::string(option) +
                                  ": expected no --profile with it, which measures nothing");
}

/// The results to add to: none yet, or those that an earlier run left in the file of `--json`.
Results first_results(const BenchOptions& options) {
  ResultHead head = head_of("swiftgs-bench");
  if (!options.resume) return {.head = std::move(head), .scenes = {}, .views = {}, .rows = {}};
  if (options.json.empty() || options.json == "-")
    throw std::invalid_argument("--resume: expected --json FILE too, with the rows to go on from");
  if (Team::here().is_shared())
    throw std::invalid_argument("--resume: expected one process, found " +
                                std::to_string(Team::here().size()));
  head.command = command_line("--resume");  // that of the run which is resumed
  return resumed_results(options.json, head);
}

/// What Ctrl-C has left, and how to go on.
std::string rest_of(const BenchOptions& options, const Results& results, std::size_t all) {
  const std::string rows =
      "after " + std::to_string(results.rows.size()) + " of " + std::to_string(all) + " rows";
  if (options.json.empty() || options.json == "-") return "bench: cancelled " + rows;
  return options.json + ": cancelled " + rows + "; the same command with --resume measures the others";
}

void measure_matrix(const BenchOptions& options, const std::vector<RendererEntry>& entries,
                    const Matrix& matrix, Results& results, Progress& progress) {
  ResultFile json(options.json);
  const auto end = [&] {
    progress.clear();
    print_tables(results.rows);
    std::fflush(stdout);
    json.finish();
  };
  Runner runner(entries,
                {options.plan, judged_views(options.errors), std::size_t(options.batch), options.planes},
                results, json, progress);
  try {
    const Interruptible interruptible;
    matrix.for_each_session(results, progress, [&](const Session& session) { runner.run(session); });
  } catch (const Interrupted&) {
    end();
    throw Interrupted(rest_of(options, results, matrix.images() * entries.size()));
  }
  runner.join();
  end();
}

void bench(const BenchOptions& options) {
  validate(options.plan);
  require_batch(options.batch);
  const std::vector<RendererEntry> entries = renderers_matching(options.renderers);
  const Matrix matrix(options);
  std::vector<NamedFile> scenes;
  for (const Input& input : matrix.inputs()) scenes.push_back({"SCENE", input.capture.scene.string()});
  require_distinct({{"--json", options.json}}, scenes);
  Results results = first_results(options);

  Progress progress(matrix.images() * entries.size());
  if (options.profile && Team::here().is_shared())
    throw std::invalid_argument("--profile: expected one process, found " +
                                std::to_string(Team::here().size()));
  if (options.profile)
    return matrix.for_each_session(results, progress,
                                   [&](const Session& session) { profile(entries, session, progress); });
  progress.advance_to(results.rows.size());
  progress.begin_part(matrix.images() * entries.size());
  measure_matrix(options, entries, matrix, results, progress);
}

}  // namespace

void add_bench(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("bench", "Run time against error, of any renderers, scenes and sizes");
  command->footer(bench_help);
  const auto options = std::make_shared<BenchOptions>();
  command->add_option("SCENE", options->scenes, "Scenes: builtin, builtin:N, files or folders")->required();
  command->add_option("--renderers", options->renderers, "Names with * for any text, separated by commas")
      ->capture_default_str();
  add_view_choice(*command, "--views", options->views, "Views")->capture_default_str();
  command->add_option("--scales", options->scales, "Factors of the images' sides")->capture_default_str();
  command->add_option("--gaussians", options->gaussians, "Numbers of Gaussians [as in the file]");
  command->add_option("--enlarge", options->enlarge, "Factors of the Gaussians' scales")
      ->capture_default_str();
  add_model(*command, options->model);
  command->add_option("--threads", options->threads, "Numbers of threads of the cpu backend [all]");
  command->add_option("--conventions", options->conventions, "gsplat, inria and khronos, with commas between")
      ->capture_default_str();
  command
      ->add_option("--errors", options->errors, "Views that are compared with float64: all, none or how many")
      ->capture_default_str();
  command
      ->add_option("--precision", options->plan.precision,
                   "Uncertainty of the median at which timing stops: 0.01 is 1 %")
      ->capture_default_str();
  command->add_option("--min-frames", options->plan.min_frames, "Fewest frames to time")
      ->capture_default_str();
  command->add_option("--max-frames", options->plan.max_frames, "Most frames to time")->capture_default_str();
  add_batch(*command, options->batch);
  add_planes(*command, options->planes);
  add_harmonics(*command, options->harmonics);
  command->add_option("--seed", options->plan.seed, "Seed of the renderers' order and of thinned scenes")
      ->capture_default_str();
  add_json(*command, options->json);
  command->add_flag("--resume", options->resume,
                    "Keep the rows in the file of --json, and measure the others");
  command->add_flag("--profile", options->profile, "Only draw the views, for a profiler to record");
  command->callback([options, command] {
    if (options->profile) require_nothing_measured(*command);
    bench(*options);
  });
}

}  // namespace swiftgs::cli
