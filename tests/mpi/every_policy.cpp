// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu.hpp>
#include <swiftgs/serial.hpp>

#include "mpi/compare.hpp"

void swiftgs::test::compare_every_policy(const Scene& scene, const Scene& part,
                                         const std::vector<Camera>& cameras) {
  compare<Cpu, EarlySort, PerPixel, ThreeSigmaSquare>(scene, part, cameras);
  compare<Cpu, StandardSort, AxisShared<FloatCholesky>, OpacityBox>(scene, part, cameras);
  compare<Cpu, AdaptiveSort, AxisShared<FloatSplit>, Obb>(scene, part, cameras);
  compare<Cpu, EarlySort, AxisShared<HalfSplit>, Ellipse>(scene, part, cameras);
  compare<Cpu, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>(scene, part, cameras);
  compare<Cpu, StandardSort, AxisSharedThreshold<FloatSplit>, ThreeSigmaSquare>(scene, part, cameras);
  compare<Cpu, AdaptiveSort, AxisSharedThreshold<HalfSplit>, Obb>(scene, part, cameras);
  compare<Serial, EarlySort, PerPixel, Ellipse>(scene, part, cameras);
  compare<Serial, StandardSort, AxisSharedThreshold<HalfSplit>, OpacityBox>(scene, part, cameras);
}
