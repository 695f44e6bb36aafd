// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>

#include <swiftgs/mpi/strips.hpp>

namespace swiftgs {
namespace {

/// Cuts where the running sum of `costs` passes equal parts of the whole. No rank is without a row that could
/// have one.
StripCuts cuts_of(const std::vector<std::uint64_t>& costs, std::uint32_t ranks) {
  const auto rows = std::uint32_t(costs.size());
  const std::uint64_t all = std::accumulate(costs.begin(), costs.end(), std::uint64_t(0));
  StripCuts cuts(ranks + 1, rows);
  cuts[0] = 0;
  std::uint64_t before = 0;
  std::uint32_t row = 0;
  for (std::uint32_t r = 1; r < ranks; ++r) {
    const std::uint64_t wanted = all / ranks * r + all % ranks * r / ranks;
    // The row in which the sum passes goes to where it is nearer.
    while (row < rows && before + costs[row] / 2 < wanted) before += costs[row++];
    const std::uint32_t least = std::min(rows, cuts[r - 1] + 1);
    const std::uint32_t left = ranks - r, most = rows > left ? rows - left : least;
    const std::uint32_t cut = std::clamp(row, least, std::max(least, most));
    for (; row < cut; ++row) before += costs[row];
    for (; row > cut; --row) before -= costs[row - 1];
    cuts[r] = cut;
  }
  return cuts;
}

/// Added to every row's cost, so that rows without splats count as well.
constexpr std::uint64_t least_cost = 16;

}  // namespace

StripPlan::StripPlan(std::uint32_t rows, int ranks)
    : costs_(rows, least_cost), cuts_(cuts_of(costs_, std::uint32_t(ranks))) {}

void StripPlan::learn(Span<const std::uint64_t> taken) {
  // No frame takes an hour a rank; sums of what does would leave the range of 64 bits.
  constexpr std::uint64_t most = 3'600'000'000'000;
  for (std::size_t r = 0; r < taken.size; ++r) {
    const std::uint32_t rows_here = cuts_[r + 1] - cuts_[r];
    if (rows_here == 0) continue;
    const std::uint64_t of_row = std::min(taken[r], most) / rows_here + least_cost;
    for (std::uint32_t row = cuts_[r]; row < cuts_[r + 1]; ++row)
      costs_[row] = costs_[row] == least_cost ? of_row : (costs_[row] + of_row) / 2;
  }
  const std::uint64_t sum = std::accumulate(taken.begin(), taken.end(), std::uint64_t(0));
  const std::uint64_t slowest = taken.size == 0 ? 0 : *std::max_element(taken.begin(), taken.end());
  if (20 * slowest > 21 * (sum / std::max<std::uint64_t>(taken.size, 1)))
    cuts_ = cuts_of(costs_, std::uint32_t(taken.size));
}

Strip strip_of(Span<const View> views, std::uint32_t begin, std::uint32_t end) {
  Strip strip;
  std::uint32_t first = 0;  // row of the tile atlas where a view begins
  for (std::size_t i = 0; i < views.size; ++i) {
    const View& whole = views[i];
    const std::uint32_t last = first + std::uint32_t(whole.grid.rows.size());
    const std::uint32_t from = std::max(begin, first), to = std::min(end, last);
    if (from < to) {
      const int side = whole.grid.side;
      ViewStrip view_strip{.view = std::uint32_t(i), .first_row = int(from - first) * side};
      view_strip.rows = std::min(int(to - first) * side, whole.frame.height) - view_strip.first_row;
      view_strip.width = whole.frame.width;
      View part = whole;
      part.grid.rows = {whole.grid.rows.begin + int(from - first), whole.grid.rows.begin + int(to - first)};
      part.frame.height = view_strip.rows;
      for_each_plane([](std::size_t, auto& plane) { plane.data = nullptr; }, part.frame);
      part.frame.occluder.data = nullptr;
      part.camera.top = whole.camera.top + float(view_strip.first_row);
      part.camera.bottom = part.camera.top + float(view_strip.rows);
      if (strip.views.empty()) strip.first_view = view_strip.view;
      strip.view_strips.push_back(view_strip), strip.views.push_back(part);
    }
    first = last;
  }
  return strip;
}

}  // namespace swiftgs
