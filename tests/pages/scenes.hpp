// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/pages/build_pages.hpp>
#include <swiftgs/pages/paged_scene.hpp>

#include "support/files.hpp"

namespace swiftgs::test {

/// Neighbours in space are neighbours in it.
inline Scene ordered_scene(std::size_t count) { return order_spatially(make_builtin_scene(count)); }

/// Small pages, so that small scenes have deep trees.
inline PageBuildOptions small_pages() { return {.page_size = 256, .memory = 8 << 20}; }

inline PagedScene pages_of(const TemporaryFolder& folder, const Scene& scene,
                           const PageBuildOptions& options = small_pages()) {
  build_pages(scene, folder / "scene.sgp", options);
  return open_pages(folder / "scene.sgp");
}

inline void check_same(const Scene& a, const Scene& b) {
  REQUIRE(a.size() == b.size());
  CHECK(a.sh_degree == b.sh_degree);
  CHECK(a.model == b.model);
  CHECK(a.origin == b.origin);
  for_each_array(
      [](const char* name, std::size_t, const auto& x, const auto& y) {
        INFO(std::string(name));
        CHECK(x == y);
      },
      a, b);
}

}  // namespace swiftgs::test
