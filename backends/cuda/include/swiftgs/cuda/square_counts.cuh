// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/raster/raster.hpp>

namespace swiftgs::kernels {

/// Adds what a warp counted to its square, which has visited as many instances as the warp that came
/// furthest. For a whole warp, all lanes of which have the same counts.
__device__ inline void add_counts(SquareCounts& square, const SquareCounts& of_warp) {
  using Word = unsigned long long;
  const auto field = [&](std::uint64_t SquareCounts::*member) {
    return reinterpret_cast<Word*>(&(square.*member));
  };
  if (lane_index() != 0) return;
  atomicMax(field(&SquareCounts::instances_visited), Word(of_warp.instances_visited));
  atomicAdd(field(&SquareCounts::rows_visited), Word(of_warp.rows_visited));
  atomicAdd(field(&SquareCounts::contributing_pairs), Word(of_warp.contributing_pairs));
  atomicAdd(field(&SquareCounts::pixels_stopped), Word(of_warp.pixels_stopped));
}

}  // namespace swiftgs::kernels
