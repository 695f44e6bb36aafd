// SPDX-License-Identifier: Apache-2.0

// A search on the backends of the host.
#include <swiftgs/cpu.hpp>
#include <swiftgs/serial.hpp>

#include "stability/climb_cases.hpp"

namespace swiftgs::test {

TEST_CASE("stability: a search finds no frame that serial draws worse than floats can") {
  check_climb<Serial, DrawOnHost>(20000);
}

TEST_CASE("stability: a search finds no frame that cpu draws worse than floats can") {
  check_climb<Cpu, DrawOnHost>(20000);
}

}  // namespace swiftgs::test
