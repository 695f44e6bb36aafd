// SPDX-License-Identifier: Apache-2.0

/// @file
/// What planes beside colour cost. docs/planes.md shows the table.

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <swiftgs/any_renderer.hpp>

#include "inputs.hpp"

namespace {

using namespace swiftgs;
using Json = nlohmann::ordered_json;

constexpr int features = 16, rounds = 9, frames_of_round = 20;

/// Features from harmonics, for want of others.
Scene with_features(Scene scene) {
  const std::size_t stored = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  scene.feature_channels = features;
  scene.features.resize(scene.size() * features);
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (std::size_t c = 0; c < features; ++c)
      scene.features[i * features + c] = c < stored ? scene.sh_rest[i * stored + c] : scene.opacities[i];
  return scene;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Milliseconds of a frame that stays in the backend's memory: a median.
double milliseconds(AnyRenderer& renderer, const Camera& camera, const Outputs& outputs) {
  RenderSettings settings;
  settings.outputs = outputs, settings.time = true;
  renderer.render_resident(camera, settings);  // takes the memory
  std::vector<double> found;
  for (int frame = 0; frame < frames_of_round; ++frame) {
    renderer.render_resident(camera, settings);
    found.push_back(renderer.times().total);
  }
  return median(found);
}

/// Of a scene's first view. Sets of planes take turns.
Json measure(AnyRenderer& renderer, const bench::Input& input) {
  const auto scene = std::make_shared<const Scene>(with_features(input.load()));
  renderer.set_scene(scene);
  const std::pair<const char*, Outputs> sets[] = {
      {"", {}},
      {"alpha,depth", {.alpha = true, .depth = true}},
      {"median_depth,id", {.median_depth = true, .id = true}},
      {"first_depth,median_depth,id,median_id",
       {.first_depth = true, .median_depth = true, .id = true, .median_id = true}},
      {"normal", {.normal = true}},
      {"alpha,depth,squared_depth,normal",
       {.alpha = true, .depth = true, .squared_depth = true, .normal = true}},
      {"alpha,depth,normal,id", {.alpha = true, .depth = true, .normal = true, .id = true}},
      {"features:4", {.features = 4}},
      {"features:16", {.features = features}},
  };
  std::vector<std::vector<double>> taken(std::size(sets));
  for (int round = 0; round < rounds; ++round)
    for (std::size_t k = 0; k < std::size(sets); ++k)
      taken[k].push_back(milliseconds(renderer, input.views.front(), sets[k].second));
  Json rows = Json::array();
  for (std::size_t k = 0; k < std::size(sets); ++k)
    rows.push_back({{"scene", input.name},
                    {"gaussians", scene->size()},
                    {"size", input.size()},
                    {"renderer", renderer.name()},
                    {"planes", sets[k].first},
                    {"ms", median(taken[k])}});
  return rows;
}

}  // namespace

/// planes_table MACHINE.json RENDERER SCENE...: results as JSON. `machine` is what
/// benchmarks/describe_machine.sh prints.
int main(int argc, char** argv) try {
  std::ifstream file(argc >= 4 ? argv[1] : "");
  const Json machine = Json::parse(file, nullptr, false);
  if (machine.is_discarded()) {
    std::cerr << "usage: planes_table MACHINE.json RENDERER SCENE...; expected what describe_machine.sh "
                 "prints as the "
                 "first\n";
    return 2;
  }
  const auto renderer = make_renderer(find_renderer(argv[2]).name);
  std::string command = "planes_table MACHINE.json " + std::string(argv[2]);
  for (int i = 3; i < argc; ++i) command.append(1, ' ').append(argv[i]);
  std::cout << "{\"format\": \"swiftgs-planes\", \"version\": 1,\n\"machine\": " << machine.dump()
            << ",\n\"command\": " << Json(command) << ",\n\"rows\": [";
  const char* separator = "\n";
  for (const bench::Input& input : bench::inputs_named({argv + 3, argv + argc}))
    for (const Json& row : measure(*renderer, input)) {
      std::cout << separator << ' ' << row.dump() << std::flush;
      separator = ",\n";
    }
  std::cout << "\n]}\n";
  return 0;
} catch (const std::exception& error) {
  std::cerr << "planes_table: " << error.what() << '\n';
  return 1;
}
