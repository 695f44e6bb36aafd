// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <string>

#include <CLI/CLI.hpp>

#include <swiftgs/version.hpp>

#include "commands.hpp"

namespace swiftgs::cli {
namespace {

constexpr const char* about = "Renders scenes of 3D Gaussians, and measures how exactly and how quickly.";

constexpr const char* start_here = R"(Start here:
  swiftgs render builtin                             an image without any file
  swiftgs info garden.spz                            what a file holds
  swiftgs render garden.spz                          a view that is found for the scene
  swiftgs render garden.spz --cameras cameras.json   the views it was trained with
  swiftgs list                                       what can render
  swiftgs check builtin --renderers 'cpu/early/*'    errors and times, side by side
'swiftgs COMMAND --help' explains each command. An error is one line, with exit code 1.)";

constexpr const char* info_more =
    R"(Prints format, count, SH degree, how many Gaussians were dropped because they are not
finite, and percentiles of positions, opacities and scales.

Example:
  swiftgs info garden.spz)";

constexpr const char* list_more =
    R"(A name is BACKEND/SORT/RASTER/BOUNDS: where it runs, how splats are ordered, how pixels
are blended, which tiles a splat may touch.)";

constexpr const char* render_more =
    R"(Prints where each image is and how long its frame took, memory and files left out.
Without --cameras a view is found for the scene; 'builtin' has a front view, number 0,
and an orbit, 1 to 24. Images are called as the cameras are, or by number.
A scene that was trained with anti-aliasing is rendered with it.

Examples:
  swiftgs render builtin:1000000 --scale 2 --out big
  swiftgs render garden.spz --cameras cameras.json --views 0,8 --stats
  swiftgs render fox.spz --cameras fox/sparse/0 --views every:8 --format exr)";

constexpr const char* compare_more =
    R"(Prints psnr_db, ssim and max_abs. Images are PNG, JPEG, PFM or EXR of the same size; alpha
is left out. Values are those of the files, 0 to 1 in files of integers. psnr_db of equal
images is null, as JSON has no infinity.

Example:
  swiftgs compare a.png b.png)";

constexpr const char* check_more =
    R"(Times are medians of --repeats frames after one that is not counted. PSNR and the largest
difference are against the float64 reference with the same conventions. The table has a row
of means for each renderer, with the worst difference. In JSON, an infinite PSNR is null.
With --photos, frames are also compared with the photographs that have the cameras'
names, and results gain photo_psnr_db.

Examples:
  swiftgs check builtin:20000 --renderers 'serial/early/per-pixel/*'
  swiftgs check garden.spz --cameras cameras.json --photos photos --json results.json)";

void add_scene(CLI::App& command, SceneOptions& options) {
  command.add_option("SCENE", options.scene, "A .ply or .spz file, builtin, or builtin:N for N Gaussians")
      ->required();
  command
      .add_option("--spz-frame", options.spz_frame,
                  "Axes of an .spz file: specified (what the file says), rub, rdf, luf or raw")
      ->capture_default_str();
}

void add_views(CLI::App& command, ViewOptions& options, const std::string& default_views) {
  command.add_option("--cameras", options.cameras, "A cameras.json, or a folder with a COLMAP model");
  command.add_option(
      "--views", options.views,
      "Which: numbers as 0,8, or every:8, or all [" + default_views + " with cameras, else 0]");
  command.add_option("--scale", options.scale, "Factor of the image's sides")->capture_default_str();
  command
      .add_option("--conventions", options.conventions, "gsplat or inria: what the scene was trained with")
      ->capture_default_str();
  command.add_option("--background", options.background, "R,G,B, each 0 to 1")->capture_default_str();
}

/// `text` without line breaks: an error is one line.
std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

int fail(const std::string& what) {
  std::fprintf(stderr, "swiftgs: %s\n", one_line(what).c_str());
  return 1;
}

int run(int argc, char** argv) {
  CLI::App app(about, "swiftgs");
  app.footer(start_here);
  app.set_version_flag("--version", "swiftgs " + std::string(version));
  app.require_subcommand(0, 1);  // that none is there is said below: CLI11 would not name an unknown one

  SceneOptions info_options;
  CLI::App* info_command = app.add_subcommand("info", "What a scene holds");
  info_command->footer(info_more);
  add_scene(*info_command, info_options);

  CLI::App* list_command = app.add_subcommand("list", "Every renderer, and whether it can run here");
  list_command->footer(list_more);

  RenderOptions render_options;
  CLI::App* render_command = app.add_subcommand("render", "Renders views of a scene to image files");
  render_command->footer(render_more);
  add_scene(*render_command, render_options.scene);
  add_views(*render_command, render_options.view, "all");
  render_command->add_option("--renderer", render_options.renderer, "A name from 'swiftgs list'");
  render_command->add_option("--out", render_options.out, "Folder for the images")->capture_default_str();
  render_command->add_option("--format", render_options.format, "png, pfm or exr")->capture_default_str();
  render_command->add_flag("--stats", render_options.stats, "Print what each frame had to do");

  CompareOptions compare_options;
  CLI::App* compare_command = app.add_subcommand("compare", "How two images differ, as JSON");
  compare_command->footer(compare_more);
  compare_command->add_option("A", compare_options.a, "An image")->required();
  compare_command->add_option("B", compare_options.b, "Another of the same size")->required();

  CheckOptions check_options;
  CLI::App* check_command =
      app.add_subcommand("check", "Errors and times of renderers, against a float64 reference");
  check_command->footer(check_more);
  add_scene(*check_command, check_options.scene);
  add_views(*check_command, check_options.view, "every:8");
  check_command->add_option("--renderers", check_options.renderers, "Which: names with * for any text")
      ->capture_default_str();
  check_command->add_option("--photos", check_options.photos, "Folder with photographs of the views");
  check_command->add_option("--json", check_options.json, "File for the results");
  check_command->add_option("--repeats", check_options.repeats, "Frames that are timed")
      ->capture_default_str();

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked_for_help) {
    return app.exit(asked_for_help);
  } catch (const CLI::ParseError& error) {
    return fail(std::string(error.what()) + " (see swiftgs --help)");
  }

  if (app.get_subcommands().empty())
    return fail("expected a command: info, list, render, compare or check (see swiftgs --help)");
  if (info_command->parsed()) info(info_options);
  if (list_command->parsed()) list();
  if (render_command->parsed()) render(render_options);
  if (compare_command->parsed()) compare(compare_options);
  if (check_command->parsed()) check(check_options);
  // A full disk may show only here.
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) return fail("standard output: cannot be written");
  return 0;
}

}  // namespace
}  // namespace swiftgs::cli

int main(int argc, char** argv) {
  try {
    return swiftgs::cli::run(argc, argv);
  } catch (const std::bad_alloc&) {
    return swiftgs::cli::fail("out of memory");
  } catch (const std::filesystem::filesystem_error& error) {
    return swiftgs::cli::fail(error.path1().string() + ": " + error.code().message());
  } catch (const std::exception& error) {
    return swiftgs::cli::fail(error.what());
  }
}
