// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "nodes.hpp"

namespace swiftgs::pages {
namespace {

/// The axis along which most of some means spread farthest. A few samples tell; the outermost do not count,
/// so that strays do not decide.
int longest_axis(const std::vector<vec3>& means, std::span<const std::uint32_t> some) {
  constexpr std::size_t samples = 101;
  const std::size_t step = some.size() / samples + 1;
  int longest = 0;
  float length = -1;
  std::vector<float> values;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (std::size_t k = 0; k < some.size(); k += step) values.push_back(means[some[k]][axis]);
    std::sort(values.begin(), values.end());
    const std::size_t outside = values.size() / 20;
    const float found = values[values.size() - 1 - outside] - values[outside];
    if (found > length) length = found, longest = axis;
  }
  return longest;
}

}  // namespace

void order_by_halves(const std::vector<vec3>& means, std::span<std::uint32_t> order, std::size_t page,
                     std::size_t least) {
  const std::size_t unit = order.size() > page ? page : least;
  if (order.size() <= unit) return;
  const std::size_t units = (order.size() + unit - 1) / unit, left = (units + 1) / 2 * unit;
  const int axis = longest_axis(means, order);
  std::nth_element(order.begin(), order.begin() + std::ptrdiff_t(left), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     const float x = means[a][axis], y = means[b][axis];
                     return x != y ? x < y : a < b;
                   });
  order_by_halves(means, order.first(left), page, least);
  order_by_halves(means, order.subspan(left), page, least);
}

}  // namespace swiftgs::pages
