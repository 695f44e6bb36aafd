// SPDX-License-Identifier: Apache-2.0
#include "draw/page_frames.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "pages/scenes.hpp"

using namespace swiftgs;
using namespace swiftgs::cli;

TEST_CASE("page frames: nothing shows where a page that a complete frame needs cannot be read") {
  const test::TemporaryFolder folder;
  test::pages_of(folder, test::ordered_scene(3000));
  const std::string content = test::content_of(folder / "scene.sgp");
  std::atomic<bool> fails = false;
  const PagedScene pages(
      [&](std::uint64_t offset, std::span<std::byte> to) {
        if (fails) throw std::runtime_error("no disk");
        std::memcpy(to.data(), content.data() + offset, to.size());
      },
      content.size(), "scene.sgp");
  const std::unique_ptr<AnyRenderer> renderer =
      make_renderer(find_renderer("serial/early/axis-shared-threshold-float-cholesky/ellipse").name);
  PageFrames frames(*renderer, {{nullptr}, {pages}, {{}}, {}}, HarmonicsKept::smallest, {});
  const Camera camera = builtin_camera(96, 64);
  const auto is_black = [&] {
    Frame frame;
    renderer->render(camera, {}, frame);
    return std::all_of(frame.colour.begin(), frame.colour.end(), [](float value) { return value == 0; });
  };
  CHECK(frames.show_complete({&camera, 1}, {}, {.pixels = 100}).missing() == 0);
  CHECK_FALSE(is_black());
  fails = true;
  CHECK_THROWS_WITH(frames.show_complete({&camera, 1}, {}, {.pixels = 0}), "no disk");
  CHECK(is_black());
  fails = false;
  CHECK(frames.show_complete({&camera, 1}, {}, {.pixels = 0}).splats() > 1000);
  CHECK_FALSE(is_black());
}
