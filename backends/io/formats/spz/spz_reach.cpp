// SPDX-License-Identifier: Apache-2.0
#include "spz_reach.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <swiftgs/bulk.hpp>

namespace swiftgs::io {
namespace {

double distance_of(const vec3& mean) {
  return double(std::max({std::abs(mean.x), std::abs(mean.y), std::abs(mean.z)}));
}

/// The most bits, up to `most`, with which a coordinate is at most `steps` steps from zero.
int bits_for(double coordinate, double steps, int most) {
  int bits = most;
  while (bits > 0 && std::ldexp(coordinate, bits) > steps) --bits;
  return bits;
}

int bits_of_scene(double farthest) {
  const int fine = bits_for(farthest, 1 << 15, 24);
  return fine >= 12 ? fine : bits_for(farthest, std::nextafter(spz_largest_position + 0.5, 0), 12);
}

}  // namespace

double SpzReach::largest() const { return std::ldexp(spz_largest_position, -fractional_bits); }

SpzReach reach_of(const Scene& scene) {
  double farthest = 0, farthest_of_bulk = 0;
  const swiftgs::detail::Bulk bulk(scene.size(), [&](std::size_t i) { return scene.means[i]; });
  std::vector<std::uint32_t> strays;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const double distance = distance_of(scene.means[i]);
    farthest = std::max(farthest, distance);
    if (bulk.has(scene.means[i]))
      farthest_of_bulk = std::max(farthest_of_bulk, distance);
    else
      strays.push_back(std::uint32_t(i));
  }
  SpzReach reach{.fractional_bits = bits_of_scene(farthest), .middle = bulk.centre()};
  if (strays.size() > scene.size() / 500) return reach;
  const int wanted = bits_of_scene(farthest_of_bulk);
  if (reach.fractional_bits >= std::min(wanted, bits_for(farthest_of_bulk, 1 << 17, 24))) return reach;
  reach.fractional_bits = wanted;
  std::erase_if(strays, [&](std::uint32_t i) { return distance_of(scene.means[i]) <= reach.largest(); });
  reach.beyond = std::move(strays);
  return reach;
}

Scene drawn_in(Scene scene, const SpzReach& reach) {
  const double largest = reach.largest();
  for (const std::uint32_t i : reach.beyond) {
    const dvec3 away = dvec3(scene.means[i]) - reach.middle;
    double part = 1;
    for (int axis = 0; axis < 3; ++axis)
      if (away[axis] != 0)
        part = std::min(part, (std::copysign(largest, away[axis]) - reach.middle[axis]) / away[axis]);
    scene.means[i] = vec3(glm::clamp(reach.middle + part * away, -largest, largest));
    scene.scales[i] = vec3(part * dvec3(scene.scales[i]));
  }
  return scene;
}

}  // namespace swiftgs::io
