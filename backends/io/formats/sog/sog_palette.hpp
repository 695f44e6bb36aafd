// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nearest_points.hpp"
#include "progress_meter.hpp"

namespace swiftgs::io {

/// Points that stand for others.
struct Palette {
  std::size_t width = 0;
  std::vector<float> colours{};         ///< `width` floats each
  std::vector<std::uint32_t> labels{};  ///< of each point its colour's number

  std::size_t size() const { return width == 0 ? 0 : colours.size() / width; }
};

/// At most `most` colours for `points`, with a small sum of squared distances: k-means. The same points give
/// the same palette. Takes time linear in `points.count`.
Palette make_palette(const Points& points, std::size_t most, const ProgressMeter& progress);

/// Points in groups, each of a few points near each other: group g has `order[begins[g]]` to
/// `order[begins[g + 1] - 1]`.
struct Grouping {
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> begins;

  std::size_t size() const { return begins.size() - 1; }
};

/// Splits all points into two groups, then always the group with the largest sum of squared distances to its
/// mean, until there are `most` groups or all points of a group are equal. Groups of one half come before
/// those of the other, so near groups often have near numbers.
Grouping split_points(const Points& points, std::size_t most, const ProgressMeter& progress);

}  // namespace swiftgs::io
