// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The backends that every contract test runs on: those of hosts, and in builds with CUDA the device. The
/// build defines SWIFTGS_TEST_CUDA for the programs that have its cases, and SWIFTGS_TEST_VULKAN for those of
/// `Vulkan` alone.

#include <type_traits>

#include <doctest/doctest.h>
#include <oneapi/tbb/global_control.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/swiftgs.hpp>

#if defined(SWIFTGS_TEST_CUDA)
#include "cuda/device.hpp"
#elif defined(SWIFTGS_TEST_VULKAN)
#include "vulkan/device.hpp"
#endif

namespace swiftgs::test {

/// The renderer that most tests draw with.
template <class B, class Sort = EarlySort, class Raster = AxisSharedThreshold<FloatCholesky>,
          class Bounds = Ellipse>
using Usual = Renderer<B, Sort, Raster, Bounds>;

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

/// Whether `B` cannot run on this machine: then the running test is reported as skipped.
template <class B>
bool unavailable_backend() {
#if defined(SWIFTGS_TEST_CUDA)
  if constexpr (std::is_same_v<B, Cuda>) return without_device();
#elif defined(SWIFTGS_TEST_VULKAN)
  if constexpr (std::is_same_v<B, Vulkan>) return without_vulkan();
#endif
  return false;
}

/// Whether `B` draws on the host. A device rounds otherwise, and counts what it visits in larger groups.
template <class B>
inline constexpr bool on_host = std::is_same_v<B, Serial> || std::is_same_v<B, Cpu>;

/// Whether policies of `B` are constants of few shaders. Software compiles a shader for each combination of
/// constants, so tests take combinations that differ.
template <class B>
inline constexpr bool has_shaders = false;
#if defined(SWIFTGS_TEST_VULKAN)
template <>
inline constexpr bool has_shaders<Vulkan> = true;
#endif

/// The backend in whose memory recorded frames keep placed scenes, for work of the program to write to.
/// `Vulkan` reads them from the host when it records.
template <class B>
using RecordedScenesOn = std::conditional_t<has_shaders<B>, Serial, B>;

}  // namespace swiftgs::test

/// Types of a TEST_CASE_TEMPLATE: the backends of hosts, those that run functors, and all of this build. With
/// `Vulkan` it has no others, whose cases other programs have.
#if defined(SWIFTGS_TEST_VULKAN)
#define SWIFTGS_TEST_HOSTS
#define SWIFTGS_TEST_FUNCTOR_BACKENDS
#define SWIFTGS_TEST_BACKENDS swiftgs::Vulkan
TYPE_TO_STRING(swiftgs::Vulkan);
#else
#define SWIFTGS_TEST_HOSTS swiftgs::Serial, swiftgs::Cpu
#if defined(SWIFTGS_TEST_CUDA)
#define SWIFTGS_TEST_BACKENDS SWIFTGS_TEST_HOSTS, swiftgs::Cuda
TYPE_TO_STRING(swiftgs::Cuda);
#else
#define SWIFTGS_TEST_BACKENDS SWIFTGS_TEST_HOSTS
#endif
#define SWIFTGS_TEST_FUNCTOR_BACKENDS SWIFTGS_TEST_BACKENDS
#endif

TYPE_TO_STRING(swiftgs::Serial);
TYPE_TO_STRING(swiftgs::Cpu);

/// A case of each of the backends that are named: `B` is its type, and `backend` one of it. It is skipped
/// where that cannot run.
#define SWIFTGS_CASE_ON(sentence, ...) \
  SWIFTGS_CASE_ON_(DOCTEST_ANONYMOUS(swiftgs_case_on_), sentence, __VA_ARGS__)
#define SWIFTGS_CASE_ON_(run, sentence, ...)             \
  template <class B>                                     \
  static void run(B& backend);                           \
  TEST_CASE_TEMPLATE(sentence, B, __VA_ARGS__) {         \
    if (swiftgs::test::unavailable_backend<B>()) return; \
    B backend = swiftgs::test::make_backend<B>();        \
    run(backend);                                        \
  }                                                      \
  template <class B>                                     \
  static void run([[maybe_unused]] B& backend)

/// A case of every backend of this build.
#define SWIFTGS_CONTRACT(sentence) SWIFTGS_CASE_ON(sentence, SWIFTGS_TEST_BACKENDS)
