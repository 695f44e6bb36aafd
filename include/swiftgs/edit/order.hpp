// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

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
}  // namespace detail

/// Indices of all Gaussians in Morton order of their means; @shape{N}. Neighbours in it are mostly neighbours
/// in space. Cells are cubes, 2^21 along the longest side of a box with 99.8 % of the means in each
/// direction; the few beyond it count as at its border. Equal cells keep their order. Means that are not
/// finite come last. Takes O(n log n). Throws `std::invalid_argument` as `validate` does, and `CapacityError`
/// beyond 2^32 - 1 Gaussians.
inline std::vector<std::uint32_t> spatial_order(const Scene& scene) {
  std::vector<std::uint32_t> order =
      select(scene, [&](std::size_t i) { return detail::is_finite(scene.means[i]); });
  if (order.empty()) return select(scene, [](std::size_t) { return true; });
  const std::size_t count = order.size(), beyond = count / 1000;

  dvec3 low(0.0);
  double longest = 0;
  std::vector<float> values(count);
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(order.begin(), order.end(), values.begin(), [&](auto i) { return scene.means[i][axis]; });
    const auto nth = [&](std::size_t n) {
      std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(n), values.end());
      return double(values[n]);
    };
    low[axis] = nth(beyond);
    longest = std::max(longest, nth(count - 1 - beyond) - low[axis]);
  }
  const double most = (1 << 21) - 1, cells = longest > 0 ? most / longest : 0;

  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  keys.reserve(scene.size());
  for (const std::uint32_t i : order) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = std::clamp((double(scene.means[i][axis]) - low[axis]) * cells, 0.0, most);
      key |= detail::spread_bits(std::uint64_t(cell)) << (2 - axis);
    }
    keys.emplace_back(key, i);
  }
  std::sort(keys.begin(), keys.end());
  std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& key) { return key.second; });
  const auto last = select(scene, [&](std::size_t i) { return !detail::is_finite(scene.means[i]); });
  std::copy(last.begin(), last.end(), std::back_inserter(order));
  return order;
}

/// The scene in `spatial_order`, for stages that gain where neighbours in memory are neighbours in space. The
/// numbers of its Gaussians are new, and with them the order of Gaussians at equal depths. Throws and takes
/// time as `spatial_order`.
inline Scene order_spatially(const Scene& scene) { return subset(scene, spatial_order(scene)); }

}  // namespace swiftgs
