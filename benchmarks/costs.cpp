// SPDX-License-Identifier: Apache-2.0

/// @file
/// What planes beside colour cost, and placed scenes beside one scene that holds the same Gaussians.
/// docs/planes.md and docs/scenes.md show the tables.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <exception>
#include <functional>
#include <iostream>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/swiftgs.hpp>
#if defined(SWIFTGS_TEST_CUDA)
#include <swiftgs/cuda.hpp>
#endif

#include "inputs.hpp"

namespace {

using namespace swiftgs;
using Json = nlohmann::ordered_json;

constexpr int rounds = 7;

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Frames of one kind. Frame k may differ from frame k - 1.
struct Frames {
  std::string kind;
  std::function<void(int)> draw;
  int in_a_row;
};

/// Milliseconds of each frame.
struct Taken {
  /// Among many in a row until the backend has finished, by the clock on the wall: the copies of placed
  /// scenes to a device count.
  std::vector<double> wall;
  std::vector<double> project, total;  ///< by the backend's clock
};

/// Features from harmonics, for want of others.
Scene with_features(Scene scene) {
  constexpr std::size_t channels = 16;
  const auto stored = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  scene.feature_channels = channels;
  scene.features.resize(scene.size() * channels);
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (std::size_t c = 0; c < channels; ++c)
      scene.features[i * channels + c] = c < stored ? scene.sh_rest[i * stored + c] : scene.opacities[i];
  return scene;
}

/// A rotation about the vertical.
dmat3 turned(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {dvec3(c, 0, -s), dvec3(0, 1, 0), dvec3(s, 0, c)};
}

/// A pose that turns a little about `centre`, other in each frame.
Similarity swaying(const dvec3& centre, int frame) {
  Similarity pose{turned(0.001 * (1 + frame % 7)), 1, dvec3(0.0)};
  pose.translation = centre - pose.rotation * centre;
  return pose;
}

template <class B>
class Bench {
 public:
  using R = Renderer<B>;

  /// Each set of planes beside colour, on a scene's first view.
  void planes(const bench::Input& input) {
    const Scene scene = with_features(input.load());
    const auto whole = backend().upload(scene);
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
        {"features:16", {.features = 16}},
    };
    const Camera& camera = input.views.front();
    std::vector<Frames> kinds;
    for (const auto& [names, outputs] : sets)
      kinds.push_back({names,
                       [&, outputs = outputs](int) {
                         settings_.outputs = outputs;
                         renderer_.render_resident(whole, camera, settings_);
                       },
                       in_a_row});
    print("planes", input.name, scene.size(), 1, camera, kinds);
    settings_.outputs = {};
  }

  /// A scene whole, in 100 fixed pieces, in 100 moving pieces, and in two parts, one of them moving.
  void pieces(const bench::Input& input) {
    const Scene scene = order_spatially(input.load());
    const auto whole = backend().upload(scene);
    constexpr std::size_t count = 100;
    std::vector<typename B::SceneOn> uploaded;
    std::vector<PlacedScene> standing;
    for (std::size_t i = 0; i < count; ++i) {
      uploaded.push_back(backend().upload(part_of(scene, {i, count})));
      standing.push_back({uploaded.back().view()});
    }
    // 40.6 % of the Gaussians: of fox, 175,799.
    const auto first = std::size_t(0.5935 * double(scene.size()));
    Scene still = subset(scene, first_indices(0, first)),
          moving = subset(scene, first_indices(first, scene.size()));
    const auto still_there = backend().upload(still), moving_there = backend().upload(moving);

    const Camera& camera = input.views.front();
    const auto draw = [&](const PlacedScenes& scenes) {
      renderer_.render_resident(scenes, camera, settings_);
    };
    std::vector<PlacedScene> moved = standing;
    const std::vector<Frames> kinds{
        {"one scene", [&](int) { draw(whole); }, in_a_row},
        {"100 pieces", [&](int) { draw(standing); }, in_a_row},
        {"100 pieces that move",
         [&](int frame) {
           for (std::size_t i = 0; i < count; ++i)
             moved[i].world_from_scene = swaying(dvec3(scene.means[i * scene.size() / count]), frame);
           draw(moved);
         },
         in_a_row},
        {"two parts, one moves",
         [&](int frame) {
           draw(std::vector<PlacedScene>{{still_there.view()},
                                         {moving_there.view(), swaying(dvec3(moving.means[0]), frame)}});
         },
         in_a_row},
        {"one part moved by transform, append and upload",
         [&](int frame) {
           Scene both = still, copy = moving;
           transform(copy, swaying(dvec3(moving.means[0]), frame));
           append(both, copy);
           draw(backend().upload(std::move(both)));
         },
         1}};
    print("placed", input.name, scene.size(), 1, camera, kinds);
  }

  /// 1,000 copies of 1,000 Gaussians, and one scene of these.
  void copies() {
    const Scene object = make_builtin_scene(1000);
    const auto uploaded = backend().upload(object);
    std::vector<PlacedScene> placed;
    Scene all = empty_like(object);
    for (int i = 0; i < 1000; ++i) {
      const Similarity pose{turned(i), 0.12, dvec3(i % 10 - 4.5, i / 10 % 10 - 4.5, i / 100 - 4.5)};
      placed.push_back({uploaded.view(), pose});
      Scene copy = object;
      transform(copy, pose);
      append(all, copy);
    }
    const auto one = backend().upload(order_spatially(std::move(all)));
    const Camera camera = look_at(dvec3(9, -6, -12), dvec3(0), dvec3(0, -1, 0), 0.8, 1280, 720);
    const std::vector<Frames> kinds{
        {"one scene", [&](int) { renderer_.render_resident(one, camera, settings_); }, in_a_row},
        {"1,000 placed copies", [&](int) { renderer_.render_resident(placed, camera, settings_); },
         in_a_row}};
    print("placed", "1,000 copies of 1,000", 1'000'000, 1, camera, kinds);
  }

  /// Views of 128 x 128 pixels, each of one of many worlds.
  void worlds(int count, int views_in_all) {
    const auto uploaded = backend().upload(make_builtin_scene(20'000));
    std::vector<PlacedScene> placed;
    for (int i = 0; i < count; ++i)
      placed.push_back({uploaded.view(), {turned(0.1 * i), 1 + 0.01 * i, dvec3(0.1 * i, 0, 0)}});
    const Camera own = builtin_camera(128, 128);
    typename B::template Buffer<float> memory;
    memory.reset(std::size_t(views_in_all) * 128 * 128 * 3);
    std::vector<View> views;
    for (int v = 0; v < views_in_all; ++v) {
      Camera camera = own;
      camera.translation += dvec3(0.002 * v, 0, 0);
      const FrameView frame{
          .width = 128,
          .height = 128,
          .colour = {memory.data() + std::size_t(v) * 128 * 128 * 3, 128 * 3 * sizeof(float)}};
      views.push_back(make_view(camera, {}, frame));
      views.back().shows = {std::uint32_t(v % count), 1};
    }
    const std::vector<Frames> kinds{
        {"one frame",
         [&](int) {
           renderer_.render_into(placed, Span<const View>{views.data(), views.size()},
                                 {.time = settings_.time});
         },
         3},
        {"a frame a view",
         [&](int) {
           for (const View& view : views)
             renderer_.render_into(placed, Span<const View>{&view, 1}, {.time = settings_.time});
         },
         1}};
    print("placed", std::to_string(count) + " worlds of 20,000", std::size_t(count) * 20'000, views_in_all,
          own, kinds);
  }

 private:
  static constexpr int in_a_row = B::reaches_host_memory ? 5 : 20;

  B& backend() { return renderer_.backend(); }

  static std::vector<std::uint32_t> first_indices(std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> indices;
    for (std::size_t i = begin; i < end; ++i) indices.push_back(std::uint32_t(i));
    return indices;
  }

  /// Kinds alternate.
  std::vector<Taken> take(const std::vector<Frames>& kinds) {
    std::vector<Taken> taken(kinds.size());
    for (int round = 0; round <= rounds; ++round)
      for (std::size_t k = 0; k < kinds.size(); ++k) {
        const Frames& frames = kinds[k];
        backend().wait();
        const auto begin = std::chrono::steady_clock::now();
        for (int frame = 0; frame < frames.in_a_row; ++frame) frames.draw(frame);
        backend().wait();
        const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - begin;
        settings_.time = true;
        for (int frame = 0; frame < frames.in_a_row; ++frame) {
          frames.draw(frame);
          backend().wait();
          if (round == 0) continue;  // it takes memory
          taken[k].project.push_back(renderer_.times().project);
          taken[k].total.push_back(renderer_.times().total);
        }
        settings_.time = false;
        if (round != 0) taken[k].wall.push_back(ms.count() / frames.in_a_row);
      }
    return taken;
  }

  /// A row of each kind, whose name becomes the member `what`.
  void print(const char* what, const std::string& scene, std::size_t gaussians, int views,
             const Camera& camera, const std::vector<Frames>& kinds) {
    const std::vector<Taken> taken = take(kinds);
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      Json row{{"scene", scene},        {"gaussians", gaussians},  {"batch", views},
               {"width", camera.width}, {"height", camera.height}, {"renderer", R::name},
               {what, kinds[k].kind}};
      row["ms"]["project"]["median"] = median(taken[k].project);
      row["ms"]["total"]["median"] = median(taken[k].total);
      row["ms"]["wall"]["median"] = median(taken[k].wall);
      std::cout << row << std::endl;
    }
  }

  RenderSettings settings_;
  R renderer_;
};

template <class B>
void measure(std::string_view what, const std::vector<bench::Input>& inputs) {
  Bench<B> bench;
  for (const bench::Input& input : inputs) what == "planes" ? bench.planes(input) : bench.pieces(input);
  if (what == "planes") return;
  bench.copies();
  bench.worlds(64, B::reaches_host_memory ? 64 : 1024);
}

}  // namespace

/// costs_table BACKEND planes|placed SCENE...: rows as JSON, for benchmarks/result_file.sh.
int main(int argc, char** argv) try {
  const std::string_view backend = argc >= 4 ? argv[1] : "", what = argc >= 4 ? argv[2] : "";
  if ((backend != "cpu" && backend != "cuda") || (what != "planes" && what != "placed")) {
    std::cerr << "usage: costs_table cpu|cuda planes|placed SCENE...\n";
    return 2;
  }
  const auto inputs = bench::inputs_named({argv + 3, argv + argc});
  if (backend == "cpu") measure<Cpu>(what, inputs);
#if defined(SWIFTGS_TEST_CUDA)
  if (backend == "cuda") measure<Cuda>(what, inputs);
#endif
  return 0;
} catch (const std::exception& error) {
  std::cerr << "costs_table: " << error.what() << '\n';
  return 1;
}
