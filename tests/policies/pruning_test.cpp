// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/contribution.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/pruning.hpp>

#include "policies/backends.hpp"
#include "policies/random_splats.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {
using Indices = std::vector<std::uint32_t>;
}  // namespace

TEST_CASE("pruning: the highest scores are kept in the order of the scene") {
  CHECK(highest(std::vector<double>{3, 1, 4, 1, 5}, 3) == Indices{0, 2, 4});
  CHECK(highest(std::vector<double>{3, 1, 4}, 3) == Indices{0, 1, 2});
  CHECK(highest(std::vector<double>{3, 1, 4}, 0) == Indices{});
  CHECK(highest(std::vector<double>{}, 0) == Indices{});
  CHECK_THROWS_AS(highest(std::vector<double>{1}, 2), std::invalid_argument);
}

TEST_CASE("pruning: of equal scores the lower index is kept") {
  CHECK(highest(std::vector<std::uint64_t>{7, 7, 9, 7, 7}, 3) == Indices{0, 1, 2});
  CHECK(highest(std::vector<std::uint64_t>(1000, 0), 400).back() == 399);
  // Scores that doubles could not tell apart.
  const std::uint64_t large = std::uint64_t(1) << 60;
  CHECK(highest(std::vector<std::uint64_t>{large, large + 1}, 1) == Indices{1});
}

TEST_CASE("pruning: a fraction is rounded to at least one Gaussian") {
  CHECK(kept_count(0.1, 1000) == 100);
  CHECK(kept_count(1, 7) == 7);
  CHECK(kept_count(0.26, 10) == 3);
  CHECK(kept_count(1e-9, 10) == 1);
  CHECK(kept_count(0.5, 0) == 0);
  for (const double fraction : {0.0, -0.5, 1.5, double(NAN), double(INFINITY)})
    CHECK_THROWS_AS(kept_count(fraction, 10), std::invalid_argument);
}

TEST_CASE("pruning: opacity times volume") {
  Scene scene = random_scene(1, 0, 3);
  scene.opacities[0] = 0.5f, scene.scales[0] = vec3(2, 4, 0.25f);
  CHECK(opacity_volumes(scene) == std::vector<double>{1});
  CHECK(opacity_volumes(Scene()).empty());
}

TEST_CASE("pruning: by contribution the built-in scene stays closer to itself than by opacity and volume") {
  const auto scene = std::make_shared<const Scene>(make_builtin_scene(20'000));
  const std::vector<Camera> views = builtin_cameras(8, 256, 144);
  Contributions<Cpu> contributions(scene);
  for (std::size_t i = 1; i < views.size(); ++i) contributions.add(views[i], Conventions::gsplat());

  Renderer<Cpu, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer;
  const auto frame_of = [&](Scene of) {
    return renderer.render(renderer.backend().upload(std::move(of)), views[0]).colour;
  };
  const std::vector<float> original = frame_of(*scene);
  const std::size_t kept = kept_count(0.3, scene->size());
  const double by_contribution =
      psnr(frame_of(subset(*scene, highest(contributions.sums(), kept))), original);
  const double by_volume = psnr(frame_of(subset(*scene, highest(opacity_volumes(*scene), kept))), original);
  CHECK(by_contribution > by_volume + 3);
}
