// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What every test of the backend `Vulkan` begins with.

#include <algorithm>
#include <cstddef>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/vulkan.hpp>

#include "policies/tile_lists.hpp"
#include "support/skip.hpp"

namespace swiftgs::test {

/// Reports the running test as skipped where there is no device.
inline bool without_vulkan() {
  if (Vulkan::usable()) return false;
  skip("no Vulkan device (package mesa-vulkan-drivers has one without a GPU)");
  return true;
}

template <>
struct CopyToBackend<Vulkan> {
  template <class T>
  static void copy(Span<const T> from, T* to) {
    Vulkan().write(from.data, to, from.size * sizeof(T));
  }
};

template <>
struct CopySplats<Vulkan> {
  static void copy(const SplatsView& from, Splats<Vulkan>& to) {
    const Vulkan b;
    const auto array = [&]<class T>(Span<const T> span, T* memory) {
      const std::vector<T> values = to_host(b, span);
      b.write(values.data(), memory, values.size() * sizeof(T));
    };
    to.reset(from.size(), 1);
    array(from.shapes, to.shapes.data()), array(from.depths, to.depths.data());
    array(from.gaussians, to.gaussians.data());
    to.set_count(from.size());
  }
};

}  // namespace swiftgs::test

/// A case that is skipped where there is no device.
#define SWIFTGS_VULKAN_CASE(sentence) SWIFTGS_VULKAN_CASE_(DOCTEST_ANONYMOUS(swiftgs_vulkan_case_), sentence)
#define SWIFTGS_VULKAN_CASE_(run, sentence)      \
  static void run();                             \
  TEST_CASE(sentence) {                          \
    if (!swiftgs::test::without_vulkan()) run(); \
  }                                              \
  static void run()
