// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The backends that every contract test is run on.

#include <doctest/doctest.h>
#include <oneapi/tbb/global_control.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/swiftgs.hpp>

namespace swiftgs::test {

/// Lets oneTBB run eight threads where the machine has fewer cores.
inline const tbb::global_control eight_threads(tbb::global_control::max_allowed_parallelism, 8);

/// A backend of each kind; `Cpu` with more threads than the machine may have cores, so that parts really run
/// side by side.
template <class B>
B make_backend() {
  return B();
}
template <>
inline Cpu make_backend<Cpu>() {
  return Cpu(4);
}

}  // namespace swiftgs::test

/// Types of a TEST_CASE_TEMPLATE.
#define SWIFTGS_TEST_BACKENDS swiftgs::Serial, swiftgs::Cpu

TYPE_TO_STRING(swiftgs::Serial);
TYPE_TO_STRING(swiftgs::Cpu);
