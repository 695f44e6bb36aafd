// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Gaussians and pinholes for which projection in pairs of floats is held to projection in double.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/scene.hpp>

#include "hard_frames/families.hpp"

namespace swiftgs::test {

struct PairCase {
  std::string name;
  double severity;  ///< of a family of `stress`, or the distance from the origin
  ViewConstants view;
  Scene scene;
};

/// The built-in scene and a camera of it, moved together; lenses of the usual length and of 60 times it.
inline void add_far_pair_cases(std::vector<PairCase>& out) {
  const Scene at_origin = make_builtin_scene(20'000);
  for (const double distance : {0.0, 1e2, 1e4, 1e6}) {
    const dvec3 offset = distance * dvec3(0.6, -0.5, 0.62);
    Scene scene = at_origin;
    for (vec3& mean : scene.means) mean = vec3(dvec3(mean) + offset);
    for (Camera camera : builtin_cameras(3)) {
      camera.translation -= camera.rotation * offset;
      out.push_back({"moved", distance, view_constants(camera, Conventions::gsplat()), scene});
      camera.fx *= 60, camera.fy *= 60;
      out.push_back({"moved-long", distance, view_constants(camera, Conventions::inria()), scene});
    }
  }
}

/// Means from before the near plane to a thousand units off, around a camera that looks any way.
inline void add_near_pair_case(std::vector<PairCase>& out) {
  stress::Random random(3);
  Camera camera = look_at(dvec3(3, -2, 1), dvec3(-1.3, 0.4, 7.1), dvec3(0.2, -1, 0.1), 0.9, 1600, 900);
  const dvec3 centre = camera.centre();
  Scene scene;
  for (int i = 0; i < 40'000; ++i) {
    const double z = random.scale(0.005, 1000);
    const dvec3 seen(random.in(-1, 1) * z, random.in(-0.6, 0.6) * z, z);
    const auto size = float(0.01 * z);
    stress::add(scene, {.mean = vec3(seen * camera.rotation + centre),
                        .scale = {size, 0.3f * size, 2 * size},
                        .rotation = random.rotation()});
  }
  out.push_back({"near", 0, view_constants(camera, Conventions::gsplat()), std::move(scene)});
}

/// The pinholes of all families, some seeds of each severity.
inline void add_stress_pair_cases(std::vector<PairCase>& out) {
  for (const StressFamily& family : stress_families())
    for (const double severity : family.severities)
      for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        StressCase drawn = family.make(severity, seed, {});
        const ViewConstants camera = view_constants(drawn.camera, drawn.conventions);
        if (camera.through_lens) continue;
        PlacedScene placed;
        placed.world_from_scene = drawn.world_from_scene;
        ViewConstants view = eye(camera, placed);
        view.set_pairs();
        out.push_back({std::string(family.name), severity, view, std::move(drawn.scene)});
      }
}

inline std::vector<PairCase> pair_cases() {
  std::vector<PairCase> out;
  add_far_pair_cases(out), add_near_pair_case(out), add_stress_pair_cases(out);
  return out;
}

}  // namespace swiftgs::test
