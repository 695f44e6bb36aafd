// SPDX-License-Identifier: Apache-2.0

// Frames of several views and of parts of an image, on every backend.
#include "policies/views.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "policies/image_parts.hpp"
#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"

namespace swiftgs::test::views_test {

namespace {

/// Two renderers of the same policies.
template <class B>
struct Two {
  BoundRenderer<B> together, alone;

  auto upload(const Scene& scene) { return together.backend().upload(scene); }
};

template <class B, class Raster = AxisSharedThreshold<FloatCholesky>, class Sort = EarlySort,
          class Bounds = Ellipse>
Two<B> two_with() {
  const auto raster = raster_stage<B, Raster>();
  return {renderer_with<B, Sort, Bounds>(raster), renderer_with<B, Sort, Bounds>(raster)};
}

/// Faint Gaussians that all end near a border, where rounding decides whether a pixel shows them.
Scene bordered_scene(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  const ViewConstants constants = view_constants(bordered_camera(), Conventions::gsplat());
  Scene scene;
  for (std::size_t i = 0; i < count; ++i) {
    const Gaussian g = ends_near_a_border(random, constants);
    scene.means.push_back(g.mean), scene.scales.push_back(g.scale), scene.rotations.push_back(g.rotation);
    scene.opacities.push_back(g.opacity), scene.sh0.push_back(vec3(1));
  }
  return scene;
}

/// One image of 4096 x 16 pixels among fifty of 16 x 16: most tile numbers belong to no view.
std::vector<AskedView> one_wide_among_small() {
  std::vector<AskedView> views;
  for (int i = 0; i < 51; ++i)
    views.push_back({i == 20 ? forward_camera(4096, 16, 60) : turned_camera(16, 16, 0.01 * i, 0.05 * i)});
  return views;
}

/// Three hundred views of 1 to 20 pixels a side.
std::vector<AskedView> tiny_views() {
  std::vector<AskedView> views;
  for (int i = 0; i < 300; ++i) {
    AskedView view{turned_camera(1 + i % 20, 1 + i * 7 % 20, 0.002 * i, 0.003 * i)};
    view.format = pixel_formats[std::size_t(i) % std::size(pixel_formats)];
    view.occluder = i % 3 == 0, view.over = i % 5 == 0, view.depth = i % 2 == 0;
    views.push_back(view);
  }
  return views;
}

/// Views that ask for different planes: none, some, all, at centres and along the ray.
std::vector<AskedView> different_planes() {
  std::vector<AskedView> views = different_views();
  views[0].further = {.squared_depth = true, .features = 2};
  views[1].further = {.first_depth = true, .id = true};
  views[2].further = all_planes(5);
  views[4].further = all_planes(20);  // more than one pass sums
  views[4].upward = 0b10101010001;
  AskedView features{turned_camera(90, 33, 0.1, 0.2)};
  features.colour = features.alpha = false, features.further.features = 5;
  views.push_back(features);
  AskedView normals{turned_camera(33, 90, -0.1, 0.2)};
  normals.further.normal = normals.further.median_id = normals.further.median_depth = true;
  views.push_back(normals);
  AskedView ray = views[4], lean{turned_camera(64, 48, 0.2, 0.4), along_ray(Conventions::inria())};
  ray.conventions = along_ray();
  views.push_back(ray), views.push_back(lean);
  return views;
}

/// Calls f(two) with two renderers of each of `FewestRastersOf`.
template <class B, class F>
void for_each_raster_renderer(const F& f) {
  with_each_raster<B, std::type_identity_t, FewestRastersOf<B>>([&](const BoundRaster<B>& raster) {
    f(Two<B>{renderer_with<B>(raster), renderer_with<B>(raster)});
  });
}

}  // namespace

SWIFTGS_CONTRACT("views: a frame of several has the bits of each view alone") {
  for_each_raster_renderer<B>([&](auto&& two) {
    const auto scene = two.upload(random_scene(400, 2, 1));
    check_lists_of_views(two.together, two.alone, scene.view());
  });
}

SWIFTGS_CONTRACT("views: a frame of several that ask for different planes has the bits of each view alone") {
  for_each_raster_renderer<B>([&](auto&& two) {
    const auto scene = two.upload(with_features(random_scene(400, 2, 1), 20));
    const std::vector<AskedView> all = different_planes();
    check_views(two.together, two.alone, scene.view(), all);
    check_views(two.together, two.alone, scene.view(), {all[5], all[0], all[4]});
    check_views(two.together, two.alone, scene.view(), {all[2], all[2], all[7], all[8], all[8]});
    check_views(two.together, two.alone, scene.view(), {all[3]});  // none of them behind frames with all
  });
}

SWIFTGS_CONTRACT("views: every list of a view is that of the view alone with each sort and bounds") {
  for_each_type(AllSorts(), [&]<class Sort>(Sort) {
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
      CAPTURE(Sort::name);
      CAPTURE(Bounds::name);
      Two<B> two = two_with<B, PerPixel, Sort, Bounds>();
      const auto scene = two.upload(random_scene(2000, 0, 3));
      check_lists(two.together, two.alone, scene.view());
      // One renderer may go from frames of one view to frames of many, and the other way.
      if (on_host<B> || has_shaders<B>) return check_lists(two.together, two.together, scene.view());
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
  check(two_with<B, PerPixel, StandardSort, ThreeSigmaSquare>());
  Two<B> two = two_with<B>();
  const auto scene = two.upload(with_features(random_scene(400, 1, 2), 20));
  for (const std::size_t at : {4, 7})
    for (const auto& [columns, rows] :
         {std::pair<std::vector<int>, std::vector<int>>{{0}, every(75, 16)}, {{0, 16, 48}, {0, 32}}})
      check_parts(two.together, scene.view(), different_planes()[at], cut(100, 75, columns, rows));
}

SWIFTGS_CONTRACT("views: parts show the pixels that rounding keeps beyond the box of a splat") {
  const AskedView asked{bordered_camera()};
  const std::vector<Part> parts = cut(48, 48, {0, 16}, {0, 16});
  const auto check = [&](auto&& two) {
    for (std::uint64_t seed = 0; seed < 20; ++seed)
      check_parts(two.together, two.upload(bordered_scene(2000, seed)).view(), asked, parts);
  };
  for_each_raster_renderer<B>(check);
  check(two_with<B, PerPixel, EarlySort, ThreeSigmaSquare>());
}

SWIFTGS_CONTRACT("views: one wide view among fifty small ones has the bits of each alone") {
  Two<B> two = two_with<B>();
  const auto scene = two.upload(random_scene(300, 1, 3));
  check_views(two.together, two.alone, scene.view(), one_wide_among_small());
}

SWIFTGS_CONTRACT("views: hundreds and thousands of tiny views have the bits of each alone") {
  const auto check = [](auto&& two) {
    const auto scene = two.upload(random_scene(100, 1, 4));
    check_views(two.together, two.alone, scene.view(), tiny_views());
    check_many_rows(two.together, two.upload(random_scene(10, 1, 12)), has_shaders<B> ? 1000 : 11'000);
  };
  if constexpr (on_host<B>)
    check(two_with<B>());
  else
    for_each_raster_renderer<B>(check);  // the rows of a device's grid are few
}

SWIFTGS_CONTRACT("views: several views of an empty scene are their backgrounds") {
  Two<B> two = two_with<B>();
  check_views(two.together, two.alone, two.upload(Scene()).view(), different_views());
}

SWIFTGS_CONTRACT("views: frames for several cameras are the frames of each camera in every plane") {
  Two<B> two = two_with<B>();
  auto& renderer = two.together;
  const auto scene = two.upload(with_features(random_scene(300, 1, 6), 4));
  const Camera cameras[] = {forward_camera(50, 40), turned_camera(33, 17, 0.2, 0.3), forward_camera(16, 16)};
  const RenderSettings settings = settings_of(all_planes(3), vec3(0.1f, 0.2f, 0.3f));
  std::vector<Frame> frames(std::size(cameras));
  renderer.render(scene, {cameras, std::size(cameras)}, settings, span_of(frames));
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
    CHECK(same_planes(frames[i], alone));
    CHECK(same_bits(colours[i], alone.colour));
  }
  CHECK_THROWS_WITH_AS(renderer.render(scene, {cameras, 3}, settings, {frames.data(), 2}),
                       "render: the number of frames is 2, expected 3, one a camera", std::invalid_argument);
}

SWIFTGS_CONTRACT("views: frames of none and of too many tiles are refused and the next is drawn") {
  Two<B> two = two_with<B>();
  const auto scene = two.upload(random_scene(100, 1, 8));
  CHECK_THROWS_WITH_AS(two.together.render_into(scene.view(), Span<const View>{}),
                       "frame: the number of views is 0, expected 1 to 65536", std::invalid_argument);
  check_views(two.together, two.alone, scene.view(), different_views());
  const Camera huge = forward_camera(max_image_side, max_image_side);
  const View view = make_view(huge, Conventions(), {.width = huge.width, .height = huge.height});
  const std::vector<View> views(129, view);
  CHECK_THROWS_WITH_AS(two.together.render_into(scene.view(), span_of(views)),
                       "tiles in one frame: 2164260864 needed, the limit is 2147483648", CapacityError);
  check_views(two.together, two.alone, scene.view(), different_views());
}

SWIFTGS_CONTRACT("views: bad ones are refused by all calls and those that were set are recorded") {
  Two<B> two = two_with<B>();
  auto& renderer = two.together;
  const B& on = renderer.backend();
  const auto scene = two.upload(random_scene(400, 1, 9));
  const std::vector<AskedView> asked = different_views();
  std::vector<AskedView> moved = asked;
  for (AskedView& view : moved) view.camera.translation.x += 0.1, view.background = vec3(0.5f);
  const auto expected_first = draw_together(two.alone, scene.view(), asked),
             expected_second = draw_together(two.alone, scene.view(), moved);
  REQUIRE(differing(expected_first, expected_second) == asked.size());
  Report<B> report;

  struct Spoilt {
    const char* why;
    void (*spoil)(View&);
  };
  const Spoilt all[] = {
      {"background is nan in channel 1", [](View& view) { view.background.y = std::nanf(""); }},
      {"background is -inf in channel 2",
       [](View& view) { view.background.z = -std::numeric_limits<float>::infinity(); }},
      {"number of rows is 4, expected 3", [](View& view) { view.grid.rows.end += 1; }},
      {"number of columns is 5, expected 4", [](View& view) { view.grid.columns.begin = -1; }},
      {"first of the columns is -1, expected 0 or more",
       [](View& view) { --view.grid.columns.begin, --view.grid.columns.end; }},
      {"side is 24, expected a power of two", [](View& view) { view.grid.side = 24; }},
      {"side is -16, expected a power of two", [](View& view) { view.grid.side = -16; }}};
  for (const Spoilt& spoilt : all) {
    CAPTURE(std::string(spoilt.why));
    const doctest::Contains why(spoilt.why);
    PlacedViews before(on, asked), after(on, moved);
    renderer.reserve(scene.view(), before.span());
    std::vector<View> bad = after.views;
    spoilt.spoil(bad[3]);
    const Span<const View> views{bad.data(), bad.size()};
    CHECK_THROWS_WITH_AS(renderer.render_into(scene.view(), views), why, std::invalid_argument);
    CHECK_THROWS_WITH_AS(renderer.set_views(views), why, std::invalid_argument);
    renderer.record(scene.view(), report.data());
    CHECK(differing(before.finish(on), expected_first) == 0);
    renderer.set_views(after.span());
    renderer.record(scene.view(), report.data());
    CHECK(differing(after.finish(on), expected_second) == 0);
    CHECK_THROWS_WITH_AS(renderer.reserve(scene.view(), views), why, std::invalid_argument);
    CHECK_THROWS_WITH_AS(renderer.record(scene.view(), report.data()),
                         doctest::Contains("expected reserve before record"), std::invalid_argument);
  }
}

TEST_CASE_TEMPLATE("views: recorded frames follow formats and planes and places that change", B,
                   SWIFTGS_TEST_HOSTS) {
  Two<B> two = two_with<B>();
  const auto scene = two.upload(random_scene(2000, 1, 10));
  check_changing_views(two.together, two.alone, scene.view(), [&](FrameReport* report) {
    return [&, report] { two.together.record(scene.view(), report); };
  });
}

}  // namespace swiftgs::test::views_test
