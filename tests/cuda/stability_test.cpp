// SPDX-License-Identifier: Apache-2.0

// Hard frames and exact decisions on a device.
#include "cuda/draw_on_device.hpp"
#include "stability/climb_cases.hpp"

namespace swiftgs::test {
namespace {

using Backends = Sweep<Cuda, DrawOnDevice>;
bool unavailable() { return without_device(); }

}  // namespace
}  // namespace swiftgs::test

#define SWIFTGS_STABILITY "cuda stability"
#include "stability/sweep_cases.hpp"

namespace swiftgs::test {

SWIFTGS_DEVICE_CASE("cuda stability: a search finds no frame that a device draws worse than floats can") {
  check_climb<Cuda, DrawOnDevice>(20000);
}

}  // namespace swiftgs::test
