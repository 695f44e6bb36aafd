// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <swiftgs/edit/origin.hpp>
#include <swiftgs/edit/select.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

namespace detail {
/// Each bit of the low 21 followed by two zeros.
inline std::uint64_t spread_bits(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x001f00000000ffff;
  v = (v | v << 16) & 0x001f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  return (v | v << 2) & 0x1249249249249249;
}

/// Puts `order`, some Gaussians of finite means, in Morton order; strays come last, in an order of their own.
inline void sort_spatially(const Scene& scene, std::span<std::uint32_t> order) {
  if (order.empty()) return;
  const auto mean = [&](std::size_t k) { return scene.means[order[k]]; };
  const Bulk bulk(order.size(), mean);
  const std::size_t beyond = order.size() / 1000;
  dvec3 low(0.0);
  double longest = 0;
  std::vector<float> values(order.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = mean(k)[axis];
    const auto nth = [&](std::size_t n) {
      std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(n), values.end());
      return double(values[n]);
    };
    low[axis] = std::max(bulk.low()[axis], nth(beyond));
    longest = std::max(longest, std::min(bulk.high()[axis], nth(values.size() - 1 - beyond)) - low[axis]);
  }
  const double most = (1 << 21) - 1, cells = longest > 0 ? most / longest : 0;

  constexpr std::uint64_t stray = std::uint64_t(1) << 63;  // above the bits of cells
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  keys.reserve(order.size());
  for (const std::uint32_t i : order) {
    std::uint64_t key = bulk.has(scene.means[i]) ? 0 : stray;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = std::clamp((double(scene.means[i][axis]) - low[axis]) * cells, 0.0, most);
      key |= spread_bits(std::uint64_t(cell)) << (2 - axis);
    }
    keys.emplace_back(key, i);
  }
  std::sort(keys.begin(), keys.end());
  std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& key) { return key.second; });
  const auto strays =
      std::partition_point(keys.begin(), keys.end(), [](const auto& key) { return key.first < stray; });
  sort_spatially(scene, order.subspan(std::size_t(strays - keys.begin())));
}
}  // namespace detail

/// Indices of all Gaussians in Morton order of their means; @shape{N}. Neighbours in it are mostly neighbours
/// in space. Cells are cubes, 2^21 along the longest side of a box with 99.8 % of the means in each
/// direction; the few beyond it count as at its border. Equal cells keep their order. Gaussians that stray
/// far from all others come after them, ordered among themselves, and means that are not finite come last.
/// Takes O(n log n). Throws `InvalidArgument` as `validate` does, and `CapacityError` beyond 2^32 - 1
/// Gaussians.
inline std::vector<std::uint32_t> spatial_order(const Scene& scene) {
  std::vector<std::uint32_t> order =
      select(scene, [&](std::size_t i) { return detail::is_finite(scene.means[i]); });
  detail::sort_spatially(scene, order);
  const auto last = select(scene, [&](std::size_t i) { return !detail::is_finite(scene.means[i]); });
  order.insert(order.end(), last.begin(), last.end());
  return order;
}

/// The scene in `spatial_order`, for stages that gain where neighbours in memory are neighbours in space. The
/// numbers of its Gaussians are new, and with them the order of Gaussians at equal depths. Throws and takes
/// time as `spatial_order`.
inline Scene order_spatially(const Scene& scene) { return subset(scene, spatial_order(scene)); }

}  // namespace swiftgs
