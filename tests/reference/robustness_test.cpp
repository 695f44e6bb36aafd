// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <swiftgs/frame.hpp>
#include <swiftgs/tools/parallel.hpp>

#include "reference/gaussians.hpp"

namespace swiftgs::test {
namespace {

/// Every combination of extreme means, scales, rotations and opacities.
Scene extreme_scene() {
  Scene scene;
  const float huge = std::numeric_limits<float>::max(), tiny = std::numeric_limits<float>::denorm_min();
  for (const float z : {0.01f, 0.010001f, 0.2f, 1.0f, 1e10f, huge, -1.0f, 0.0f, tiny})
    for (const float x : {0.0f, -3e3f, 1e20f, huge})
      for (const vec3 scale : {vec3(0), vec3(tiny), vec3(1e-20f), vec3(1e6f, 1e-6f, 0), vec3(0, 0, 1e9f),
                               vec3(huge), vec3(huge, 0, tiny)})
        for (const Quaternion q : {Quaternion{}, Quaternion{0.5f, 0.5f, 0.5f, 0.5f}, Quaternion{0, 0, 0, 0},
                                   Quaternion{0.8f, 0.1f, -0.2f, 0.5477226f}})
          for (const float opacity : {0.0f, 0.5f, 1.0f}) {
            scene.means.push_back({x, 0, z});
            scene.scales.push_back(scale);
            scene.rotations.push_back(q);
            scene.opacities.push_back(opacity);
            scene.sh0.push_back({1, 1e30f, -1e30f});
          }
  return scene;
}

TEST_CASE("reference: extreme Gaussians leave no NaN and no infinity in the image") {
  for (Conventions k : {Conventions::gsplat(), Conventions::inria()})
    for (const bool antialiased : {false, true})
      for (const float blur : {0.3f, 0.0f})
        for (const float alpha_min : {1.0f / 255, 0.0f}) {
          k.antialiased = antialiased, k.blur = blur, k.alpha_min = alpha_min;
          const ReferenceFrame frame = draw(extreme_scene(), k, dvec3(1));
          CHECK(is_finite(frame));
          CHECK(frame.visible > 0);
        }
}

TEST_CASE("reference: no plane at all still leaves no NaN in the image") {
  Conventions k;
  for (const float near : {-INFINITY, 0.0f}) {
    k.near_plane = near;
    CHECK(is_finite(draw(extreme_scene(), k)));
  }
}

TEST_CASE("reference: scales of a Gaussian that the planes cull are not read") {
  // Whole pages of scales belong to Gaussians behind the camera. A read of them ends the program.
  const std::size_t page = std::size_t(sysconf(_SC_PAGESIZE)), count = page;
  Scene scene;
  scene.means.assign(count, vec3(0, 0, 2)), scene.scales.assign(count, vec3(0.1f));
  scene.rotations.resize(count), scene.opacities.assign(count, 0.01f), scene.sh0.resize(count);
  const auto begin = reinterpret_cast<std::uintptr_t>(scene.scales.data());
  const std::uintptr_t first = (begin + page - 1) / page * page, last = first + 10 * page;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uintptr_t at = begin + i * sizeof(vec3);
    if (at + sizeof(vec3) > first && at < last) scene.means[i].z = -2;
  }
  const ReferenceFrame all = draw(scene);
  REQUIRE(mprotect(reinterpret_cast<void*>(first), 10 * page, PROT_NONE) == 0);
  const ReferenceFrame guarded = draw(scene);
  REQUIRE(mprotect(reinterpret_cast<void*>(first), 10 * page, PROT_READ | PROT_WRITE) == 0);
  CHECK(guarded.contributing_pairs > 0);
  CHECK(guarded.colour == all.colour);
}

TEST_CASE("reference: without a threshold a Gaussian reaches every pixel unless its opacity is 0") {
  Conventions k;
  k.alpha_min = 0;
  CHECK(draw(scene_of(Gaussian{.opacity = 0}), k).alpha == std::vector<double>(33 * 33, 0.0));
  const ReferenceFrame frame = draw(scene_of(Gaussian{}), k);
  CHECK(frame.contributing_pairs == 33 * 33);
  CHECK(alpha_at(frame, 0, 16) > 0);
}

TEST_CASE("reference: the Gaussian that would bring transmittance below the stop ends its pixel") {
  // In the middle pixel transmittance is 1/2 after the first and 1/4 after the second; the third is faint
  // enough to pass alone.
  const Scene scene =
      scene_of(Gaussian{.mean = {0, 0, 2}, .opacity = 0.5f}, Gaussian{.mean = {0, 0, 3}, .opacity = 0.5f},
               Gaussian{.mean = {0, 0, 4}, .opacity = 0.125f});
  Conventions k;
  for (const auto& [stop, at_equal, alpha] :
       {std::tuple{0.25f, true, 0.5}, {0.25f, false, 0.75}, {0.2f, false, 0.78125}}) {
    k.stop = stop, k.stop_at_equal = at_equal;
    CHECK(alpha_at(draw(scene, k), 16, 16) == alpha);
  }
}

TEST_CASE("reference: invalid arguments are refused") {
  const Scene scene = scene_of(Gaussian{});
  Scene torn = scene;
  torn.opacities.clear();
  Camera flat = small_camera();
  flat.height = 0;
  const Conventions k;
  CHECK_THROWS_AS(render_reference(torn, small_camera(), k), std::invalid_argument);
  CHECK_THROWS_AS(render_reference(scene, flat, k), std::invalid_argument);
  for (const double bad : {double(NAN), double(INFINITY), -double(INFINITY)})
    for (int channel = 0; channel < 3; ++channel) {
      dvec3 background(0);
      background[channel] = bad;
      CHECK_THROWS_AS(draw(scene, k, background), std::invalid_argument);
    }
  const float occluder = 1;
  CHECK_THROWS_AS(render_reference(scene, small_camera(), k, dvec3(0), 1, {&occluder, 1}),
                  std::invalid_argument);
  CHECK_THROWS_WITH_AS(render_reference(scene, small_camera(), k, dvec3(0), -1),
                       "threads: expected 0 (one a processor) or more, got -1", std::invalid_argument);
}

TEST_CASE("reference: an exception on any thread reaches the caller") {
  for (const int threads : {1, 4})
    CHECK_THROWS_AS(for_each_index(100, threads,
                                   [](std::size_t i) {
                                     if (i == 57) throw std::length_error("57");
                                   }),
                    std::length_error);
}

}  // namespace
}  // namespace swiftgs::test
