// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>

#include "policies/random_splats.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {
using Indices = std::vector<std::uint32_t>;

Indices sorted(Indices indices) {
  std::sort(indices.begin(), indices.end());
  return indices;
}
Indices all(std::size_t count) {
  Indices indices(count);
  std::iota(indices.begin(), indices.end(), 0u);
  return indices;
}

/// Median diagonal of the boxes around 128 Gaussians each.
double median_diagonal(const Scene& scene) {
  std::vector<double> diagonals;
  for (std::size_t begin = 0; begin + 128 <= scene.size(); begin += 128) {
    vec3 low = scene.means[begin], high = low;
    for (std::size_t i = begin; i < begin + 128; ++i)
      low = glm::min(low, scene.means[i]), high = glm::max(high, scene.means[i]);
    diagonals.push_back(double(glm::length(high - low)));
  }
  std::nth_element(diagonals.begin(), diagonals.begin() + std::ptrdiff_t(diagonals.size() / 2),
                   diagonals.end());
  return diagonals[diagonals.size() / 2];
}
}  // namespace

// Morton's curve.
TEST_CASE("edit: spatial order compares all bits of cells from the highest on and x before y before z") {
  // Cells are whole numbers here. Half of them differ from another in one bit alone.
  constexpr std::uint32_t last = (1u << 21) - 1;
  Random random(4);
  std::vector<std::array<std::uint32_t, 3>> cells = {{0, 0, 0}, {last, last, last}};
  while (cells.size() < 400) {
    std::array<std::uint32_t, 3> cell;
    for (std::uint32_t& number : cell) number = std::uint32_t(random.bits()) & last;
    cells.push_back(cell);
    cell[random.bits() % 3] ^= 1u << random.bits() % 21;
    cells.push_back(cell);
  }
  Scene scene = random_scene(cells.size(), 0, 3);
  for (std::size_t i = 0; i < cells.size(); ++i)
    scene.means[i] = vec3(float(cells[i][0]), float(cells[i][1]), float(cells[i][2]));
  Indices expected = all(cells.size());
  std::stable_sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) {
    for (std::uint32_t bit = 1u << 20; bit != 0; bit >>= 1)
      for (std::size_t axis = 0; axis < 3; ++axis)
        if ((cells[a][axis] & bit) != (cells[b][axis] & bit)) return (cells[b][axis] & bit) != 0;
    return false;
  });
  CHECK(spatial_order(scene) == expected);
}

TEST_CASE("edit: spatial order has every Gaussian once, and keeps neighbours together") {
  const Scene scene = make_builtin_scene(50'000);
  CHECK(sorted(spatial_order(scene)) == all(scene.size()));
  Indices shuffled = all(scene.size());
  Random random(1);
  for (std::size_t i = shuffled.size(); i-- > 1;) std::swap(shuffled[i], shuffled[random.bits() % (i + 1)]);
  const Scene mixed = subset(scene, shuffled);
  CHECK(median_diagonal(order_spatially(mixed)) < 0.05 * median_diagonal(mixed));
}

TEST_CASE("edit: a few Gaussians far away leave the others in order") {
  Scene scene = make_builtin_scene(20'000);
  const double usual = median_diagonal(order_spatially(scene));
  scene.means[77] = vec3(1e30f, 0, 0), scene.means[78] = vec3(0, -3e38f, 1);
  CHECK(median_diagonal(order_spatially(scene)) < 1.05 * usual);
}

TEST_CASE("edit: strays come last, ordered among themselves, and leave the others in order") {
  Scene scene = make_builtin_scene(600);
  const Scene plain = scene;
  const Indices strays = {5, 77, 78, 400};
  scene.means[5] = vec3(1e9f, 0, 0), scene.means[77] = vec3(1e9f, 2, 0);
  scene.means[78] = vec3(-1e9f, 1, 0), scene.means[400] = vec3(1e9f, 1, 0);
  const Indices order = spatial_order(scene);
  CHECK(sorted(order) == all(scene.size()));
  CHECK(sorted({order.end() - 4, order.end()}) == strays);
  CHECK(order[596] == 78);
  scene = subset(scene, order);
  CHECK(median_diagonal(scene) < 1.5 * median_diagonal(order_spatially(plain)));
}

TEST_CASE("edit: equal means keep their order, and means that are not finite come last") {
  Scene scene = random_scene(6, 0, 2);
  std::fill(scene.means.begin(), scene.means.end(), vec3(1, 2, 3));
  CHECK(spatial_order(scene) == all(6));
  scene.means[0].x = std::numeric_limits<float>::quiet_NaN();
  scene.means[3].z = std::numeric_limits<float>::infinity();
  CHECK(spatial_order(scene) == Indices{1, 2, 4, 5, 0, 3});
  for (vec3& mean : scene.means) mean.y = std::numeric_limits<float>::infinity();
  CHECK(spatial_order(scene) == all(6));
  CHECK(spatial_order(Scene()).empty());
}
