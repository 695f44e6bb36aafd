// SPDX-License-Identifier: Apache-2.0

// The stability tests of one backend in one translation unit: what an injected defect
// is tried on.
#include <doctest/doctest.h>

#if defined(SWIFTGS_MUTANT_CUDA)
#include "cuda/draw_on_device.hpp"
#elif defined(SWIFTGS_MUTANT_CPU)
#include <swiftgs/cpu.hpp>
#else
#include <swiftgs/serial.hpp>
#endif

#include "stability/sweep.hpp"

namespace swiftgs::test {
namespace {

#if defined(SWIFTGS_MUTANT_CUDA)
using Backends = Sweep<Cuda, DrawOnDevice>;
bool unavailable() { return without_device(); }
#elif defined(SWIFTGS_MUTANT_CPU)
using Backends = Sweep<Cpu>;
bool unavailable() { return false; }
#else
using Backends = Sweep<Serial>;
bool unavailable() { return false; }
#endif

}  // namespace
}  // namespace swiftgs::test

#define SWIFTGS_STABILITY "mutant"
#include "stability/corner_cases.hpp"
#include "stability/edge_cases.hpp"
#include "stability/number_cases.hpp"
#include "stability/sweep_cases.hpp"
// Uses functions of the sweep's cases.
#include "stability/found_cases.hpp"
#if defined(SWIFTGS_MUTANT_CUDA)
#include "stability/mutants/plane_cases.hpp"
#endif
