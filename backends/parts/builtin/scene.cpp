// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include <swiftgs/builtin_scene.hpp>

#include "landscape.hpp"
#include "plants.hpp"
#include "still_life.hpp"
#include "terrace.hpp"

namespace swiftgs {

namespace builtin {
namespace {

/// A surface of the still life and its share of all Gaussians.
struct Part {
  Surface surface;
  double share;
  bool casts_shadow;
};

std::vector<Part> still_life() {
  return {{terrace_tiles(), 0.22, false},
          {kerb(), 0.025, false},
          {drum(), 0.045, true},
          {knot(), 0.15, true},
          {vase(), 0.08, true},
          {nautilus(), 0.08, true},
          {ball(at(-0.50, 0.125, -1.20), 0.125, dvec3(0.62, 0.045, 0.035)), 0.014, true},
          {ball(at(0.36, 0.09, -1.38), 0.09, dvec3(0.80, 0.45, 0.05)), 0.009, true},
          {ball(at(-0.86, 0.075, -0.86), 0.075, dvec3(0.10, 0.36, 0.30)), 0.007, true}};
}

Light light_of(const std::vector<Part>& parts) {
  Light light;
  for (const Part& part : parts)
    for (std::uint64_t i = 0; part.casts_shadow && i < 40'000; ++i) {
      const SquarePoint q(i);
      light.add_occluder(part.surface.point(q.u, q.v));
    }
  return light;
}

}  // namespace
}  // namespace builtin

Scene make_builtin_scene(std::size_t count, const ScenePart& part) {
  using namespace builtin;
  validate(part);
  const ScenePart::Range kept = part.range(count);
  Scene scene;
  scene.sh_degree = 3;
  const std::size_t size = kept.size();
  for_each_array([&](const char*, std::size_t each, auto& values) { values.resize(each * size); }, scene);

  double share_so_far = 0;
  std::size_t begin = 0;
  const auto range = [&](double share) {
    share_so_far += share;
    const std::size_t end = std::min(count, std::size_t(std::floor(share_so_far * double(count) + 0.5)));
    return Sink(scene, kept, std::exchange(begin, end), end);
  };

  const std::vector<Part> parts = still_life();
  const Light light = light_of(parts);
  std::uint64_t stream = 100;
  for (const Part& each : parts) emit(each.surface, stream++, range(each.share), light);

  const double fineness = std::sqrt(double(count) / double(builtin_scene_size));
  emit_plumes(201, range(0.04), fineness);
  emit_trees(202, range(0.045));
  emit_balloon(204, range(0.005));
  emit_land(205, range(0.13));
  emit_sky(206, range(0.07));
  emit_floaters(207, range(0.01), fineness);
  emit_grass(208, Sink(scene, kept, begin, count), fineness);
  return scene;
}

Camera builtin_camera(int width, int height) {
  Camera camera =
      look_at(builtin::at(-0.9, 1.5, -4.0), builtin::at(0.03, 0.90, 0), dvec3(0, -1, 0), 0.76, width, height);
  camera.name = "front";
  return camera;
}

std::vector<Camera> builtin_cameras(int views, int width, int height) {
  std::vector<Camera> cameras;
  for (int k = 0; k < views; ++k) {
    const double turn = double(k) / views - 0.25, rise = 1.7 + 0.35 * builtin::sin_turns(2.0 * k / views);
    const dvec3 eye = builtin::at(4.2 * builtin::cos_turns(turn), rise, 4.2 * builtin::sin_turns(turn));
    cameras.push_back(look_at(eye, builtin::at(0, 0.78, 0), dvec3(0, -1, 0), 0.76, width, height));
    cameras.back().name.append("orbit-").append(std::to_string(k / 10)).append(std::to_string(k % 10));
  }
  return cameras;
}

}  // namespace swiftgs
