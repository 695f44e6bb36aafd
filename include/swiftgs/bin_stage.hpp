// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/api.hpp>
#include <swiftgs/backend.hpp>
#include <swiftgs/footprint.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/view.hpp>

namespace swiftgs {

/// Finds the footprint of splat i.
template <class Bounds>
struct FindFootprint {
  SplatsView splats;
  TileGrid grid;
  Bounds bounds;
  Footprint* footprints;

  SWIFTGS_HD void operator()(std::size_t i) const {
    footprints[i] = find_footprint(bounds, splats.shapes[i], grid);
  }
};

/// Finds the tiles of a view that each splat may touch within `bounds`, and how many there are in all: after
/// this stage the host knows the numbers of splats and of instances. Throws as `only_view`.
///
/// Backends overload this. One whose projection has found the footprints on the way only learns their numbers
/// here.
template <BackendPolicy B, BoundsPolicy Bounds>
requires(bool(B::reaches_host_memory)) void bin(B& b, Span<const View> views, const Bounds& bounds,
                                                Splats<B>& splats, Footprints<B, Bounds>& footprints) {
  const TileGrid grid = only_view(views).grid;
  const std::size_t n = splats.count;
  footprints.each.reset(n);
  footprints.count = n, footprints.grid = grid, footprints.instances = 0;
  b.for_each(n, FindFootprint<Bounds>{splats.view(), grid, bounds, footprints.each.data()});
  for (const Footprint& footprint : footprints.view().each) footprints.instances += footprint.count;
}

}  // namespace swiftgs
