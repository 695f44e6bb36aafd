// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <span>
#include <utility>

#include "sog_pixels.hpp"
#include "tasks.hpp"

namespace swiftgs::io {
namespace {

using Ids = std::span<const std::uint32_t>;

Ids members(const Grouping& groups, std::size_t group) {
  return Ids(groups.order).subspan(groups.begins[group], groups.begins[group + 1] - groups.begins[group]);
}

/// Calls `body(group)` for all groups, several to a task.
template <class Body>
void for_groups(std::size_t count, const ProgressMeter& progress, const Body& body) {
  constexpr std::size_t each = 64;
  for_tasks((count + each - 1) / each, progress, [&](std::size_t task, const Stopping&) {
    for (std::size_t group = task * each; group < std::min(count, (task + 1) * each); ++group) body(group);
  });
}

/// The points of each label, ascending.
Grouping by_label(const std::vector<std::uint32_t>& labels, std::size_t count) {
  Grouping groups;
  groups.begins.resize(count + 1);
  groups.order.resize(labels.size());
  for (const std::uint32_t label : labels) ++groups.begins[label + 1];
  for (std::size_t i = 0; i < count; ++i) groups.begins[i + 1] += groups.begins[i];
  std::vector<std::uint32_t> next(groups.begins.begin(), groups.begins.end() - 1);
  for (std::size_t i = 0; i < labels.size(); ++i) groups.order[next[labels[i]]++] = std::uint32_t(i);
  return groups;
}

/// Makes `means` those of the groups, in order of the points. A group without points keeps its own.
void update_means(const Points& points, const Grouping& groups, std::vector<float>& means,
                  const ProgressMeter& progress) {
  means.resize(groups.size() * points.width);
  for_groups(groups.size(), progress, [&](std::size_t group) {
    const Ids ids = members(groups, group);
    if (ids.empty()) return;
    std::array<double, most_width> sum{};
    for (const std::uint32_t id : ids)
      for (std::size_t k = 0; k < points.width; ++k) sum[k] += points[id][k];
    for (std::size_t k = 0; k < points.width; ++k)
      means[group * points.width + k] = float(sum[k] / double(ids.size()));
  });
}

/// For each colour some of those nearest to it, itself included, ascending.
class Neighbours {
 public:
  Neighbours(const Points& colours, const ProgressMeter& progress)
      : each_(std::min(most_neighbours, colours.count)), ids_(each_ * colours.count) {
    for (std::size_t begin = 0; begin <= colours.count; begin += block)
      blocks_.begins.push_back(std::uint32_t(begin));
    if (blocks_.begins.back() < colours.count) blocks_.begins.push_back(std::uint32_t(colours.count));
    for (std::uint32_t i = 0; i < colours.count; ++i) blocks_.order.push_back(i);
    update_means(colours, blocks_, means_, progress.step(0, 0));
    for_tasks(blocks_.size(), progress, [&](std::size_t i, const Stopping&) { fill(colours, i); });
  }

  Ids of(std::size_t colour) const { return Ids(ids_).subspan(colour * each_, each_); }

 private:
  // Colours of a block are near each other, as `split_points` leaves them. Neighbours are searched in the
  // nearest blocks. Twice as many neighbours of half as many blocks again lower the error by another 1 %.
  static constexpr std::size_t block = 256, near_blocks = 16, most_neighbours = 96;

  /// A score that a few more than `wanted` of `count` scores reach, by a sample of them.
  static float likely_least(const float* scores, std::size_t count, std::size_t wanted) {
    constexpr std::size_t stride = 8;
    const std::size_t rank = wanted / stride * 2 + 8;
    std::vector<float> sample;
    for (std::size_t i = 0; i < count; i += stride) sample.push_back(scores[i]);
    if (sample.size() <= rank) return -std::numeric_limits<float>::infinity();
    std::nth_element(sample.begin(), sample.begin() + std::ptrdiff_t(rank), sample.end(), std::greater<>());
    return sample[rank];
  }

  /// The `count` of `ids` with the highest scores, ascending.
  static std::vector<std::uint32_t> best(Ids ids, const float* scores, std::size_t count) {
    count = std::min(count, ids.size());
    std::vector<std::pair<float, std::uint32_t>> pairs;
    const auto take = [&](float least) {
      for (std::size_t i = 0; i < ids.size(); ++i)
        if (scores[i] >= least) pairs.emplace_back(-scores[i], ids[i]);
    };
    take(likely_least(scores, ids.size(), count));
    if (pairs.size() < count) pairs.clear(), take(-std::numeric_limits<float>::infinity());
    std::nth_element(pairs.begin(), pairs.begin() + std::ptrdiff_t(count - 1), pairs.end());
    std::vector<std::uint32_t> result;
    for (std::size_t i = 0; i < count; ++i) result.push_back(pairs[i].second);
    std::sort(result.begin(), result.end());
    return result;
  }

  std::vector<std::uint32_t> candidates(std::size_t own, std::size_t width) const {
    const Points means{means_.data(), blocks_.size(), width};
    const Ids all = Ids(blocks_.order).first(blocks_.size());
    PointTable table;
    table.assign(means, all);
    std::vector<float> scores(table.tiles() * PointTable::tile);
    score(means, all.subspan(own, 1), table, scores.data());
    std::vector<std::uint32_t> result;
    for (const std::uint32_t near : best(all, scores.data(), near_blocks)) {
      const Ids ids = members(blocks_, near);
      result.insert(result.end(), ids.begin(), ids.end());
    }
    return result;
  }

  void fill(const Points& colours, std::size_t own) {
    const std::vector<std::uint32_t> others = candidates(own, colours.width);
    PointTable table;
    table.assign(colours, others);
    std::vector<float> scores(table.tiles() * PointTable::tile);
    for (const std::uint32_t& colour : members(blocks_, own)) {
      score(colours, {&colour, 1}, table, scores.data());
      const std::vector<std::uint32_t> nearest = best(others, scores.data(), each_);
      std::copy(nearest.begin(), nearest.end(), ids_.begin() + std::ptrdiff_t(colour * each_));
    }
  }

  Grouping blocks_{};
  std::vector<float> means_{};
  std::size_t each_;
  std::vector<std::uint32_t> ids_;
};

/// Gives each point the nearest of its colour's neighbours.
void assign(const Points& points, const Points& colours, const Grouping& groups, const Neighbours& neighbours,
            std::vector<std::uint32_t>& labels, const ProgressMeter& progress) {
  for_groups(groups.size(), progress, [&](std::size_t group) {
    const Ids ids = members(groups, group), near = neighbours.of(group);
    if (ids.empty()) return;
    PointTable table;
    table.assign(colours, near);
    std::vector<std::uint32_t> nearest(ids.size());
    find_nearest(points, ids, table, nearest.data());
    for (std::size_t i = 0; i < ids.size(); ++i) labels[ids[i]] = near[nearest[i]];
  });
}

}  // namespace

Palette make_palette(const Points& points, std::size_t most, const ProgressMeter& progress) {
  constexpr int rounds = 4;  // the next two lower the error by another 0.5 %
  Grouping groups = split_points(points, most, progress.step(0, 0.6));
  Palette palette{.width = points.width};
  palette.labels.resize(points.count);
  update_means(points, groups, palette.colours, progress.step(0.6, 0.62));
  const Points colours{palette.colours.data(), groups.size(), points.width};
  const Neighbours neighbours(colours, progress.step(0.62, 0.8));
  for (int round = 0; round < rounds; ++round) {
    const ProgressMeter step = progress.step(0.8 + 0.05 * round, 0.85 + 0.05 * round);
    assign(points, colours, groups, neighbours, palette.labels, step.step(0, 0.8));
    groups = by_label(palette.labels, colours.count);
    update_means(points, groups, palette.colours, step.step(0.8, 1));
  }
  return palette;
}

}  // namespace swiftgs::io
