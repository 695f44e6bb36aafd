// SPDX-License-Identifier: Apache-2.0

// A search on a device.
#include "cuda/draw_on_device.hpp"
#include "stability/climb_cases.hpp"

namespace swiftgs::test {

TEST_CASE("cuda stability: a search finds no frame that a device draws worse than floats can") {
  if (without_device()) return;
  check_climb<Cuda, DrawOnDevice>(20000);
}

}  // namespace swiftgs::test
