// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/bounds/bounds.hpp>
#include <swiftgs/cuda/warp.cuh>

namespace swiftgs::kernels {

/// Rows of tiles of the 32 splats of a warp, each lane's in turn, spread evenly over the lanes: a splat of many rows
/// does not keep one lane busy. `shapes` are the warp's own, `rect` is that of the lane's splat, empty where it has
/// none. Calls f(owner, row, run) on all lanes together, with an empty run on lanes that are left without a row.
template <class Bounds, class F>
__device__ void for_each_row(const Bounds& bounds, const SplatShape* shapes, TileRect rect, const F& f) {
  const std::uint32_t rows = rect.columns.size() == 0 ? 0 : std::uint32_t(rect.rows.size());
  const std::uint32_t first = sum_below(rows);
  const std::uint32_t total = __shfl_sync(whole_warp, first + rows, warp_size - 1);
  for (std::uint32_t begin = 0; begin < total; begin += warp_size) {
    const std::uint32_t position = begin + lane_index();
    const unsigned owner = owner_of(position, first);
    const auto of_owner = [&](auto value) { return __shfl_sync(whole_warp, value, int(owner)); };
    const TileRect theirs{{of_owner(rect.columns.begin), of_owner(rect.columns.end)},
                          {of_owner(rect.rows.begin), of_owner(rect.rows.end)}};
    const int row = theirs.rows.begin + int(position - of_owner(first));
    TileRun run;
    if (position < total) run = bounds.row(shapes[owner], theirs, row);
    f(owner, row, run);
  }
}

}  // namespace swiftgs::kernels
