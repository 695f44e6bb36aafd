// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "sog_pixels.hpp"
#include "tasks.hpp"

namespace swiftgs::io {
namespace {

using Row = std::array<double, most_width>;
using MovableIds = std::span<std::uint32_t>;

struct Group {
  std::uint32_t begin = 0, end = 0;
  double spread = 0;  ///< sum of squared distances to the mean; 0 if the points are as good as equal
};

/// A hyperplane: points whose dot product with `normal` exceeds `offset` lie beyond it.
struct Plane {
  std::array<float, most_width> normal{};
  float offset = 0;
};

/// Some points on one side of a plane.
struct Side {
  Sums sums{};
  std::size_t count = 0;

  Row mean() const {
    Row result = sums.first;
    for (double& value : result) value /= double(count);
    return result;
  }

  double spread() const {
    double spread = sums.second;
    for (const double sum : sums.first) spread -= sum * sum / double(count);
    return spread > 1e-12 * sums.second ? spread : 0;
  }
};

Side side_of(const Points& points, MovableIds ids) {
  Side side{.count = ids.size()};
  add_up(points, ids, side.sums);
  return side;
}

/// Half-way between two points.
Plane between(const Row& a, const Row& b) {
  Plane plane;
  double offset = 0;
  for (std::size_t k = 0; k < most_width; ++k) {
    plane.normal[k] = float(b[k] - a[k]);
    offset += double(plane.normal[k]) * (a[k] + b[k]) / 2;
  }
  plane.offset = float(offset);
  return plane;
}

/// Between the mean and the point farthest from it, which separates any points that are not all equal.
Plane from_farthest(const Points& points, MovableIds ids, const Row& mean) {
  double most = -1;
  Row farthest{};
  for (const std::uint32_t id : ids) {
    double squared = 0;
    for (std::size_t k = 0; k < points.width; ++k) {
      const double apart = points[id][k] - mean[k];
      squared += apart * apart;
    }
    if (squared <= most) continue;
    most = squared;
    std::copy_n(points[id], points.width, farthest.begin());
  }
  return between(mean, farthest);
}

/// Through the mean, across the direction in which the points differ most, which a few steps of the power
/// method find. Starts from `plane`.
Plane across_spread(const Points& points, MovableIds ids, const Row& mean, Plane plane) {
  constexpr int steps = 2;
  std::vector<float> weights(ids.size());
  for (int step = 0; step < steps; ++step) {
    double offset = 0, all = 0, squares = 0;
    for (std::size_t k = 0; k < points.width; ++k) offset += double(plane.normal[k]) * mean[k];
    project(points, ids, plane.normal.data(), weights.data());
    for (float& weight : weights) {
      weight -= float(offset);
      all += weight;
    }
    Row direction{};
    add_weighted(points, ids, weights.data(), direction);
    for (std::size_t k = 0; k < points.width; ++k) {
      direction[k] -= all * mean[k];
      squares += direction[k] * direction[k];
    }
    if (!(squares > 0)) break;
    plane.offset = 0;
    for (std::size_t k = 0; k < points.width; ++k) {
      plane.normal[k] = float(direction[k] / std::sqrt(squares));
      plane.offset += plane.normal[k] * float(mean[k]);
    }
  }
  return plane;
}

/// Orders `ids` so that those beyond the plane come last.
std::array<Side, 2> part(const Points& points, MovableIds ids, const Plane& plane) {
  constexpr std::size_t at_once = 256;  // which stay in the cache from projecting to adding up
  std::array<float, at_once> products;
  std::vector<std::uint32_t> beyond;
  std::array<Side, 2> sides;
  const auto add = [&](Side& side, MovableIds to) {
    add_up(points, to, side.sums);
    side.count += to.size();
  };
  std::size_t before = 0;
  for (std::size_t begin = 0; begin < ids.size(); begin += at_once) {
    const MovableIds some = ids.subspan(begin, std::min(at_once, ids.size() - begin));
    project(points, some, plane.normal.data(), products.data());
    const std::size_t old_before = before, old_beyond = beyond.size();
    for (std::size_t i = 0; i < some.size(); ++i) {
      if (products[i] > plane.offset)
        beyond.push_back(some[i]);
      else
        ids[before++] = some[i];
    }
    add(sides[0], ids.subspan(old_before, before - old_before));
    add(sides[1], MovableIds(beyond).subspan(old_beyond));
  }
  std::copy(beyond.begin(), beyond.end(), ids.begin() + std::ptrdiff_t(before));
  return sides;
}

bool is_parted(const std::array<Side, 2>& sides) { return sides[0].count > 0 && sides[1].count > 0; }

/// A plane between two halves of few points: 2-means.
Plane between_halves(const Points& points, MovableIds ids) {
  constexpr int steps = 4;
  const Row mean = side_of(points, ids).mean();
  Plane plane = across_spread(points, ids, mean, from_farthest(points, ids, mean));
  for (int step = 0; step < steps; ++step) {
    const std::array<Side, 2> sides = part(points, ids, plane);
    if (!is_parted(sides)) break;
    plane = between(sides[0].mean(), sides[1].mean());
  }
  return plane;
}

/// Makes two groups of `group`; leaves it alone, with a spread of 0, if its points are as good as equal.
/// Returns the other.
Group split(const Points& points, std::vector<std::uint32_t>& order, Group& group) {
  constexpr std::size_t most_sampled = 256;
  const MovableIds ids(order.data() + group.begin, group.end - group.begin);
  std::vector<std::uint32_t> sample(std::min(most_sampled, ids.size()));
  for (std::size_t i = 0; i < sample.size(); ++i) sample[i] = ids[i * ids.size() / sample.size()];
  std::array<Side, 2> sides = part(points, ids, between_halves(points, sample));
  if (!is_parted(sides)) sides = part(points, ids, from_farthest(points, ids, side_of(points, ids).mean()));
  Group other;
  if (!is_parted(sides)) {
    group.spread = 0;
    return other;
  }
  other.end = group.end;
  other.begin = group.end = group.begin + std::uint32_t(sides[0].count);
  group.spread = sides[0].spread();
  other.spread = sides[1].spread();
  return other;
}

}  // namespace

Grouping split_points(const Points& points, std::size_t most, const ProgressMeter& progress) {
  Grouping result;
  result.order.resize(points.count);
  for (std::size_t i = 0; i < points.count; ++i) result.order[i] = std::uint32_t(i);
  std::vector<Group> groups(1);
  groups[0].end = std::uint32_t(points.count);
  groups[0].spread = side_of(points, result.order).spread();

  // In rounds of many groups, so that threads work at once and do not change the result.
  const auto widest_first = [](const Group& a, const Group& b) {
    return a.spread > b.spread || (a.spread == b.spread && a.begin < b.begin);
  };
  while (groups.size() < most && groups[0].spread > 0) {
    std::size_t count = 0;
    while (count < std::min(groups.size(), most - groups.size()) &&
           groups[count].spread > groups[0].spread / 2)
      ++count;
    std::vector<Group> others(count);
    const double share = 1.0 / double(most);
    const ProgressMeter step =
        progress.step(double(groups.size()) * share, double(groups.size() + count) * share);
    for_tasks(count, step,
              [&](std::size_t i, const Stopping&) { others[i] = split(points, result.order, groups[i]); });
    std::copy_if(others.begin(), others.end(), std::back_inserter(groups),
                 [](const Group& other) { return other.end > other.begin; });
    std::sort(groups.begin(), groups.end(), widest_first);
  }
  std::sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) { return a.begin < b.begin; });
  for (const Group& group : groups) result.begins.push_back(group.begin);
  result.begins.push_back(std::uint32_t(points.count));
  return result;
}

}  // namespace swiftgs::io
