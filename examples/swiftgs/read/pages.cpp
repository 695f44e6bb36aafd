// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/pages/build_pages.hpp>

#include "commands.hpp"
#include "interruptible.hpp"
#include "notes.hpp"
#include "options.hpp"
#include "read/distinct_files.hpp"
#include "read/scene_input.hpp"

namespace swiftgs::cli {
namespace {

struct PagesOptions {
  std::vector<std::string> files;  ///< the last is written
  SceneOptions scene;              ///< how to read each
  std::uint32_t page = PageBuildOptions().page_size;
  std::size_t megabytes = PageBuildOptions().memory >> 20;
  bool order = false;
};

void write_pages(const PagesOptions& options) {
  if (options.files.size() < 2)
    throw std::invalid_argument("pages: expected one or more scenes to read and a file to write, found " +
                                (options.files.empty() ? "nothing" : options.files[0] + " alone"));
  const std::string& out = options.files.back();
  std::vector<std::filesystem::path> sources;
  std::vector<NamedFile> read;
  for (std::size_t i = 0; i + 1 < options.files.size(); ++i) {
    SceneOptions from = options.scene;
    from.scene = options.files[i];
    if (builtin_size(from.scene) && options.files.size() > 2)
      throw std::invalid_argument(from.scene + ": expected files, where several scenes are joined");
    sources.emplace_back(capture_of(from).scene);
    read.push_back({"FILE", sources.back().string()});
  }
  require_distinct({{"FILE", out}}, read);

  const Interruptible interruptible;
  Progress bar(100);
  PageBuildOptions build{.page_size = options.page,
                         .order = options.order,
                         .memory = options.megabytes << 20,
                         .model = options.scene.model};
  build.read.spz_frame = spz_frame_named(options.scene.spz_frame, "--spz-frame");
  build.read.level = options.scene.level;
  build.progress = [&](double part) {
    bar.advance_to(std::size_t(100 * part));
    bar.start("pages of " + out);
    return !Interruptible::interrupted();
  };
  const auto begin = std::chrono::steady_clock::now();
  const auto builtin = builtin_size(options.files[0]);
  SceneOptions first = options.scene;
  first.scene = options.files[0];
  const BuiltPages built =
      builtin ? build_pages(load(first).scene, out, build) : build_pages(sources, out, build);
  bar.clear();
  std::vector<std::string> said;
  say_notes(out, built.notes, said);
  if (built.resumed != 0)
    std::printf("%s: resumed after %zu pages of an unfinished build\n", out.c_str(), built.resumed);
  std::printf("%s: %zu Gaussians in %zu pages, and %zu above them, %.1f MB, %.1f s\n", out.c_str(),
              std::size_t(built.gaussians), built.leaves, built.pages - built.leaves,
              1e-6 * double(built.bytes),
              std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
}

constexpr const char* pages_help =
    R"(A page file is drawn within a budget of memory: near pages as they are, far ones by coarser pages that
stand for them. Pages are ranges of the scene, so its neighbours in the file should be neighbours in
space. --order makes them so; the order of Gaussians at equal depths then is another.

Beside OUT it takes 240 bytes a Gaussian, twice that with --order. A build that ends early leaves
OUT.unfinished and OUT.unfinished.steps: the same command resumes with them, deleting both gives up.

Examples:
  swiftgs pages garden.spz garden.sgp --order
  swiftgs pages north.ply south.ply city.sgp --order --memory 4096)";

}  // namespace

void add_pages(CLI::App& app) {
  CLI::App* command = app.add_subcommand("pages", "Writes a page file of scenes larger than the memory");
  command->footer("Reads " + readable_scenes() + ".\n" + pages_help);
  const auto options = std::make_shared<PagesOptions>();
  command->add_option("FILE", options->files, "Scenes to read, and last the file to write")->required();
  add_scene_reading(*command, options->scene);
  command->add_option("--page", options->page, "Gaussians of a page, a multiple of 128")
      ->capture_default_str();
  command->add_flag("--order", options->order, "Put neighbours in space next to each other");
  command->add_option("--memory", options->megabytes, "Most memory to use, in MiB")->capture_default_str();
  command->callback([options] { write_pages(*options); });
}

}  // namespace swiftgs::cli
