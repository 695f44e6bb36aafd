// SPDX-License-Identifier: Apache-2.0

// Values of the planes beside colour, alpha and depth, on every backend.
#include "policies/planes.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include <swiftgs/metrics.hpp>

#include "policies/contribution_sums.hpp"
#include "policies/lenses.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::planes_test {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// The planes of a scene through the usual renderer.
template <class B>
Frame draw_all(const Scene& scene, const Camera& camera, const Conventions& conventions = {}) {
  Usual<B> renderer(test::make_backend<B>());
  return renderer.render(renderer.backend().upload(scene), camera,
                         settings_of_all(scene.feature_channels, conventions));
}

/// Checks the planes of a scene through the usual renderer.
template <class B>
void check_all(const Scene& scene, const Camera& camera, const Conventions& conventions = {}) {
  const Frame frame = draw_all<B>(scene, camera, conventions);
  check_planes(frame, render_reference_planes(scene, camera, conventions), plane_bounds<B>(conventions));
}

/// Whether all pixels hold what pixels without splats do.
bool is_empty(const Frame& frame) {
  bool empty = true;
  for_each_plane(
      [&]<class T>(std::size_t, const std::vector<T>& values) {
        const T nothing = std::is_same_v<T, std::uint32_t> ? T(no_gaussian) : T(0);
        for (const T value : values) empty = empty && value == nothing;
      },
      frame);
  return empty;
}

}  // namespace

SWIFTGS_CONTRACT("planes: each is that of the reference by every rasterizer, at centres and along the ray") {
  const Scene usual = with_features(random_scene(400, 1, 5), 5);
  const Scene dense = with_features(make_builtin_scene(8'000), 4);
  const Camera usual_camera = forward_camera(67, 45), dense_camera = scaled(builtin_camera(), 0.1);
  for (const Conventions& conventions : {Conventions(), along_ray()}) {
    const ReferencePlanes of_usual = render_reference_planes(usual, usual_camera, conventions);
    const ReferencePlanes of_dense = render_reference_planes(dense, dense_camera, conventions);
    with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view raster) {
      const auto check = [&](const Scene& scene, const Camera& camera, const ReferencePlanes& expected) {
        const auto on = renderer.backend().upload(scene);
        const RenderSettings settings = settings_of_all(scene.feature_channels, conventions);
        const Frame frame = draw_over_sevens(renderer, on, camera, settings);
        const PlaneBounds bounds = plane_bounds<B>(conventions, raster);
        if (!stores_half(raster)) return check_planes(frame, expected, bounds);
        CHECK(psnr(frame.normal, expected.normal) > 45);
        CHECK(psnr(frame.features, expected.features) > 40);
        if (conventions.depth_at == Conventions::DepthAt::ray) return;
        CHECK(plane_errors(frame, expected, plane_bounds<B>()).wrong_picks <= frame.pixels() / 20);
      };
      check(usual, usual_camera, of_usual);
      check(dense, dense_camera, of_dense);
    });
  }
}

SWIFTGS_CONTRACT("planes: each is that of the reference through every lens, at centres and along the ray") {
  const Scene scene = with_features(make_builtin_scene(8'000), 3);
  using enum Conventions::Depth;
  for (const Camera& camera : cameras_of_lenses()) {
    CAPTURE(name_of(camera.lens.model));
    CAPTURE(camera.lens.is_distorted());
    const LensModel model = camera.lens.model;
    const bool sees_behind = model == LensModel::fisheye || model == LensModel::equirectangular;
    for (const auto depth : {of_lens, distance}) {
      CAPTURE(int(depth));
      Conventions conventions;
      conventions.depth = depth;
      check_all<B>(scene, camera, conventions);
    }
    for (const auto depth : {z, distance}) {
      // At right angles to the axis z changes fast, and is next to nothing.
      if (sees_behind && depth == z) continue;
      CAPTURE(int(depth));
      Conventions conventions = along_ray();
      conventions.depth = depth;
      check_all<B>(scene, camera, conventions);
    }
  }
}

SWIFTGS_CONTRACT("planes: each is that of the reference from every side and by other conventions") {
  const Scene scene = with_features(random_scene(600, 2, 6), 2);
  for (const dvec3 eye : {dvec3(-3, 1, 4), dvec3(0.5, -4, 9), dvec3(2, 0.2, 14)}) {
    Camera camera = look_at(eye, dvec3(0.1, 0, 6), dvec3(0.1, -1, 0.2), 0.9, 80, 60);
    for (Conventions conventions : {Conventions::gsplat(), Conventions::inria()}) {
      conventions.footprint = Conventions::Footprint::alpha, conventions.antialiased = eye.y > 0;
      check_all<B>(scene, camera, conventions);
    }
    camera.rotation = dmat3(dvec3(-1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)) * camera.rotation;  // a mirror
    camera.translation.x *= -1;
    check_all<B>(scene, camera);
  }
}

SWIFTGS_CONTRACT("planes: long lists are those of the reference") {
  Random random(6000);
  Scene scene = random_scene(6'000, 0, 6);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const float z = 2 + 8 * float(i) / float(scene.size());
    scene.means[i] = vec3(random.f(-0.2, 0.2) * z, random.f(-0.2, 0.2) * z, z);
    scene.scales[i] = vec3(0.5f * z, random.f(0.3, 0.6) * z, 0.01f);
    // Some are strong enough to decide what pixels remember, in many segments of the lists.
    scene.opacities[i] = i % 450 == 300 ? random.f(0.1, 0.3) : float(random.scale(1e-4, 4e-4));
  }
  scene = with_features(std::move(scene), 5);
  Conventions conventions;
  conventions.alpha_min = 2e-5f;
  const Camera camera = forward_camera(48, 40);
  const ReferencePlanes expected = render_reference_planes(scene, camera, conventions);
  // Thousands of alphas are near their threshold, and weights nearly equal.
  PlaneBounds bounds = plane_bounds<B>();
  bounds.threshold = 0, bounds.pick = 2e-5, bounds.sum *= 2, bounds.mean *= 2;
  const PlaneErrors errors = plane_errors(draw_all<B>(scene, camera, conventions), expected, bounds);
  check_sums(errors, bounds);
  CHECK(errors.wrong_picks <= 2);
  for (const std::size_t close : {errors.at_first, errors.at_median, errors.at_id})
    CHECK(double(close) <= 0.3 * double(expected.pixels()));
}

SWIFTGS_CONTRACT("planes: splats of a colour that is not finite are in none and are not picked") {
  const Scene scene = with_features(scene_with_colourless(400, 4), 3);
  Scene without = scene;
  for (std::size_t i = 0; i < scene.size(); i += 10) without.opacities[i] = 0;
  const Camera camera = forward_camera(60, 44);
  Usual<B> renderer(std::move(backend));
  const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings_of_all(3));
  check_planes(frame, render_reference_planes(scene, camera, {}), plane_bounds<B>());
  const std::vector<PickedPixel> picked = pick_all(renderer, camera);
  CHECK(same_planes(frame, draw_all<B>(without, camera)));
  renderer.render(renderer.backend().upload(without), camera);
  CHECK(picked == pick_all(renderer, camera));
}

SWIFTGS_CONTRACT("planes: pixels without splats hold 0 and no Gaussian") {
  Usual<B> renderer(std::move(backend));
  const Camera camera = forward_camera(40, 30);
  const auto draw = [&](const Scene& scene) {
    return draw_over_sevens(renderer, renderer.backend().upload(scene), camera, settings_of_all(4));
  };
  CHECK(is_empty(draw(with_features(Scene(), 4))));
  CHECK(renderer.statistics().visible == 0);
  CHECK(renderer.statistics().intersections_a_visible() == 0);
  CHECK(renderer.pick(39, 29) == PickedPixel());
  Scene dot;
  append(dot, vec3(0, 0, 2), 0.02f, 0.9f);
  dot = with_features(std::move(dot), 4);
  const Frame frame = draw(dot);
  check_planes(frame, render_reference_planes(dot, camera, {}), plane_bounds<B>());
  const std::ptrdiff_t shown = std::count(frame.id.begin(), frame.id.end(), 0u);
  CHECK(shown > 3);
  CHECK(shown < 100);
  CHECK(std::count(frame.id.begin(), frame.id.end(), no_gaussian) + shown == 40 * 30);
}

SWIFTGS_CONTRACT("planes: any number of features up to the scene's are the first of them") {
  const Scene scene = with_features(random_scene(300, 0, 7), 17);
  const Camera camera = forward_camera(50, 37);
  Usual<B> renderer(std::move(backend));
  const auto on = renderer.backend().upload(scene);
  const auto features = [&](int channels, bool others) {
    RenderSettings settings;
    if (others) settings.outputs = all_planes();
    settings.outputs.features = channels;
    return renderer.render(on, camera, settings);
  };
  const Frame all = features(17, true);
  check_planes(all, render_reference_planes(scene, camera, {}), plane_bounds<B>());
  for (const int channels : {1, 2, 3, 4, 5, 17})
    for (const bool others : {false, true}) {
      CAPTURE(channels);
      CAPTURE(others);
      const Frame some = features(channels, others);
      CHECK(some.feature_channels == channels);
      REQUIRE(some.features.size() == std::size_t(channels) * some.pixels());
      std::size_t different = 0;
      for (std::size_t i = 0; i < some.features.size(); ++i) {
        const std::size_t pixel = i / std::size_t(channels), channel = i % std::size_t(channels);
        different += some.features[i] != all.features[17 * pixel + channel];
      }
      CHECK(different == 0);
    }
  CHECK(features(0, true).features.empty());
  CHECK_THROWS_WITH_AS(features(18, false), doctest::Contains("asks for 18 features a Gaussian, "),
                       std::invalid_argument);
  CHECK_THROWS_AS(features(1 << 30, false), std::invalid_argument);  // before memory is taken for them
  CHECK_THROWS_WITH_AS(features(-1, false), "render: the number of features is -1, expected 0 or more",
                       std::invalid_argument);
  const auto without = renderer.backend().upload(random_scene(5, 0, 1));
  CHECK_THROWS_WITH_AS(renderer.render(without, camera, settings_of_all(1)),
                       doctest::Contains("expected at most the 0 of the scene"), std::invalid_argument);
}

SWIFTGS_CONTRACT("planes: features that are not finite count as 0 and huge and negative ones are blended") {
  Scene scene = with_features(random_scene(300, 0, 8), 4);
  for (float& feature : scene.features) feature *= 5e37f;
  Scene tame = scene;
  const float bad[] = {infinity, -infinity, std::numeric_limits<float>::quiet_NaN()};
  for (std::size_t i = 0; i < scene.size(); i += 3)
    scene.features[4 * i + i % 4] = bad[i % 9 / 3], tame.features[4 * i + i % 4] = 0;
  Usual<B> renderer(std::move(backend));
  const auto on = renderer.backend().upload(tame);
  const Camera camera = forward_camera(60, 44);
  const auto draw = [&](const std::vector<float>& features) {
    const auto memory = to_backend(renderer.backend(), features);
    SceneView raw = on.view();
    raw.features = {memory.data(), raw.size(), 4 * sizeof(float)};
    return draw_over_sevens(renderer, raw, camera, settings_of_all(4));
  };
  const Frame frame = draw(scene.features);
  CHECK(same_planes(frame, draw(tame.features)));
  check_planes(frame, render_reference_planes(scene, camera, {}), plane_bounds<B>());
  CHECK(*std::min_element(frame.features.begin(), frame.features.end()) < -1e37f);

  // The largest of floats everywhere.
  const float largest = std::numeric_limits<float>::max();
  for (const float value : draw(std::vector<float>(scene.features.size(), largest)).features)
    CHECK((value >= 0 && value <= largest));
}

SWIFTGS_CONTRACT("planes: the first depth is of the splat that takes alpha above any first alpha") {
  const Scene scene = balls({{2, 0.25f}, {3, 0.5f}, {4, 0.5f}, {5, 0.875f}});  // alpha .25 .625 .8125 .98
  const auto first = [&](float first_alpha) {
    Conventions conventions = exact_conventions();
    conventions.first_alpha = first_alpha;
    return draw_all<B>(scene, middle_camera(), conventions).first_depth[middle_pixel];
  };
  CHECK(first(0) == 2);
  CHECK(first(0.05f) == 2);
  CHECK(first(0.25f) == 3);
  CHECK(first(0.3f) == 3);
  CHECK(first(0.625f) == 4);
  CHECK(first(0.9f) == 5);
  CHECK(first(0.99f) == 0);
  const Scene random = random_scene(600, 0, 9);
  const Camera camera = forward_camera(80, 60);
  for (const float first_alpha : {0.0f, 0.9f}) {
    Conventions conventions;
    conventions.first_alpha = first_alpha;
    check_all<B>(random, camera, conventions);
  }
}

SWIFTGS_CONTRACT("planes: further ones change no bit of others and no count, at centres and along the ray") {
  const Scene scene = with_features(random_scene(400, 1, 3), 4);
  const Camera camera = forward_camera(70, 45);
  std::vector<Outputs> some = each_plane(4);
  some.insert(some.end(), {all_planes(4), {.squared_depth = true, .median_depth = true}});
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view) {
    const auto on = renderer.backend().upload(scene);
    for (const Conventions& conventions : {Conventions(), along_ray()}) {
      RenderSettings settings = settings_of({true, true}, vec3(0.2f, 0.3f, 0.4f));
      settings.conventions = conventions, settings.count = true;
      const Frame plain = renderer.render(on, camera, settings);
      const RasterCounts counts = renderer.statistics().raster;
      settings.outputs = all_planes(4);
      const Frame all = renderer.render(on, camera, settings);
      CHECK(same_counts(renderer.statistics().raster, counts));
      CHECK(same_of(plain, all));
      for (std::size_t i = 0; i < some.size(); ++i)
        for (const bool count : {false, true}) {
          CAPTURE(i);
          settings.outputs = some[i], settings.count = count;
          CHECK(same_of(renderer.render(on, camera, settings), all));
        }
    }
  });
}

SWIFTGS_CONTRACT("planes: coarse tiles change no bit") {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(with_features(make_builtin_scene(2'000), 2));
  if constexpr (!on_host<B>) {
    // Few splats in many pixels: a device draws the second frame with coarser tiles.
    const Camera large = builtin_camera(2048, 1024);
    const RenderSettings settings = has_shaders<B> ? RenderSettings() : settings_of_all(2);
    const Frame first = renderer.render(scene, large, settings);
    CHECK(same_planes(renderer.render(scene, large, settings), first));
    CHECK(renderer.tiles().side > default_tile_side);
  }

  // Tiles of a view's own choice.
  const Camera small = forward_camera(100, 75);
  const auto draw = [&](int side) {
    PlanesOn<B> planes(renderer.backend(), 100, 75, all_planes(2), 7);
    View view = make_view(small, {}, planes.view());
    view.grid = TileGrid::covering(100, 75, side);
    renderer.render_into(scene.view(), {&view, 1});
    return planes.on_host(renderer.backend());
  };
  const Frame usual = draw(16);
  for (const int side : {32, 64, 512}) CHECK(same_planes(draw(side), usual));
}

}  // namespace swiftgs::test::planes_test
