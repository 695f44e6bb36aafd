// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Changes of a scene that must not change a bit of its image, for every renderer with conservative bounds of
/// whatever backends the including file has. It defines SWIFTGS_METAMORPHIC, what the names of the cases
/// begin with, and in `swiftgs::test` a function `unavailable` that skips the case where the backends cannot
/// run, and `backends`, their names.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/project/project.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"

namespace swiftgs::test {
namespace {

/// What a frame is rendered from.
struct World {
  Scene scene;
  Camera camera;
  Conventions conventions;
  /// Which Gaussian each was before a change; empty: the same.
  std::vector<std::uint32_t> before_change{};
};

/// The worlds that every test changes: ordinary Gaussians, needles, and means far beside the image.
enum class Kind { ordinary, needles, far_means };
constexpr Kind kinds[] = {Kind::ordinary, Kind::needles, Kind::far_means};
constexpr std::uint64_t seeds[] = {1, 2, 3, 4, 5, 6};

/// Leaves out Gaussians until no two are drawn at depths within the last places in which backends may differ.
void keep_distinct_depths(World& world) {
  const ViewConstants constants = view_constants(world.camera, world.conventions);
  const SceneView scene = view(world.scene);
  std::vector<float> depths;
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < scene.size(); ++i) {
    const ProjectedShape p = project_shape(constants, gaussian(scene, i));
    const auto close = [&](float depth) { return std::abs(depth - p.depth) <= 0x1p-20f * p.depth; };
    if (p.visible && std::any_of(depths.begin(), depths.end(), close)) continue;
    if (p.visible) depths.push_back(p.depth);
    kept.push_back(i);
  }
  CHECK(depths.size() > 20);
  world.scene = subset(world.scene, kept);
}

World make_world(Kind kind, std::uint64_t seed) {
  Random random(seed);
  World world{with_features(random_scene(160, int(seed % 4), seed), 5), forward_camera(83, 50),
              Conventions::gsplat()};
  if (seed % 3 == 2) world.conventions = Conventions::inria();
  world.conventions.antialiased = seed % 3 == 0;
  if (seed % 2 == 0) {
    world.camera = look_at(dvec3(-0.4, 0.3, -0.9), dvec3(0.1, 0, 5), dvec3(0.1, -1, 0.2), 0.9, 83, 50);
    world.camera.cx += 2.3;
  }
  for (std::size_t i = 0; i < world.scene.size(); ++i) {
    vec3 &mean = world.scene.means[i], &scale = world.scene.scales[i];
    if (kind == Kind::ordinary) scale *= 3.0f;
    if (kind == Kind::needles) {
      const float length = float(random.scale(0.1, 20));
      scale =
          vec3{length * float(random.scale(1e-6, 1e-2)), length, length * float(random.scale(1e-6, 1e-2))};
    }
    if (kind == Kind::far_means) {
      const float away = float(random.scale(2, 500));
      mean.z = std::abs(mean.z) + 0.5f;
      mean.x *= away, mean.y *= away;
      scale *= away * 3;
    }
  }
  keep_distinct_depths(world);
  return world;
}

/// Pixels that show more than a tenth of a Gaussian.
std::ptrdiff_t covered(const Frame& image) {
  return std::count_if(image.alpha.begin(), image.alpha.end(), [](float a) { return a > 0.1f; });
}

/// All planes; the Gaussians in them are those before the change.
Frame render(AnyRenderer& renderer, const World& world) {
  renderer.set_scene(std::make_shared<const Scene>(world.scene));
  RenderSettings settings;
  settings.conventions = world.conventions, settings.background = vec3(0.2f, 0.3f, 0.4f);
  settings.outputs = all_planes(world.scene.feature_channels);
  Frame frame;
  renderer.render(world.camera, settings, frame);
  for (auto* const ids : {&frame.id, &frame.median_id})
    for (std::uint32_t& id : *ids)
      if (id != no_gaussian && !world.before_change.empty()) id = world.before_change.at(id);
  return frame;
}

/// Calls f(renderer) for each rasterizer of `backends` with two pairs of a sort and bounds. Parity holds the
/// others to these.
template <class F>
void for_each_renderer(const F& f) {
  std::size_t count = 0;
  for (const RendererEntry& entry : renderers()) {
    const std::string_view name = entry.name, backend = name.substr(0, name.find('/'));
    if (std::find(std::begin(backends), std::end(backends), backend) == std::end(backends)) continue;
    const auto has = [&](const char* word) { return name.find(word) != std::string_view::npos; };
    if (!(has("/early/") && has("/ellipse")) && !(has("/standard/") && has("/opacity-box"))) continue;
    CAPTURE(entry.name);
    f(*entry.make());
    ++count;
  }
  CHECK(count == std::size(backends) * AllRasters::size * 2);
}

/// Checks that `change` maps each world to one whose image is `expected` of the first one's.
template <class Change, class Expected>
void check_all(const Change& change, const Expected& expected) {
  if (unavailable()) return;
  for (const Kind kind : kinds)
    for (const std::uint64_t seed : seeds) {
      CAPTURE(int(kind));
      CAPTURE(seed);
      const World world = make_world(kind, seed);
      World changed = world;
      change(changed, seed);
      for_each_renderer([&](AnyRenderer& renderer) {
        const Frame before = render(renderer, world);
        CHECK(covered(before) > 200);
        CHECK(same_planes(render(renderer, changed), expected(before)));
      });
    }
}

const auto unchanged = [](const Frame& image) { return image; };

TEST_CASE(SWIFTGS_METAMORPHIC ": a world times a power of two has the same image and scaled depths") {
  for (const int power : {-20, -1, 1, 3, 20}) {
    CAPTURE(power);
    const float factor = std::ldexp(1.0f, power);
    check_all(
        [&](World& world, std::uint64_t) {
          for (vec3& mean : world.scene.means) mean *= factor;
          for (vec3& scale : world.scene.scales) scale *= factor;
          world.camera.translation *= double(factor);
          world.conventions.near_plane *= factor, world.conventions.far_plane *= factor;
        },
        [&](Frame image) {
          for_each_plane(
              [&]<class T>(std::size_t, std::vector<T>& values, const PlaneRow& row) {
                for (T& value : values) value = T(std::ldexp(value, power * row.length_power));
              },
              image, plane_table);
          return image;
        });
  }
}

TEST_CASE(SWIFTGS_METAMORPHIC ": the order of Gaussians of distinct depths does not matter") {
  check_all(
      [](World& world, std::uint64_t seed) {
        std::vector<std::uint32_t> order(world.scene.size());
        Random random(seed + 50);
        for (std::uint32_t i = 0; i < order.size(); ++i) {
          order[i] = i;
          std::swap(order[i], order[random.bits() % (i + 1)]);
        }
        world.scene = subset(world.scene, order), world.before_change = order;
      },
      unchanged);
}

TEST_CASE(SWIFTGS_METAMORPHIC ": a rotation and its negative are the same") {
  check_all(
      [](World& world, std::uint64_t) {
        for (Quaternion& q : world.scene.rotations) q = {-q.w, -q.x, -q.y, -q.z};
      },
      unchanged);
}

TEST_CASE(SWIFTGS_METAMORPHIC ": Gaussians that are culled change nothing") {
  check_all(
      [](World& world, std::uint64_t seed) {
        // Put up to three copies of each Gaussian before it: transparent, behind the camera, beside the
        // image.
        Random random(seed + 60);
        const Scene original = world.scene;
        std::vector<std::uint32_t> order;
        std::vector<bool> culled;
        for (std::uint32_t i = 0; i < original.size(); ++i)
          for (std::size_t copies = random.bits() % 4 + 1; copies > 0; --copies)
            order.push_back(i), culled.push_back(copies > 1);
        world.scene = subset(original, order), world.before_change = order;
        const dvec3 eye = world.camera.centre();
        for (std::size_t n = 0; n < order.size(); ++n) {
          if (!culled[n]) continue;
          const auto place = [&](dvec3 p) {  // in camera space
            const dvec3 offset = p * world.camera.rotation;
            world.scene.means[n] = vec3(eye + offset), world.scene.scales[n] = vec3(0.01f, 0.1f, 0.05f);
          };
          if (n % 3 == 0) world.scene.opacities[n] = 0;
          if (n % 3 == 1) place({random.in(-1, 1), random.in(-1, 1), random.in(-9, -0.1)});
          if (n % 3 == 2) place({random.in(20, 40) * (n % 2 ? 1 : -1), random.in(-9, 9), random.in(2, 4)});
        }
      },
      unchanged);
}

TEST_CASE(SWIFTGS_METAMORPHIC ": a smaller image is the corner of a larger one") {
  if (unavailable()) return;
  const auto corner = [](const Frame& image, int from, int width, int height) {
    Frame out;
    out.feature_channels = image.feature_channels;
    for_each_plane(
        [&](std::size_t channels, const auto& whole, auto& part) {
          for (int y = 0; y < height; ++y) {
            const auto row = whole.begin() + std::ptrdiff_t(channels) * y * from;
            part.insert(part.end(), row, row + std::ptrdiff_t(channels) * width);
          }
        },
        image, out);
    return out;
  };
  for (const Kind kind : {Kind::ordinary, Kind::needles})
    for (const std::uint64_t seed : seeds) {
      CAPTURE(int(kind));
      CAPTURE(seed);
      World world = make_world(kind, seed);
      // Limits of the projection depend on the size of the image: keep means inside those of each corner.
      world.camera.cx = world.camera.cy = 21;
      Random random(seed + 70);
      for (vec3& mean : world.scene.means) {
        const double z = random.in(0.5, 9);
        const dvec3 p(random.in(-19, 15) / world.camera.fx * z, random.in(-19, 8) / world.camera.fy * z, z);
        mean = vec3(world.camera.centre() + p * world.camera.rotation);
      }
      for_each_renderer([&](AnyRenderer& renderer) {
        const Frame whole = render(renderer, world);
        CHECK(covered(whole) > 200);
        World part = world;
        constexpr std::pair<int, int> sizes[] = {{82, 49}, {64, 48}, {63, 33}, {49, 32}, {41, 31}};
        for (const auto& size : sizes) {
          const int width = size.first, height = size.second;
          CAPTURE(width);
          part.camera.width = width, part.camera.height = height;
          CHECK(same_planes(render(renderer, part), corner(whole, 83, width, height)));
        }
      });
    }
}

}  // namespace
}  // namespace swiftgs::test
