// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <swiftgs/error.hpp>
#include <swiftgs/io/cameras.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/memory/harmonic_packing.hpp>
#include <swiftgs/pages/paged_scene.hpp>
#include <swiftgs/tools/parallel.hpp>

#include "commands.hpp"
#include "draw/lenses.hpp"
#include "json.hpp"
#include "notes.hpp"
#include "options.hpp"
#include "read/distinct_files.hpp"
#include "read/scene_input.hpp"
#include "result_file.hpp"
#include "result_head.hpp"

namespace swiftgs::cli {
namespace {

constexpr double quantiles[] = {0, 0.01, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 1};

struct InfoOptions {
  SceneOptions scene;
  std::string json;  ///< file for the results, or empty
};

/// What is measured of every Gaussian, sorted.
struct Distribution {
  const char* name;
  const char* member;  ///< in results
  std::vector<float> values;

  double at(double part) const {
    return double(values[std::size_t(part * double(values.size() - 1))]) + 0.0;  // no -0
  }
};

std::vector<Distribution> distributions_of(const Scene& scene) {
  std::vector<Distribution> all;
  const auto add = [&](const char* name, const char* member, auto measure) {
    std::vector<float> values(scene.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = measure(i);
    std::sort(values.begin(), values.end());
    all.push_back({name, member, std::move(values)});
  };
  const auto scale = [&](int rank) {
    return [&scene, rank](std::size_t i) {
      float s[3] = {scene.scales[i].x, scene.scales[i].y, scene.scales[i].z};
      std::sort(s, s + 3);
      return s[rank];
    };
  };
  if (scene.size() == 0) return all;
  add("x", "x", [&](std::size_t i) { return scene.means[i].x; });
  add("y", "y", [&](std::size_t i) { return scene.means[i].y; });
  add("z", "z", [&](std::size_t i) { return scene.means[i].z; });
  add("opacity", "opacity", [&](std::size_t i) { return scene.opacities[i]; });
  add("longest scale", "longest_scale", scale(2));
  add("middle scale", "middle_scale", scale(1));
  add("shortest scale", "shortest_scale", scale(0));
  return all;
}

void print_distributions(const std::vector<Distribution>& distributions) {
  if (distributions.empty()) return;
  std::printf("\n%-15s", "percentiles");
  for (const double part : quantiles) std::printf(" %8.3g%%", 100 * part);
  std::printf("\n");
  for (const Distribution& distribution : distributions) {
    std::printf("%-15s", distribution.name);
    for (const double part : quantiles) std::printf(" %9.4g", distribution.at(part));
    std::printf("\n");
  }
}

/// What other commands take for a scene.
struct Beside {
  std::string cameras, photos;                  ///< empty where there are none
  std::map<std::string, std::size_t> lenses{};  ///< how many cameras have each, as `words_of` says it
};

/// Of the cameras in the folder that the scene is. What cannot be read becomes one of `notes`: other commands
/// may take other cameras.
std::map<std::string, std::size_t> lenses_in(const std::string& folder, std::vector<std::string>& notes) {
  std::map<std::string, std::size_t> found;
  try {
    for (const Camera& camera : read_cameras(folder).cameras) ++found[words_of(camera.lens)];
  } catch (const FormatError& error) {
    notes.emplace_back(error.what());
  }
  return found;
}

/// How a device keeps the scene's harmonics.
struct KeptHarmonics {
  std::string format;
  double bytes = 0;  ///< a Gaussian

  explicit KeptHarmonics(const Scene& scene) {
    const HarmonicPacking packing(HostThreads(), scene, used_sh_degree(scene), HarmonicsKept::smallest);
    format = name_of(packing.rows_at(nullptr, packing.labels().data));
    if (scene.size() != 0) bytes = double(packing.bytes()) / double(scene.size());
  }
};

std::string count_text(const std::map<std::string, std::size_t>& lenses) {
  std::string text;
  for (const auto& [words, count] : lenses)
    text += (text.empty() ? "" : "; ") + std::to_string(count) + " " + words;
  return text;
}

void print_info(const std::string& name, const SceneFile& file, double seconds, const Beside& beside) {
  const Scene& scene = file.scene;
  std::printf("%-15s %s\n", "scene", name.c_str());
  if (!beside.cameras.empty()) std::printf("%-15s %s\n", "cameras", beside.cameras.c_str());
  if (!beside.lenses.empty()) std::printf("%-15s %s\n", "lenses", count_text(beside.lenses).c_str());
  if (!beside.photos.empty()) std::printf("%-15s %s\n", "photographs", beside.photos.c_str());
  std::printf("%-15s %s\n", "format", file.format.c_str());
  if (file.bytes != 0) std::printf("%-15s %llu\n", "bytes", static_cast<unsigned long long>(file.bytes));
  std::printf("%-15s %.3g s\n", "read in", seconds);
  std::printf("%-15s %zu\n", "Gaussians", scene.size());
  std::printf("%-15s %llu of %llu\n", "dropped", static_cast<unsigned long long>(file.left_out.total()),
              static_cast<unsigned long long>(file.stored));
  const int used = used_sh_degree(scene);
  std::printf("%-15s %d%s\n", "SH degree", scene.sh_degree,
              used < scene.sh_degree ? (" (bands above " + std::to_string(used) + " are zero)").c_str() : "");
  if (const KeptHarmonics harmonics(scene); harmonics.bytes > 0)
    std::printf("%-15s %s, %.3g bytes a Gaussian on a device\n", "harmonics", harmonics.format.c_str(),
                harmonics.bytes);
  const std::string model = text_of(scene.model);
  std::printf("%-15s %s\n", "model", model.empty() ? "usual" : model.c_str());
  for (const std::string& note : file.notes) std::printf("%-15s %s\n", "note", note.c_str());
}

Json or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

std::string to_json(const std::string& scene, const std::string& path, const SceneFile& file, double seconds,
                    const Beside& beside, const std::vector<Distribution>& distributions) {
  const KeptHarmonics harmonics(file.scene);
  Json json{{"scene", scene},
            {"cameras", or_null(beside.cameras)},
            {"lenses", beside.lenses.empty() ? Json() : Json(beside.lenses)},
            {"photos", or_null(beside.photos)},
            {"file_format", file.format},
            {"bytes", file.bytes != 0 ? Json(file.bytes) : Json()},
            {"seconds", rounded(seconds, 4)},
            {"gaussians", file.scene.size()},
            {"stored", file.stored},
            {"dropped", file.left_out.total()},
            {"sh_degree", file.scene.sh_degree},
            {"used_sh_degree", used_sh_degree(file.scene)},
            {"harmonics", {{"kept", harmonics.format}, {"bytes_a_gaussian", rounded(harmonics.bytes, 4)}}},
            {"model", text_of(file.scene.model)},
            {"origin", {file.scene.origin.x, file.scene.origin.y, file.scene.origin.z}}};
  Json percentiles{{"percent", Json::array()}};
  for (const double part : quantiles) percentiles["percent"].push_back(100 * part);
  for (const Distribution& distribution : distributions)
    for (const double part : quantiles)
      percentiles[distribution.member].push_back(rounded(distribution.at(part), 9));
  json["percentiles"] = percentiles;
  ResultHead head = head_of("swiftgs-info");
  head.notes = notes_of(path, file.notes);
  return document_of(head, members_of(json));
}

void info_of_pages(const InfoOptions& options) {
  const PagedScene pages = open_pages(options.scene.scene);
  ResultFile json(options.json);
  std::size_t leaves = 0;
  std::uint64_t bytes = 0;
  for (const Page& page : pages.pages()) leaves += page.is_leaf(), bytes += page.bytes;
  const std::string model = text_of(pages.model());
  const dvec3& origin = pages.origin();
  const ChunkBounds& bounds = pages.pages()[pages.root()].bounds;
  if (!json.is_standard_output()) {
    std::printf("%-15s %s\n", "scene", options.scene.scene.c_str());
    std::printf("%-15s %s\n", "format", pages.format());
    std::printf("%-15s %llu\n", "bytes", static_cast<unsigned long long>(bytes));
    std::printf("%-15s %llu\n", "Gaussians", static_cast<unsigned long long>(pages.gaussians()));
    std::printf("%-15s %zu, and %zu above them, of %u at most\n", "pages", leaves,
                pages.pages().size - leaves, pages.page_size());
    std::printf("%-15s %d\n", "SH degree", pages.sh_degree());
    std::printf("%-15s %s\n", "model", model.empty() ? "usual" : model.c_str());
    for (int axis = 0; axis < 3; ++axis)
      std::printf("%-15c %.4g to %.4g\n", "xyz"[axis], double(bounds.low[axis]), double(bounds.high[axis]));
  }
  if (json.is_wanted()) {
    const Json all{{"scene", std::filesystem::path(options.scene.scene).stem().string()},
                   {"file_format", pages.format()},
                   {"bytes", bytes},
                   {"gaussians", pages.gaussians()},
                   {"pages", {{"leaves", leaves}, {"all", pages.pages().size}, {"size", pages.page_size()}}},
                   {"sh_degree", pages.sh_degree()},
                   {"model", model},
                   {"origin", {origin.x, origin.y, origin.z}}};
    json.write(document_of(head_of("swiftgs-info"), members_of(all)));
  }
  json.finish();
}

void info(const InfoOptions& options) {
  if (is_page_file(options.scene.scene)) return info_of_pages(options);
  const Capture capture = capture_of(options.scene);
  require_distinct({{"--json", options.json}}, {{"SCENE", capture.scene.string()}});
  ResultFile json(options.json);
  const auto begin = std::chrono::steady_clock::now();
  SceneFile file = load(options.scene);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  Beside beside{cameras_of(options.scene, ""), photos_of(options.scene, {}, "")};
  if (!beside.cameras.empty()) beside.lenses = lenses_in(options.scene.scene, file.notes);
  const std::vector<Distribution> distributions = distributions_of(file.scene);
  if (!json.is_standard_output()) {
    print_info(options.scene.scene, file, seconds, beside);
    print_distributions(distributions);
  }
  if (json.is_wanted())
    json.write(to_json(capture.name, capture.scene.string(), file, seconds, beside, distributions));
  json.finish();
}

constexpr const char* info_help =
    R"(Prints format, size of the file and time to read it, count, SH degree, how a device keeps
harmonics, how many Gaussians were dropped, with a note for each reason, the origin of a
scene far from zero, and percentiles of positions (relative to the origin), opacities and
scales; of a capture's folder also where its cameras and photographs are, and the cameras'
lenses. Of a page file it reads the table alone, of 3D Tiles the JSON and one file.

Example:
  swiftgs info garden.spz)";

}  // namespace

void add_info(CLI::App& app) {
  CLI::App* command = app.add_subcommand("info", "What a scene holds");
  command->footer(info_help);
  const auto options = std::make_shared<InfoOptions>();
  add_scene(*command, options->scene);
  add_json(*command, options->json);
  command->callback([options] { info(*options); });
}

}  // namespace swiftgs::cli
