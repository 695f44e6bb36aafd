// SPDX-License-Identifier: Apache-2.0

// Frames of several views and of parts of an image, on every backend.
#include "policies/views.hpp"

#include <cstddef>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

template <class B, class Sort = EarlySort, class Raster = AxisSharedThreshold<FloatCholesky>,
          class Bounds = Ellipse>
struct Two {
  Renderer<B, Sort, Raster, Bounds> together{test::make_backend<B>()}, alone{test::make_backend<B>()};

  auto upload(const Scene& scene) { return together.backend().upload(scene); }
};

/// Calls f(two) with two renderers of each rasterizer.
template <class B, class F>
void for_each_raster_renderer(const F& f) {
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    f(Two<B, EarlySort, Raster>());
  });
}

}  // namespace

SWIFTGS_CONTRACT("views: a frame of several has the bits of each view alone") {
  for_each_raster_renderer<B>([&](auto&& two) {
    const auto scene = two.upload(random_scene(400, 2, 1));
    check_lists_of_views(two.together, two.alone, scene.view());
  });
}

SWIFTGS_CONTRACT("views: every list of a view is that of the view alone with each sort and bounds") {
  for_each_type(AllSorts(), [&]<class Sort>(Sort) {
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
      CAPTURE(Sort::name);
      CAPTURE(Bounds::name);
      Two<B, Sort, PerPixel, Bounds> two;
      const auto scene = two.upload(random_scene(2000, 0, 3));
      check_lists(two.together, two.alone, scene.view());
      // One renderer may go from frames of one view to frames of many, and the other way.
      if (on_host<B>) return check_lists(two.together, two.together, scene.view());
      const auto large = two.upload(random_scene(50'000, 0, 3));
      check_lists(two.together, two.together, large.view());
    });
  });
}

SWIFTGS_CONTRACT("views: the parts of an image have the bits of the image") {
  const auto check = [&](auto&& two) {
    const auto scene = two.upload(random_scene(400, 1, 2));
    check_bands(two.together, scene.view());
  };
  for_each_raster_renderer<B>(check);
  check(Two<B, StandardSort, PerPixel, ThreeSigmaSquare>());
}

SWIFTGS_CONTRACT("views: parts show the pixels that rounding keeps beyond the box of a splat") {
  const AskedView asked{bordered_camera()};
  const std::vector<Part> parts = cut(48, 48, {0, 16}, {0, 16});
  const auto check = [&](auto&& two) {
    for (std::uint64_t seed = 0; seed < 20; ++seed)
      check_parts(two.together, two.upload(bordered_scene(2000, seed)).view(), asked, parts);
  };
  for_each_raster_renderer<B>(check);
  check(Two<B, EarlySort, PerPixel, ThreeSigmaSquare>());
}

SWIFTGS_CONTRACT("views: one wide view among fifty small ones has the bits of each alone") {
  Two<B> two;
  const auto scene = two.upload(random_scene(300, 1, 3));
  check_views(two.together, two.alone, scene.view(), one_wide_among_small());
}

SWIFTGS_CONTRACT("views: hundreds and thousands of tiny views have the bits of each alone") {
  const auto check = [](auto&& two) {
    const auto scene = two.upload(random_scene(100, 1, 4));
    check_views(two.together, two.alone, scene.view(), tiny_views());
    check_many_rows(two.together, two.upload(random_scene(10, 1, 12)));
  };
  if constexpr (on_host<B>)
    check(Two<B>());
  else
    for_each_raster_renderer<B>(check);  // the rows of a device's grid are few
}

SWIFTGS_CONTRACT("views: several views of an empty scene are their backgrounds") {
  Two<B> two;
  check_views(two.together, two.alone, two.upload(Scene()).view(), different_views());
}

TEST_CASE("views: frames of several have the same bits with one thread and two") {
  const Scene scene = random_scene(5000, 2, 5);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const auto drawn_by = [&](int threads) {
      Renderer<Cpu, EarlySort, Raster, Ellipse> renderer{Cpu(threads)};
      const auto uploaded = renderer.backend().upload(scene);
      PlacedViews placed(renderer.backend(), different_views());
      renderer.render_into(uploaded.view(), placed.span());
      return placed.finish(renderer.backend());
    };
    CHECK(differing(drawn_by(1), drawn_by(2)) == 0);
  });
}

SWIFTGS_CONTRACT("views: frames for several cameras are the frames of each camera") {
  Two<B> two;
  auto& renderer = two.together;
  const auto scene = two.upload(random_scene(300, 1, 6));
  const Camera cameras[] = {forward_camera(50, 40), turned_camera(33, 17, 0.2, 0.3), forward_camera(16, 16)};
  RenderSettings settings;
  settings.outputs = {true, true}, settings.background = vec3(0.1f, 0.2f, 0.3f);
  std::vector<Frame> frames(std::size(cameras));
  renderer.render(scene, {cameras, std::size(cameras)}, settings, {frames.data(), frames.size()});
  const Span<const FrameView> resident =
      renderer.render_resident(scene.view(), {cameras, std::size(cameras)}, settings);
  REQUIRE(resident.size == std::size(cameras));
  std::vector<std::vector<float>> colours;
  for (const FrameView& frame : resident) {
    CHECK(frame.colour.pitch == std::ptrdiff_t(3 * sizeof(float)) * frame.width);
    colours.push_back(to_host(renderer.backend(), Span{static_cast<const float*>(frame.colour.data),
                                                       std::size_t(3 * frame.width * frame.height)}));
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Frame alone = renderer.render(scene, cameras[i], settings);
    CHECK(same_bits(frames[i].colour, alone.colour));
    CHECK(same_bits(frames[i].alpha, alone.alpha));
    CHECK(same_bits(frames[i].depth, alone.depth));
    CHECK(same_bits(colours[i], alone.colour));
  }
  CHECK_THROWS_WITH_AS(renderer.render(scene, {cameras, 3}, settings, {frames.data(), 2}),
                       "render: the number of frames is 2, expected 3, one a camera", std::invalid_argument);
}

SWIFTGS_CONTRACT("views: frames of none and of too many tiles are refused and the next is drawn") {
  Two<B> two;
  const auto scene = two.upload(random_scene(100, 1, 8));
  CHECK_THROWS_WITH_AS(two.together.render_into(scene.view(), Span<const View>{}),
                       "frame: the number of views is 0, expected 1 to 65536", std::invalid_argument);
  check_views(two.together, two.alone, scene.view(), different_views());
  const Camera huge = forward_camera(max_image_side, max_image_side);
  const View view = make_view(huge, Conventions(), {.width = huge.width, .height = huge.height});
  const std::vector<View> views(129, view);
  CHECK_THROWS_WITH_AS(two.together.render_into(scene.view(), Span<const View>{views.data(), views.size()}),
                       "tiles in one frame: 2164260864 needed, the limit is 2147483648", CapacityError);
  check_views(two.together, two.alone, scene.view(), different_views());
}

SWIFTGS_CONTRACT("views: bad ones are refused by all calls and those that were set are recorded") {
  Two<B> two;
  const auto scene = two.upload(random_scene(400, 1, 9));
  check_bad_views(two.together, two.alone, scene.view());
}

TEST_CASE_TEMPLATE("views: recorded frames follow formats and planes and places that change", B,
                   SWIFTGS_TEST_HOSTS) {
  Two<B> two;
  const auto scene = two.upload(random_scene(2000, 1, 10));
  check_changing_views(two.together, two.alone, scene.view(), [&](FrameReport* report) {
    return [&, report] { two.together.record(scene.view(), report); };
  });
}
