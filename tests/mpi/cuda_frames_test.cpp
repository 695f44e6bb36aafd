// SPDX-License-Identifier: Apache-2.0

// Frames over ranks with a device each, or one that they share, have the bits of one process.
#include <cstring>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/mpi/cuda.hpp>

#include "mpi/compare.hpp"
#include "support/skip.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Whether all ranks have a device; each takes one.
bool on_devices() {
  const bool usable = ranks_here().all(Cuda::usable());
  if (usable)
    take_device(ranks_here());
  else
    skip("no GPU here");
  return usable;
}

}  // namespace

TEST_CASE("mpi cuda: each policy draws the bits of one process") {
  if (!on_devices()) return;
  const Scene scene = make_builtin_scene(30'000), part = part_of(scene, own_part());
  const std::vector<Camera> cameras = some_cameras();
  compare<Cuda, EarlySort, PerPixel, ThreeSigmaSquare>(scene, part, cameras);
  compare<Cuda, StandardSort, AxisShared<FloatCholesky>, OpacityBox>(scene, part, cameras);
  compare<Cuda, AdaptiveSort, AxisShared<FloatSplit>, Obb>(scene, part, cameras);
  compare<Cuda, EarlySort, AxisShared<HalfSplit>, Ellipse>(scene, part, cameras);
  compare<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>(scene, part, cameras);
  compare<Cuda, StandardSort, AxisSharedThreshold<FloatSplit>, ThreeSigmaSquare>(scene, part, cameras);
  compare<Cuda, AdaptiveSort, AxisSharedThreshold<HalfSplit>, Obb>(scene, part, cameras);
}

TEST_CASE("mpi cuda: a large frame with long lists draws the bits of one process") {
  if (!on_devices()) return;
  const Scene scene = make_builtin_scene(400'000);
  compare<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>(scene, part_of(scene, own_part()),
                                                                        {builtin_camera(1280, 720)}, 4);
}

TEST_CASE("mpi cuda: parts may be empty and messages cut") {
  if (!on_devices()) return;
  const Scene scene = make_builtin_scene(2'000);
  ranks_here().set_longest_message(5000);
  compare<Cuda, EarlySort, PerPixel, Ellipse>(part_of(scene, {0, 1000}), {builtin_camera(120, 80)}, 2);
  compare<Cuda, EarlySort, PerPixel, Ellipse>(Scene{}, {builtin_camera(120, 80)}, 2);
  compare<Cuda, EarlySort, PerPixel, Ellipse>(scene, {builtin_camera(200, 17)}, 2);
  ranks_here().set_longest_message(std::size_t(1) << 30);
}
