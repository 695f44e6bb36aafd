// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/stress.hpp>

#include "commands.hpp"
#include "draw/npy.hpp"
#include "draw/reference_frame.hpp"
#include "json.hpp"
#include "measure/conformance_set.hpp"
#include "notes.hpp"
#include "options.hpp"
#include "result_file.hpp"

namespace swiftgs::cli {
namespace {

namespace fs = std::filesystem;

struct ConformOptions {
  std::string folder;    ///< of canvases, or empty
  std::string renderer;  ///< that draws the set in place of canvases, or empty
  std::string set = "tests/conformance/set";
  std::string preset = "gsplat";
  std::string json;  ///< file to write, or empty
  bool straight = false, blends_in_bytes = false;
};

/// What a renderer drew of a clause.
struct Canvas {
  std::size_t channels = 4;  ///< 3 or 4
  std::vector<double> values;
  double epsilon = 0;  ///< of its floats; 0 of bytes
};

/// Largest error of float arithmetic that is no departure from the conventions.
constexpr double float_tolerance = 2e-6;
/// Conventions that are named together, and what each must be worth. @units{dB}
constexpr std::size_t most_changes = 3;
constexpr double least_gain = 3;

Canvas canvas_of(const Image& image, double epsilon) {
  return {std::size_t(image.channels), {image.pixels.begin(), image.pixels.end()}, epsilon};
}

Canvas raw_canvas(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  Canvas canvas;
  for (auto byte = std::istreambuf_iterator<char>(in); byte != std::istreambuf_iterator<char>(); ++byte)
    canvas.values.push_back(double(static_cast<unsigned char>(*byte)) / 255);
  return canvas;
}

Canvas array_canvas(const fs::path& file) {
  Array array = read_npy(file);
  return {array.shape.size() == 3 ? array.shape[2] : 0, std::move(array.values), array.epsilon};
}

/// The canvas of `clause` in a folder; nothing where there is no file.
std::optional<Canvas> read_canvas(const ConformOptions& options, const ConformanceSet& set,
                                  const Clause& clause) {
  const auto file_of = [&](const char* ending) { return fs::path(options.folder) / (clause.name + ending); };
  constexpr double epsilon = std::numeric_limits<float>::epsilon();
  Canvas canvas;
  fs::path file;
  if (fs::exists(file = file_of(".npy")))
    canvas = array_canvas(file);
  else if (fs::exists(file = file_of(".exr")))
    canvas = canvas_of(read_image(file), epsilon);
  else if (fs::exists(file = file_of(".png")))
    canvas = canvas_of(read_image(file), 0);
  else if (fs::exists(file = file_of(".rgba")))
    canvas = raw_canvas(file);
  else
    return std::nullopt;
  const std::size_t pixels = std::size_t(set.side) * std::size_t(set.side);
  if ((canvas.channels != 3 && canvas.channels != 4) || canvas.values.size() != canvas.channels * pixels)
    throw std::invalid_argument(file.string() + ": expected " + std::to_string(set.side) + "x" +
                                std::to_string(set.side) + " pixels of 3 or 4 channels");
  for (std::size_t i = 0; options.straight && canvas.channels == 4 && i < pixels; ++i)
    for (std::size_t c = 0; c < 3; ++c) canvas.values[4 * i + c] *= canvas.values[4 * i + 3];
  return canvas;
}

Canvas draw_canvas(AnyRenderer& renderer, const std::shared_ptr<const Scene>& scene, const Camera& camera,
                   const Conventions& conventions, const Clause& clause) {
  RenderSettings settings;
  settings.conventions = conventions, settings.background = clause.background;
  settings.outputs.alpha = true;
  renderer.set_scene(scene);
  Frame frame;
  renderer.render(camera, settings, frame);
  return {.values = rgba_of(frame), .epsilon = std::numeric_limits<float>::epsilon()};
}

/// What of a canvas is not right.
struct Wrong {
  double pixels = 0;  ///< part of them
  bool colour = false, alpha = false;
};

/// A canvas beside images that it may be of.
struct Comparison {
  const Canvas& canvas;
  std::vector<double> ambiguity;  ///< of each pixel
  double half_steps;              ///< of bytes
  bool opaque;                    ///< alpha is 1 everywhere, and says nothing

  /// f(pixel, channel, value, expected) of all values that count.
  template <class F>
  void for_each(const std::vector<double>& rgba, const F& f) const {
    const std::size_t channels = opaque ? 3 : canvas.channels;
    for (std::size_t i = 0; i < ambiguity.size(); ++i)
      for (std::size_t c = 0; c < channels; ++c) {
        const double expected = rgba[4 * i + c];
        f(i, c, canvas.values[canvas.channels * i + c],
          canvas.epsilon > 0 ? expected : std::clamp(expected, 0.0, 1.0));
      }
  }
  Wrong wrong(const std::vector<double>& rgba) const {
    Wrong wrong;
    std::vector<bool> is_wrong(ambiguity.size());
    for_each(rgba, [&](std::size_t i, std::size_t c, double value, double expected) {
      const double rounding = canvas.epsilon > 0 ? canvas.epsilon * std::abs(expected) : half_steps / 510;
      if (std::abs(value - expected) <= float_tolerance + rounding + ambiguity[i]) return;
      is_wrong[i] = true;
      (c < 3 ? wrong.colour : wrong.alpha) = true;
    });
    wrong.pixels = double(std::count(is_wrong.begin(), is_wrong.end(), true)) / double(is_wrong.size());
    return wrong;
  }
  /// PSNR of the colours, 200 where they are equal.
  double decibels(const std::vector<double>& rgba) const {
    double sum = 0;
    for_each(rgba, [&](std::size_t, std::size_t c, double value, double expected) {
      if (c < 3) sum += (value - expected) * (value - expected);
    });
    const double mean = sum / double(3 * ambiguity.size());
    return std::isfinite(mean) ? -10 * std::log10(std::max(mean, 1e-20)) : 0;
  }
};

struct ClauseResult {
  std::string clause, verdict = "not drawn";
  double wrong = 1, db = 0;          ///< of what is drawn
  std::vector<std::string> nearest;  ///< changes of the conventions that come nearest
  double nearest_db = 0;
  bool explained = false;  ///< with them every colour is right
};

/// Names the conventions that the canvas, of which `wrong` is not right, is nearest to: changes one after
/// another. What makes every colour right is nearer than any PSNR.
void find_nearest(ClauseResult& result, Wrong wrong, const Comparison& comparison,
                  const std::vector<Variant>& variants, Conventions conventions,
                  const std::function<std::vector<double>(const Conventions&)>& draw) {
  result.nearest_db = result.db;
  while (result.nearest.size() < most_changes && wrong.colour) {
    const Variant* nearest = nullptr;
    std::pair best(false, result.nearest_db + least_gain);
    for (const Variant& variant : variants) {
      Conventions changed = conventions;
      variant.change(changed);
      const std::vector<double> image = draw(changed);
      const Wrong left = comparison.wrong(image);
      const std::pair found(!left.colour, comparison.decibels(image));
      if (found > best) best = found, nearest = &variant, wrong = left;
    }
    if (!nearest) break;
    nearest->change(conventions);
    result.nearest.push_back(nearest->name), result.nearest_db = best.second;
  }
  if (wrong.alpha && !wrong.colour) result.nearest.emplace_back("alpha of the canvas");
  result.explained = !wrong.colour;
}

ClauseResult judge(const ConformOptions& options, const ConformanceSet& set, const Clause& clause,
                   AnyRenderer* renderer) {
  ClauseResult result{.clause = clause.name, .nearest = {}};
  const auto scene = std::make_shared<const Scene>(clause.read_scene());
  const Camera camera = clause.read_camera();
  const Conventions conventions = clause.conventions(options.preset);
  const std::optional<Canvas> canvas = renderer ? draw_canvas(*renderer, scene, camera, conventions, clause)
                                                : read_canvas(options, set, clause);
  if (!canvas) return result;
  const dvec3 background(clause.background);
  const ConditionedFrame expected = render_conditioned(*scene, camera, conventions, background);
  bool opaque = canvas->channels == 4;
  for (std::size_t i = 3; opaque && i < canvas->values.size(); i += 4) opaque = canvas->values[i] == 1;
  const Comparison comparison{*canvas, ambiguity_of(expected),
                              options.blends_in_bytes ? 1.0 + clause.layers : 1.0, opaque};
  const std::vector<double> rgba = rgba_of(expected.frame);
  const Wrong wrong = comparison.wrong(rgba);
  result.wrong = wrong.pixels, result.db = comparison.decibels(rgba);
  result.verdict = result.wrong == 0 ? "right" : "differs";
  if (result.wrong == 0) return result;
  std::vector<Variant> variants = set.variants;
  for (const std::string& preset : clause.presets)
    if (preset != options.preset)
      variants.push_back({"preset " + preset, [&](Conventions& c) { c = clause.conventions(preset); }});
  find_nearest(result, wrong, comparison, variants, conventions, [&](const Conventions& changed) {
    return rgba_of(render_reference(*scene, camera, changed, background));
  });
  return result;
}

void print(const ClauseResult& row) {
  std::printf("%-20s%s", row.clause.c_str(), row.verdict.c_str());
  if (row.verdict != "not drawn")
    std::printf("%*.2f%%%7.1f", int(19 - row.verdict.size()), 100 * row.wrong, row.db);
  if (row.verdict == "differs") {
    std::string names;
    for (const std::string& name : row.nearest) names += (names.empty() ? "" : ", ") + name;
    std::printf("  %s (%.1f dB%s)", names.empty() ? "no convention" : names.c_str(), row.nearest_db,
                row.explained ? ", every pixel" : "");
  }
  std::printf("\n");
  std::fflush(stdout);
}

Json object_of(const ClauseResult& row) {
  Json json{{"clause", row.clause}, {"verdict", row.verdict}};
  if (row.verdict != "not drawn") json.update(Json{{"wrong", row.wrong}, {"db", rounded(row.db)}});
  if (row.verdict == "differs")
    json.update(Json{
        {"nearest", row.nearest}, {"nearest_db", rounded(row.nearest_db)}, {"explained", row.explained}});
  return json;
}

void conform(const ConformOptions& options) {
  if (options.folder.empty() == options.renderer.empty())
    throw std::invalid_argument("conform: expected a folder of canvases, or --renderer");
  if (!options.folder.empty() && !fs::is_directory(options.folder))
    throw std::invalid_argument(options.folder + ": expected a folder of canvases");
  conventions_named(options.preset);
  const ConformanceSet set = read_conformance_set(options.set);
  const std::unique_ptr<AnyRenderer> renderer =
      options.renderer.empty() ? nullptr : make_renderer(options.renderer);
  ResultFile json(options.json);
  std::vector<std::string> rows;
  std::size_t right = 0;
  std::printf("%-20s%-12s%8s%7s  nearest\n", "clause", "verdict", "wrong", "dB");
  for (const Clause& clause : set.clauses) {
    if (std::find(clause.presets.begin(), clause.presets.end(), options.preset) == clause.presets.end())
      continue;
    const ClauseResult result = judge(options, set, clause, renderer.get());
    print(result);
    rows.push_back(text_of(object_of(result)));
    right += result.verdict == "right";
  }
  const std::string sum =
      std::to_string(right) + " of " + std::to_string(rows.size()) + " clauses right by " + options.preset;
  std::printf("%s\n", sum.c_str());
  if (json.is_wanted())
    json.write(document_of(head_of("swiftgs-conform"),
                           {{"preset", text_of(options.preset)}, {"rows", array_of(rows)}}));
  json.finish();
  if (right < rows.size()) throw std::runtime_error("conform: " + sum);
}

constexpr const char* conform_help =
    R"(Judges what a renderer drew of a conformance set. FOLDER has a file for each clause: NAME.npy or
NAME.exr (floats), NAME.png or NAME.rgba (bytes), rows from the top, colours premultiplied over
black, with the clause's background where it has one. --renderer draws the set itself.
A pixel is right if every channel is within half a step of its format, and what decisions on the
edge may change. Of a clause that differs, 'wrong' is the part of its pixels that are not right, and
conventions are changed one after another: those that come nearest are named, with their dB.
Exit code 0: every clause is right.

Examples:
  swiftgs conform canvases --blends-in-bytes
  swiftgs conform --renderer cpu/early/per-pixel/three-sigma-square --preset inria)";

}  // namespace

void add_conform(CLI::App& app) {
  CLI::App* command = app.add_subcommand("conform", "Which conventions a renderer's images follow");
  command->footer(conform_help);
  const auto options = std::make_shared<ConformOptions>();
  command->add_option("FOLDER", options->folder, "Images of the clauses, by their names");
  command->add_option("--renderer", options->renderer, "A name from 'swiftgs list', which draws the set");
  command->add_option("--set", options->set, "Folder of the set, with its manifest.json")
      ->capture_default_str();
  command->add_option("--preset", options->preset, "Conventions to judge by: gsplat, inria or khronos")
      ->capture_default_str();
  command->add_flag("--straight", options->straight,
                    "Colours are not premultiplied by alpha, as in most PNG files");
  command->add_flag("--blends-in-bytes", options->blends_in_bytes,
                    "Allow half a step for each layer, as a canvas of bytes rounds it");
  add_json(*command, options->json);
  command->callback([options] { conform(*options); });
}

}  // namespace swiftgs::cli
