// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include <CLI/CLI.hpp>

#include "commands.hpp"
#include "options.hpp"
#include "scene_input.hpp"

namespace swiftgs::cli {
namespace {

constexpr double parts[] = {0, 0.01, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 1};

/// One line of percentiles of what `measure` gives for each Gaussian.
template <class Measure>
void print_percentiles(const char* label, std::size_t count, Measure measure) {
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = measure(i);
  std::sort(values.begin(), values.end());
  std::printf("%-15s", label);
  for (const double part : parts)
    std::printf(" %9.4g", double(values[std::size_t(part * double(count - 1))]) + 0.0);  // no -0
  std::printf("\n");
}

void print_distributions(const Scene& scene) {
  std::printf("\n%-15s", "percentiles");
  for (const double part : parts) std::printf(" %8.3g%%", 100 * part);
  std::printf("\n");
  const std::size_t n = scene.size();
  print_percentiles("x", n, [&](std::size_t i) { return scene.means[i].x; });
  print_percentiles("y", n, [&](std::size_t i) { return scene.means[i].y; });
  print_percentiles("z", n, [&](std::size_t i) { return scene.means[i].z; });
  print_percentiles("opacity", n, [&](std::size_t i) { return scene.opacities[i]; });
  const auto sorted_scale = [&](std::size_t i, int rank) {
    float s[3] = {scene.scales[i].x, scene.scales[i].y, scene.scales[i].z};
    std::sort(s, s + 3);
    return s[rank];
  };
  print_percentiles("longest scale", n, [&](std::size_t i) { return sorted_scale(i, 2); });
  print_percentiles("middle scale", n, [&](std::size_t i) { return sorted_scale(i, 1); });
  print_percentiles("shortest scale", n, [&](std::size_t i) { return sorted_scale(i, 0); });
}

void info(const SceneOptions& options) {
  const SceneFile file = load(options);
  const Scene& scene = file.scene;
  std::printf("%-15s %s\n", "scene", options.scene.c_str());
  std::printf("%-15s %s\n", "format", file.format.c_str());
  std::printf("%-15s %zu\n", "Gaussians", scene.size());
  std::printf("%-15s %llu of %llu (not finite)\n", "dropped",
              static_cast<unsigned long long>(file.dropped_nonfinite),
              static_cast<unsigned long long>(file.stored));
  const int used = used_sh_degree(scene);
  std::printf("%-15s %d%s\n", "SH degree", scene.sh_degree,
              used < scene.sh_degree ? (" (bands above " + std::to_string(used) + " are zero)").c_str() : "");
  std::printf("%-15s %s\n", "anti-aliased", scene.antialiased ? "yes" : "no");
  for (const std::string& note : file.notes) std::printf("%-15s %s\n", "note", note.c_str());
  if (scene.size() > 0) print_distributions(scene);
}

constexpr const char* more =
    R"(Prints format, count, SH degree, how many Gaussians were dropped because they are not
finite, and percentiles of positions, opacities and scales.

Example:
  swiftgs info garden.spz)";

}  // namespace

void add_info(CLI::App& app) {
  CLI::App* command = app.add_subcommand("info", "What a scene holds");
  command->footer(more);
  const auto options = std::make_shared<SceneOptions>();
  add_scene(*command, *options);
  command->callback([options] { info(*options); });
}

}  // namespace swiftgs::cli
