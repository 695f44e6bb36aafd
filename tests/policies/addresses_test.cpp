// SPDX-License-Identifier: Apache-2.0

// A backend without functors draws by stages of its own, from the addresses of buffers alone.
#include "policies/addresses.hpp"

#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/drivers/render_settings.hpp>
#include <swiftgs/drivers/resident_frames.hpp>
#include <swiftgs/frame/frame_renderer.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/all_planes.hpp"
#include "policies/random_splats.hpp"

namespace swiftgs::test {

TEST_CASE("addresses: a backend that runs no functor draws the bits of one that does") {
  const Scene scene = with_features(random_scene(3000, 2, 11), 20);
  const Camera cameras[] = {forward_camera(120, 70), forward_camera(50, 90)};
  RenderSettings settings;
  settings.outputs = all_planes(20);
  Frame expected[2];
  Renderer<Serial, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> serial;
  serial.render(serial.backend().upload(scene), {cameras, 2}, settings, {expected, 2});

  FrameRenderer<Addresses> renderer({}, stage_table<Addresses, AxisSharedThreshold<FloatCholesky>, Ellipse>(),
                                    std::make_unique<SortStageOf<Addresses, EarlySort, Ellipse>>());
  const AddressScene there = renderer.backend().upload(scene);
  ResidentFrames<Addresses> frames;
  std::vector<View> views;
  make_views({cameras, 2}, settings, views);
  const Span<const FrameView> planes = frames.make({cameras, 2}, settings.outputs);
  for (std::size_t i = 0; i < views.size(); ++i) views[i].frame = planes[i];
  for (int frame = 0; frame < 2; ++frame) renderer.render_into(there, {views.data(), views.size()});

  Frame drawn[2];
  for (std::size_t i = 0; i < 2; ++i)
    prepare(drawn[i], cameras[i].width, cameras[i].height, settings.outputs);
  frames.download(renderer.backend(), {drawn, 2});
  for (std::size_t i = 0; i < 2; ++i) CHECK(same_planes(drawn[i], expected[i]));
}

TEST_CASE("addresses: a renderer draws on a backend that lacks functions and names one that it needs") {
  const auto scene = std::make_shared<const Scene>(random_scene(300, 1, 11));
  Renderer<Serial> serial;
  Renderer<Addresses> renderer;
  const Camera camera = forward_camera(50, 40);
  CHECK(same_planes(renderer.render(renderer.backend().upload(*scene), camera),
                    serial.render(serial.backend().upload(scene), camera)));
  CHECK_THROWS_WITH_AS(renderer.set_scene(scene),
                       "backend addresses: expected a function upload of scenes to keep", Unavailable);
  CHECK_THROWS_WITH_AS(renderer.pick(0, 0), "backend addresses: expected a function pick_pixels",
                       Unavailable);
}

}  // namespace swiftgs::test
