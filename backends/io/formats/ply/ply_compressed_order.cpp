// SPDX-License-Identifier: Apache-2.0
#include "ply_compressed_order.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <swiftgs/bulk.hpp>
#include <swiftgs/edit/order.hpp>

#include "ply_compressed.hpp"
#include "scene_building.hpp"

namespace swiftgs::io {
namespace {

using Indices = std::vector<std::uint32_t>;

/// Takes those that stray out of `order` and keeps the order of both. Takes nothing if less than a chunk
/// would be left.
template <class Strays>
Indices take_out(Indices& order, const Strays& strays) {
  const auto count = std::size_t(std::count_if(order.begin(), order.end(), strays));
  if (count == 0 || order.size() - count < chunk_size) return {};
  Indices taken;
  std::erase_if(order, [&](std::uint32_t i) {
    if (strays(i)) taken.push_back(i);
    return strays(i);
  });
  return taken;
}

/// Appends a part that shares no chunk with what follows or precedes it.
void append(std::vector<ChunkRow>& rows, const Indices& part) {
  if (part.empty()) return;
  while (rows.size() % chunk_size != 0) rows.push_back({rows.back().gaussian, true});
  for (const std::uint32_t i : part) rows.push_back({i, false});
}

}  // namespace

vec3 colour_of(const Scene& scene, std::size_t i) { return vec3(dvec3(scene.sh0[i]) * sh_c0 + 0.5); }

std::vector<ChunkRow> order_in_chunks(const Scene& scene) {
  constexpr float extreme = 8;  // a colour that leaves its neighbours less than 32 steps from black to white
  std::vector<ChunkRow> rows;
  Indices order = spatial_order(scene);
  while (!order.empty()) {
    const swiftgs::detail::Bulk bulk(order.size(), [&](std::size_t k) { return scene.means[order[k]]; });
    Indices rest = take_out(order, [&](std::uint32_t i) { return !bulk.has(scene.means[i]); });
    const Indices coloured = take_out(order, [&](std::uint32_t i) {
      const vec3 from_grey = glm::abs(colour_of(scene, i) - 0.5f);
      return std::max({from_grey.x, from_grey.y, from_grey.z}) > extreme;
    });
    append(rows, order), append(rows, coloured);
    swiftgs::detail::sort_spatially(scene, rest);
    order = std::move(rest);
  }
  return rows;
}

}  // namespace swiftgs::io
