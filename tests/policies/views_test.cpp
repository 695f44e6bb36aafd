// SPDX-License-Identifier: Apache-2.0

// Frames of several views and of parts of an image, on hosts.
#include "policies/views.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

template <class B>
using Usual = Renderer<B, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>;

/// Calls f(together, alone) with two renderers of each rasterizer, then of each sort within each bounds.
template <class B, class F>
void for_each_renderer(const F& f) {
  const auto with = [&]<class R>(std::type_identity<R>) {
    CAPTURE(R::name);
    R together(make_backend<B>()), alone(make_backend<B>());
    f(together, alone);
  };
  for_each_raster(
      [&]<class Raster>(Raster) { with(std::type_identity<Renderer<B, EarlySort, Raster, Ellipse>>()); });
  for_each_type(AllSorts(), [&]<class Sort>(Sort) {
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
      with(std::type_identity<Renderer<B, Sort, AxisSharedThreshold<FloatCholesky>, Bounds>>());
    });
  });
}

}  // namespace

TEST_CASE_TEMPLATE("views: a frame of several has the bits of each view alone", B, SWIFTGS_TEST_BACKENDS) {
  const Scene scene = random_scene(400, 2, 1);
  for_each_renderer<B>([&](auto& together, auto& alone) {
    const auto uploaded = together.backend().upload(scene);
    check_lists_of_views<OnHost>(together, alone, uploaded.view());
  });
}

TEST_CASE_TEMPLATE("views: the parts of an image have the bits of the image", B, SWIFTGS_TEST_BACKENDS) {
  const Scene scene = random_scene(400, 1, 2);
  for_each_renderer<B>([&](auto& renderer, auto&) {
    const auto uploaded = renderer.backend().upload(scene);
    check_bands<OnHost>(renderer, uploaded.view());
  });
}

TEST_CASE_TEMPLATE("views: parts show the pixels that rounding keeps beyond the box of a splat", B,
                   SWIFTGS_TEST_BACKENDS) {
  const AskedView asked{bordered_camera()};
  const std::vector<Part> parts = cut(48, 48, {0, 16}, {0, 16});
  Usual<B> ellipses(make_backend<B>());
  Renderer<B, EarlySort, PerPixel, ThreeSigmaSquare> squares(make_backend<B>());
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto scene = ellipses.backend().upload(bordered_scene(2000, seed));
    check_parts<OnHost>(ellipses, scene.view(), asked, parts);
    check_parts<OnHost>(squares, scene.view(), asked, parts);
  }
}

TEST_CASE_TEMPLATE("views: one wide view among fifty small ones has the bits of each alone", B,
                   SWIFTGS_TEST_BACKENDS) {
  Usual<B> together(make_backend<B>()), alone(make_backend<B>());
  const auto scene = together.backend().upload(random_scene(300, 1, 3));
  check_views<OnHost>(together, alone, scene.view(), one_wide_among_small());
}

TEST_CASE_TEMPLATE("views: three hundred tiny views have the bits of each alone", B, SWIFTGS_TEST_BACKENDS) {
  Usual<B> together(make_backend<B>()), alone(make_backend<B>());
  const auto scene = together.backend().upload(random_scene(100, 1, 4));
  check_views<OnHost>(together, alone, scene.view(), tiny_views());
}

TEST_CASE_TEMPLATE("views: thirty-three thousand tiny views have the bits of each alone", B,
                   SWIFTGS_TEST_BACKENDS) {
  Usual<B> renderer(make_backend<B>());
  const auto scene = renderer.backend().upload(random_scene(10, 1, 12));
  check_many_rows(renderer, scene);
}

TEST_CASE_TEMPLATE("views: several views of an empty scene are their backgrounds", B, SWIFTGS_TEST_BACKENDS) {
  Usual<B> together(make_backend<B>()), alone(make_backend<B>());
  const auto scene = together.backend().upload(Scene());
  check_views<OnHost>(together, alone, scene.view(), different_views());
}

TEST_CASE("views: frames of several have the same bits with one thread and two") {
  const Scene scene = random_scene(5000, 2, 5);
  for_each_raster([&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const auto drawn_by = [&](int threads) {
      Renderer<Cpu, EarlySort, Raster, Ellipse> renderer{Cpu(threads)};
      const auto uploaded = renderer.backend().upload(scene);
      PlacedViews<OnHost> placed(different_views());
      renderer.render_into(uploaded.view(), placed.span());
      return placed.finish(renderer.backend());
    };
    CHECK(differing(drawn_by(1), drawn_by(2)) == 0);
  });
}

TEST_CASE_TEMPLATE("views: frames for several cameras are the frames of each camera", B,
                   SWIFTGS_TEST_BACKENDS) {
  Usual<B> renderer(make_backend<B>());
  const auto scene = renderer.backend().upload(random_scene(300, 1, 6));
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
    const auto* first = static_cast<const float*>(frame.colour.data);
    CHECK(frame.colour.pitch == std::ptrdiff_t(3 * sizeof(float)) * frame.width);
    colours.emplace_back(first, first + 3 * frame.width * frame.height);
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Frame alone = renderer.render(scene, cameras[i], settings);
    CHECK(frames[i].colour == alone.colour);
    CHECK(frames[i].alpha == alone.alpha);
    CHECK(frames[i].depth == alone.depth);
    CHECK(colours[i] == alone.colour);
  }
  CHECK_THROWS_WITH_AS(renderer.render(scene, {cameras, 3}, settings, {frames.data(), 2}),
                       "render: the number of frames is 2, expected 3, one a camera", std::invalid_argument);
}

TEST_CASE_TEMPLATE("views: a frame of no views is refused and the next is drawn", B, SWIFTGS_TEST_BACKENDS) {
  Usual<B> together(make_backend<B>()), alone(make_backend<B>());
  const auto scene = together.backend().upload(random_scene(100, 1, 7));
  CHECK_THROWS_WITH_AS(together.render_into(scene.view(), Span<const View>{}),
                       "frame: the number of views is 0, expected 1 to 65536", std::invalid_argument);
  check_views<OnHost>(together, alone, scene.view(), different_views());
}

TEST_CASE_TEMPLATE("views: a frame that fills tiles beyond measure is refused and the next is drawn", B,
                   SWIFTGS_TEST_BACKENDS) {
  Usual<B> together(make_backend<B>()), alone(make_backend<B>());
  const auto scene = together.backend().upload(random_scene(100, 1, 8));
  const Camera huge = forward_camera(max_image_side, max_image_side);
  const View view = make_view(huge, Conventions(), {.width = huge.width, .height = huge.height});
  const std::vector<View> views(129, view);
  CHECK_THROWS_WITH_AS(together.render_into(scene.view(), Span<const View>{views.data(), views.size()}),
                       "tiles in one frame: 2164260864 needed, the limit is 2147483648", CapacityError);
  check_views<OnHost>(together, alone, scene.view(), different_views());
}

TEST_CASE_TEMPLATE("views: bad ones are refused by all calls and those that were set are recorded", B,
                   SWIFTGS_TEST_BACKENDS) {
  Usual<B> renderer(make_backend<B>()), other(make_backend<B>());
  const auto scene = renderer.backend().upload(random_scene(400, 1, 9));
  check_bad_views<OnHost>(renderer, other, scene.view());
}

TEST_CASE_TEMPLATE("views: recorded frames follow formats and planes and places that change", B,
                   SWIFTGS_TEST_BACKENDS) {
  Usual<B> renderer(make_backend<B>()), other(make_backend<B>());
  const auto scene = renderer.backend().upload(random_scene(2000, 1, 10));
  check_changing_views<OnHost>(renderer, other, scene.view(), [&](FrameReport* report) {
    return [&, report] { renderer.record(scene.view(), report); };
  });
}
