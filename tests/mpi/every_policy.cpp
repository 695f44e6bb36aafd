// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu.hpp>
#include <swiftgs/serial.hpp>

#include "mpi/compare.hpp"

void swiftgs::test::compare_every_policy(const Scene& scene, const Scene& part,
                                         const std::vector<Camera>& cameras) {
  for_every_policy([&]<class Sort, class Raster, class Bounds> {
    compare<Cpu, Sort, Raster, Bounds>(scene, part, cameras);
  });
  compare<Serial, EarlySort, PerPixel, Ellipse>(scene, part, cameras);
  compare<Serial, StandardSort, AxisSharedThreshold<HalfSplit>, OpacityBox>(scene, part, cameras);
}
