// SPDX-License-Identifier: Apache-2.0
#include "ply_compressed_order.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>

#include <swiftgs/bulk.hpp>
#include <swiftgs/edit/order.hpp>

#include "ply_compressed.hpp"
#include "scene_building.hpp"

namespace swiftgs::io {
namespace {

using Indices = std::vector<std::uint32_t>;

/// Opacity times the area of the largest shadow.
double visibility(const Scene& scene, std::size_t i) {
  const dvec3 s(scene.scales[i]);
  return double(scene.opacities[i]) * std::max({s.x * s.y, s.x * s.z, s.y * s.z});
}

/// Takes those that stray out of `order`, and the least visible others that leave whole chunks. Keeps the
/// order of both. Takes nothing if less than a chunk would be left.
template <class Strays>
Indices take_out(const Scene& scene, Indices& order, const Strays& strays) {
  const auto count = std::size_t(std::count_if(order.begin(), order.end(), strays));
  if (count == 0 || order.size() - count < chunk_size) return {};
  std::vector<std::pair<double, std::uint32_t>> keys;  // what is least is taken
  keys.reserve(order.size());
  for (const std::uint32_t i : order) keys.emplace_back(strays(i) ? -1 : visibility(scene, i), i);
  const auto taken = std::ptrdiff_t(count + (order.size() - count) % chunk_size);
  std::nth_element(keys.begin(), keys.begin() + taken - 1, keys.end());
  const auto last = keys[std::size_t(taken - 1)];
  Indices rest;
  std::erase_if(order, [&](std::uint32_t i) {
    const bool take = strays(i) || std::pair(visibility(scene, i), i) <= last;
    if (take) rest.push_back(i);
    return take;
  });
  return rest;
}

}  // namespace

vec3 colour_of(const Scene& scene, std::size_t i) { return vec3(dvec3(scene.sh0[i]) * sh_c0 + 0.5); }

Indices order_in_chunks(const Scene& scene) {
  constexpr float extreme = 8;  // a colour that leaves its neighbours less than 32 steps from black to white
  Indices result, order = spatial_order(scene);
  while (!order.empty()) {
    const swiftgs::detail::Bulk bulk(order.size(), [&](std::size_t k) { return scene.means[order[k]]; });
    Indices rest = take_out(scene, order, [&](std::uint32_t i) { return !bulk.has(scene.means[i]); });
    const Indices coloured = take_out(scene, order, [&](std::uint32_t i) {
      const vec3 from_grey = glm::abs(colour_of(scene, i) - 0.5f);
      return std::max({from_grey.x, from_grey.y, from_grey.z}) > extreme;
    });
    for (const Indices& part : {std::cref(order), std::cref(coloured)})
      result.insert(result.end(), part.begin(), part.end());
    swiftgs::detail::sort_spatially(scene, rest);
    order = std::move(rest);
  }
  return result;
}

}  // namespace swiftgs::io
