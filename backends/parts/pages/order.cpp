// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>
#include <vector>

#include <swiftgs/tools/parallel.hpp>

#include "nodes.hpp"

namespace swiftgs::pages {

int longest_axis(std::vector<vec3> means) {
  const std::size_t outside = means.size() / 20;
  int longest = 0;
  float length = -1;
  for (int axis = 0; axis < 3; ++axis) {
    std::sort(means.begin(), means.end(), [axis](const vec3& a, const vec3& b) { return a[axis] < b[axis]; });
    const float found = means[means.size() - 1 - outside][axis] - means[outside][axis];
    if (found > length) length = found, longest = axis;
  }
  return longest;
}

void order_by_halves(const std::vector<vec3>& means, std::span<std::uint32_t> order, std::size_t page,
                     std::size_t least, int threads) {
  const std::size_t unit = order.size() > page ? page : least;
  if (order.size() <= unit) return;
  const std::size_t units = (order.size() + unit - 1) / unit, left = (units + 1) / 2 * unit;
  constexpr std::size_t samples = 101;  // which tell well enough
  std::vector<vec3> some;
  for (std::size_t k = 0; k < order.size(); k += order.size() / samples + 1) some.push_back(means[order[k]]);
  const int axis = longest_axis(std::move(some));
  std::nth_element(order.begin(), order.begin() + std::ptrdiff_t(left), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     const float x = means[a][axis], y = means[b][axis];
                     return x != y ? x < y : a < b;
                   });
  const auto order_half = [&](std::size_t half) {
    const auto of_half = half == 0 ? order.first(left) : order.subspan(left);
    order_by_halves(means, of_half, page, least, half == 0 ? (threads + 1) / 2 : std::max(1, threads / 2));
  };
  constexpr std::size_t worth_a_thread = 8192;
  for_each_index(2, order.size() < worth_a_thread ? 1 : std::min(threads, 2), order_half);
}

}  // namespace swiftgs::pages
