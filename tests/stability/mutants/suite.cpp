// SPDX-License-Identifier: Apache-2.0

// The stability tests of one backend in one translation unit: what an injected defect is tried on.
#include <doctest/doctest.h>

#if defined(SWIFTGS_MUTANT_CPU)
#include <swiftgs/cpu.hpp>
#else
#include <swiftgs/serial.hpp>
#endif

#include "stability/sweep.hpp"

namespace swiftgs::test {
namespace {

#if defined(SWIFTGS_MUTANT_CPU)
using Backends = Sweep<Cpu>;
#else
using Backends = Sweep<Serial>;
#endif
bool unavailable() { return false; }

}  // namespace
}  // namespace swiftgs::test

#define SWIFTGS_STABILITY "mutant"
#include "stability/sweep_cases.hpp"
