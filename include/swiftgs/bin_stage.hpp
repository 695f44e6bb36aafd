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
  const View* views;
  Bounds bounds;
  Footprint* footprints;

  SWIFTGS_HD void operator()(std::size_t i) const {
    footprints[i] = find_footprint(bounds, splats.shapes[i], views[splats.view(i)].grid);
  }
};

/// Finds the tiles of its view that each splat may touch within `bounds`, and how many there are in all:
/// after this stage the host knows the numbers of splats and of instances. Throws as `frame_tiles`.
///
/// Backends overload this. One whose projection has found the footprints on the way only learns their numbers
/// here.
template <BackendPolicy B, BoundsPolicy Bounds>
requires(bool(B::reaches_host_memory)) void bin(B& b, const Views& views, const Bounds& bounds,
                                                Splats<B>& splats, Footprints<B, Bounds>& footprints) {
  footprints.tiles = frame_tiles(views), footprints.views = views;
  const std::size_t n = splats.count;
  footprints.each.reset(n);
  footprints.count = n, footprints.instances = 0;
  b.for_each(n, FindFootprint<Bounds>{splats.view(), views.reachable(), bounds, footprints.each.data()});
  for (const Footprint& footprint : footprints.view().each) footprints.instances += footprint.count;
}

}  // namespace swiftgs
