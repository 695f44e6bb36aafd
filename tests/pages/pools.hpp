// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/lens/view.hpp>
#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/swiftgs.hpp>

#include "pages/scenes.hpp"

namespace swiftgs::test {

inline constexpr int width = 160, height = 96;

inline View view_of(const Camera& camera) {
  return make_view(camera, Conventions::gsplat(), {.width = width, .height = height});
}
inline std::vector<View> front() { return {view_of(builtin_camera(width, height))}; }
inline Span<const View> all_of(const std::vector<View>& views) { return {views.data(), views.size()}; }

/// Bytes of a file in memory that a test holds up and breaks.
struct TestSource {
  std::string content;
  std::function<void()> before_read = [] {};

  static std::shared_ptr<TestSource> of(const Scene& scene) {
    const TemporaryFolder folder;
    build_pages(scene, folder / "a.sgp", small_pages());
    auto source = std::make_shared<TestSource>();
    source->content = content_of(folder / "a.sgp");
    return source;
  }
};
inline PagedScene open(const std::shared_ptr<TestSource>& source) {
  return PagedScene(
      [source](std::uint64_t offset, std::span<std::byte> to) {
        source->before_read();
        std::memcpy(to.data(), source->content.data() + offset, to.size());
      },
      source->content.size(), "test.sgp");
}

/// Leaves below a page.
inline void leaves_below(const PagedScene& pages, std::uint32_t page, std::vector<std::uint32_t>& leaves) {
  const Span<const Page> all = pages.pages();
  const Page& row = all[page];
  if (row.is_leaf()) return leaves.push_back(page);
  leaves_below(pages, row.left, leaves), leaves_below(pages, row.right, leaves);
}

/// Whether each leaf that some view may show stands in the cut once, itself or by a page above it; and no
/// page of the cut shows nothing.
inline void check_no_hole(const Cut& cut, const PagedScene& pages, const std::vector<View>& views) {
  std::vector<std::uint32_t> drawn;
  std::uint32_t first = 0;
  for (const PlacedScene& placed : cut.scenes()) {
    leaves_below(pages, cut.named(first).page, drawn);
    first += std::uint32_t(placed.size());
  }
  const std::set<std::uint32_t> once(drawn.begin(), drawn.end());
  CHECK(once.size() == drawn.size());
  for (const View& view : views)
    for (std::uint32_t i = 0; i < pages.pages().size; ++i)
      if (pages.pages()[i].is_leaf() && !ChunkCuller(view.camera).culls(pages.pages()[i].bounds))
        CHECK(once.contains(i));
}

/// A camera that walks past the scene and turns, at a frame of its walk.
inline Camera walker(int frame) {
  const double angle = 0.03 * frame;
  const dvec3 eye(-8 + 0.1 * frame, -1, -6);
  return look_at(eye, eye + dvec3(std::sin(angle), 0, std::cos(angle)), {0, -1, 0}, 0.8, width, height);
}

}  // namespace swiftgs::test
