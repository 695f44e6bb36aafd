// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames for several cameras by renderers that are chosen at run time.

#include <cstddef>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>

namespace swiftgs::test {

/// Checks that the frames for `cameras` have the bits and the counts of a frame for each camera.
inline void check_cameras(AnyRenderer& renderer, const std::shared_ptr<const Scene>& scene,
                          Span<const Camera> cameras, const RenderSettings& settings) {
  renderer.set_scene(scene);
  std::vector<Frame> together(cameras.size);
  renderer.render(cameras, settings, Span<Frame>{together.data(), together.size()});
  const Statistics statistics = renderer.statistics();
  std::size_t visible = 0, intersections = 0;
  for (std::size_t i = 0; i < cameras.size; ++i) {
    Frame alone;
    renderer.render(cameras[i], settings, alone);
    visible += renderer.statistics().visible, intersections += renderer.statistics().intersections;
    CHECK((together[i].colour == alone.colour));
    CHECK((together[i].alpha == alone.alpha));
    CHECK((together[i].depth == alone.depth));
  }
  CHECK(statistics.visible == visible);
  CHECK(statistics.intersections == intersections);
  renderer.render_resident(cameras, settings);
  CHECK(renderer.statistics().intersections == intersections);
}

}  // namespace swiftgs::test
