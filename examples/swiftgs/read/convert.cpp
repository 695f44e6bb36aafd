// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include <swiftgs/edit/all.hpp>
#include <swiftgs/edit/pruning.hpp>
#include <swiftgs/io/replace_file.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "commands.hpp"
#include "interruptible.hpp"
#include "notes.hpp"
#include "options.hpp"
#include "read/convert_result.hpp"
#include "read/distinct_files.hpp"
#include "read/scene_edits.hpp"
#include "read/scene_input.hpp"
#include "result_file.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

struct ConvertOptions {
  std::vector<std::string> files;  ///< the last is written
  SceneOptions scene;              ///< how to read each
  std::vector<std::string> transforms, crops;
  int degree = max_sh_degree;
  double keep = 1;
  bool order = false;
  std::string format, json;
  int spz_version = 4;
  std::string spz_write_frame = "specified";
};

/// The edits that the options ask for, checked before anything is read.
struct Edits {
  std::vector<std::pair<std::string, Affine>> transforms;
  std::vector<std::pair<std::string, Region>> crops;
};

/// A bar that moves by a hundred for each file, tells the time left of each, and is stopped by Ctrl-C.
class ConvertProgress {
 public:
  ConvertProgress(std::size_t files, std::string out) : bar_(100 * files), out_(std::move(out)) {}

  swiftgs::Progress of_next_file(const std::string& what) {
    const std::size_t first = 100 * files_++;
    bar_.advance_to(first);
    bar_.begin_part(first + 100);
    begin(what);
    return [this, what, first](double part) {
      bar_.advance_to(first + std::size_t(100 * part));
      bar_.start(what);
      return !Interruptible::interrupted();
    };
  }
  /// Shows that `what` begins. Throws `Cancelled` after Ctrl-C.
  void begin(const std::string& what) {
    if (Interruptible::interrupted()) throw Cancelled(out_);
    bar_.start(what);
  }
  void clear() { bar_.clear(); }

 private:
  const Interruptible interruptible_{};
  Progress bar_;
  std::string out_;
  std::size_t files_ = 0;
};

/// Whether what is written to `path` goes where text would be printed.
bool is_standard_output(const std::string& path) {
  struct stat file {
  }, output{};
  return stat(path.c_str(), &file) == 0 && fstat(STDOUT_FILENO, &output) == 0 &&
         file.st_dev == output.st_dev && file.st_ino == output.st_ino;
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Edits edits_of(const ConvertOptions& options) {
  if (options.degree < 0 || options.degree > max_sh_degree)
    throw std::invalid_argument("--degree " + std::to_string(options.degree) + ": expected 0 to 3");
  require_keep(options.keep);
  if (options.spz_version != 3 && options.spz_version != 4)
    throw std::invalid_argument("--spz-version " + std::to_string(options.spz_version) + ": expected 3 or 4");
  Edits edits;
  for (const std::string& text : options.transforms)
    edits.transforms.emplace_back("--transform " + text, movement_named(text));
  for (const std::string& text : options.crops)
    edits.crops.emplace_back("--crop " + text, region_named(text));
  return edits;
}

/// What one input holds, and the row for it.
SceneFile read(const ConvertOptions& options, const std::string& name, ConvertProgress& progress,
               ConvertResult& result) {
  SceneOptions from = options.scene;
  from.scene = name;
  const auto begin = std::chrono::steady_clock::now();
  SceneFile file = load(from, progress.of_next_file("read " + name));
  ConvertedFile row{.name = name,
                    .format = file.format,
                    .bytes = file.bytes,
                    .stored = file.stored,
                    .gaussians = file.scene.size(),
                    .sh_degree = file.scene.sh_degree,
                    .model = text_of(file.scene.model),
                    .seconds = seconds_since(begin)};
  progress.clear();
  say_notes(name, file.notes, result.head.notes);
  result.inputs.push_back(std::move(row));
  return file;
}

/// Inputs. Neighbours with the same origin are joined at once, the others when all have moved: joining
/// rounds.
using Inputs = std::vector<Scene>;

/// Lowers the degree and moves the inputs.
void move_inputs(Inputs& inputs, const ConvertOptions& options, const Edits& edits, ConvertProgress& progress,
                 ConvertResult& result) {
  const auto degree = [&] {
    return std::max_element(inputs.begin(), inputs.end(),
                            [](const Scene& a, const Scene& b) { return a.sh_degree < b.sh_degree; })
        ->sh_degree;
  };
  const auto step = [&](const std::string& what, const auto& change) {
    progress.begin(what);
    std::size_t gaussians = 0;
    for (Scene& scene : inputs) change(scene), gaussians += scene.size();
    result.steps.push_back({what, gaussians, degree()});
  };
  if (options.degree < degree())
    step("--degree " + std::to_string(options.degree), [&](Scene& scene) {
      if (options.degree < scene.sh_degree) scene = with_degree(std::move(scene), options.degree);
    });
  for (const auto& entry : edits.transforms)
    step(entry.first, [&, &by = entry.second](Scene& scene) { stretch(scene, by, origin_for(scene, by)); });
}

/// Inputs as one scene, with the origin of the first.
Scene joined(Inputs inputs) {
  Scene scene = std::move(inputs.front());
  for (Scene& more : std::span(inputs).subspan(1)) append(scene, std::exchange(more, {}));
  return scene;
}

void edit(Scene& scene, const ConvertOptions& options, const Edits& edits, ConvertProgress& progress,
          ConvertResult& result) {
  const auto step = [&](const std::string& what, const auto& make) {
    progress.begin(what);
    make();
    result.steps.push_back({what, scene.size(), scene.sh_degree});
  };
  for (const auto& entry : edits.crops)
    step(entry.first, [&, &region = entry.second] {
      scene = std::visit([&](const auto& r) { return crop(scene, r); }, region);
    });
  if (options.keep < 1)
    step("--keep " + text_of_number(options.keep), [&] {
      scene = subset(scene, highest(opacity_volumes(scene), kept_count(options.keep, scene.size())));
    });
  if (options.order) step("--order", [&] { scene = order_spatially(scene); });
}

Inputs read_all(const ConvertOptions& options, const std::vector<std::string>& inputs,
                ConvertProgress& progress, ConvertResult& result) {
  Inputs all;
  for (const std::string& name : inputs) {
    SceneFile file = read(options, name, progress, result);
    Scene& scene = file.scene;
    if (all.empty()) {
      all.push_back(std::move(scene));
      continue;
    }
    Scene& last = all.back();
    if (scene.size() != 0 && last.size() != 0 && scene.model != last.model) {
      const auto words = [](const RenderingModel& model) {
        const std::string text = text_of(model);
        return text.empty() ? std::string("the usual one") : text;
      };
      throw std::invalid_argument(name + ": expected the rendering model of " + inputs.front() + ", " +
                                  words(last.model) + ", found " + words(scene.model) +
                                  "; --model says one for all");
    }
    if (scene.size() == 0 || last.size() == 0 || scene.origin == last.origin)
      append(last, scene);
    else
      all.push_back(std::move(scene));
  }
  return all;
}

/// How to write `out`.
SceneWriteOptions write_options_of(const ConvertOptions& options, const std::string& out) {
  const std::string ending = options.format.empty() ? "" : "." + options.format;
  SceneWriteOptions write{.ending = ending,
                          .spz_version = options.spz_version,
                          .spz_frame = spz_frame_named(options.spz_write_frame, "--spz-write-frame")};
  if (out == "-") throw std::invalid_argument("-: expected a file to write, such as /dev/stdout");
  require_scene_ending(out, write);
  return write;
}

void convert(const ConvertOptions& options) {
  if (options.files.size() < 2)
    throw std::invalid_argument("convert: expected one or more scenes to read and a file to write, found " +
                                (options.files.empty() ? "nothing" : options.files[0] + " alone"));
  const Edits edits = edits_of(options);
  const std::vector<std::string> inputs(options.files.begin(), options.files.end() - 1);
  const std::string& out = options.files.back();
  std::vector<NamedFile> read_files;
  for (const std::string& name : inputs) {
    SceneOptions from = options.scene;
    from.scene = name;
    read_files.push_back({"FILE", capture_of(from).scene.string()});
  }
  require_distinct({{"FILE", out}, {"--json", options.json}}, read_files);
  SceneWriteOptions write = write_options_of(options, out);
  require_replaceable(out);
  const bool to_standard_output = is_standard_output(out);
  ResultFile json(options.json);

  ConvertResult result;
  if (json.is_wanted()) result.head = head_of("swiftgs-convert");
  ConvertProgress progress(options.files.size(), out);
  Inputs all = read_all(options, inputs, progress, result);
  move_inputs(all, options, edits, progress, result);
  Scene scene = joined(std::move(all));
  edit(scene, options, edits, progress, result);

  const auto begin = std::chrono::steady_clock::now();
  write.progress = progress.of_next_file("write " + out);
  WrittenScene written = write_scene(out, scene, write);
  progress.clear();
  result.output = {.name = out,
                   .format = std::move(written.format),
                   .bytes = written.bytes,
                   .stored = scene.size(),
                   .gaussians = written.gaussians - written.added,
                   .sh_degree = written.sh_degree,
                   .model = text_of(written.model),
                   .seconds = seconds_since(begin)};
  result.losses = written.losses;
  say_notes(out, written.notes, result.head.notes);
  if (!json.is_standard_output() && !to_standard_output) print_table(result);
  if (json.is_wanted()) json.write(to_json(result));
  json.finish();
}

constexpr const char* convert_help =
    R"(Several scenes become one. Then, in this order: --degree, --transform, --crop, --keep and --order.
--transform and --crop may be given several times and act one after another.
Prints what was read, left out and written.

--transform scale:S, scale:X,Y,Z along the axes, move:X,Y,Z, rotate:X,Y,Z,DEGREES about an axis through the
            origin, or matrix: and three rows of four numbers, which neither mirror nor flatten
--crop      box:X,Y,Z,X,Y,Z (lower and upper corner), sphere:X,Y,Z,RADIUS, or half-space:X,Y,Z,OFFSET
            (positions whose product with X,Y,Z is OFFSET or more)

Examples:
  swiftgs convert garden.spz garden.ply
  swiftgs convert lod-meta.json --level 1 --degree 1 --order small.sog
  swiftgs convert room.ply chair.splat both.spz --crop sphere:0,0,0,5
  swiftgs convert fox.ply upright.ply --transform rotate:1,0,0,-90 --transform scale:0.5)";

}  // namespace

void add_convert(CLI::App& app) {
  CLI::App* command = app.add_subcommand("convert", "Writes scenes in another format, joined and edited");
  command->footer("Reads " + readable_scenes() +
                  ".\nThe ending of OUT says what is written: " + writable_scenes() + ".\n" + convert_help);
  const auto options = std::make_shared<ConvertOptions>();
  command->add_option("FILE", options->files, "Scenes to read, and last the file to write")->required();
  add_scene_reading(*command, options->scene);
  command->add_option("--format", options->format, "Ending that says what is written [that of OUT]");
  command->add_option("--spz-version", options->spz_version, "Version of an .spz file to write: 3 or 4")
      ->capture_default_str();
  command
      ->add_option("--spz-write-frame", options->spz_write_frame,
                   "Axes of an .spz file to write: specified (RUB), rub, rdf, luf, or raw (a PLY's, which\n"
                   "programs expect that take its numbers unchanged)")
      ->capture_default_str();
  command->add_option("--degree", options->degree, "Highest degree of harmonics to keep")
      ->capture_default_str();
  command->add_option("--transform", options->transforms, "Moves the scene")->allow_extra_args(false);
  command->add_option("--crop", options->crops, "Region whose Gaussians are kept")->allow_extra_args(false);
  command
      ->add_option("--keep", options->keep,
                   "Part of the Gaussians to keep, those of most opacity times volume")
      ->capture_default_str();
  command->add_flag("--order", options->order, "Put neighbours in space next to each other");
  add_json(*command, options->json);
  command->callback([options] { convert(*options); });
}

}  // namespace swiftgs::cli
