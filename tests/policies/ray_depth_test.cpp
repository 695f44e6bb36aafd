// SPDX-License-Identifier: Apache-2.0

// Depth along the ray: planes of depth and occluders where a splat's depth varies over it.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>

#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::ray_depth_test {

namespace {

/// Depths of a surface that no splat follows.
std::vector<float> waves(const Camera& camera, float near, float far) {
  std::vector<float> depths;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      depths.push_back(near + (far - near) * (0.5f + 0.5f * std::sin(0.3f * float(x) + 0.2f * float(y))));
  return depths;
}

template <class B>
Frame draw(BoundRenderer<B>& renderer, const Scene& scene, const Camera& camera,
           const Conventions& conventions, const std::vector<float>& occluder = {}, bool planes = true,
           bool count = false) {
  RenderSettings settings = settings_of_all(scene.feature_channels, conventions);
  if (!planes) settings.outputs = {};
  settings.count = count;
  return draw_over_sevens(renderer, renderer.backend().upload(scene), camera, settings, occluder);
}

/// A plane z = `middle` + `across` x + `down` y of camera space, and flat cards that cover it.
struct Wall {
  double middle, across, down;

  vec3 at(double x, double y) const {
    return vec3(float(x), float(y), float(middle + across * x + down * y));
  }
  /// Its depth at a pixel, through a pinhole and through an orthographic lens.
  double depth(const Camera& camera, int column, int row) const {
    const double u = (column + 0.5 - camera.cx) / camera.fx, v = (row + 0.5 - camera.cy) / camera.fy;
    const double along = across * u + down * v;
    return camera.lens.model == LensModel::orthographic ? middle + along : middle / (1 - along);
  }
  /// Cards of this standard deviation, a deviation apart, within `half` of the axis.
  Scene cards(double half, double size) const {
    // Turns z to the wall's normal, (-across, -down, 1).
    const double length = std::sqrt(across * across + down * down + 1), w = std::sqrt((1 + 1 / length) / 2);
    const Quaternion turned{float(w), float(down / length / (2 * w)), float(-across / length / (2 * w)), 0};
    Scene scene;
    for (double y = -half; y <= half; y += size)
      for (double x = -half; x <= half; x += size) {
        append(scene, at(x, y), float(size), 0.6f);
        scene.scales.back().z = 0, scene.rotations.back() = turned;
      }
    return scene;
  }
};

/// Of `found` from the wall's depth, in parts of it, where the frame is nearly opaque.
struct DepthError {
  double root_mean_square = 0, worst = 0;

  DepthError(const Wall& wall, const Camera& camera, const Frame& frame, const std::vector<float>& found) {
    std::size_t pixels = 0;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const std::size_t i = std::size_t(y) * std::size_t(camera.width) + std::size_t(x);
        if (frame.alpha[i] < 0.9f) continue;
        const double wanted = wall.depth(camera, x, y), error = std::abs(double(found[i]) / wanted - 1);
        root_mean_square += error * error, worst = std::max(worst, error), ++pixels;
      }
    CHECK(pixels == frame.pixels());
    root_mean_square = std::sqrt(root_mean_square / double(pixels));
  }
};

}  // namespace

SWIFTGS_CONTRACT("ray depth: an occluder hides where splats are behind it and not the splats behind those") {
  const Scene scene = with_features(make_builtin_scene(8'000), 20);  // more than one pass sums
  const Camera camera = scaled(builtin_camera(), 0.1);
  const std::vector<float> occluder = waves(camera, 2, 7);
  const ReferencePlanes expected = render_reference_planes(scene, camera, along_ray(), 0, span_of(occluder));
  with_each_renderer<B>([&](BoundRenderer<B>& renderer, std::string_view raster) {
    if (stores_half(raster)) return;
    const Frame frame = draw(renderer, scene, camera, along_ray(), occluder);
    check_planes(frame, expected, plane_bounds<B>(along_ray(), raster), 0.05);
    CHECK(frame.alpha != draw(renderer, scene, camera, {}, occluder).alpha);
    // Colour alone, and counted.
    for (const bool count : {false, true})
      CHECK(draw(renderer, scene, camera, along_ray(), occluder, false, count).colour == frame.colour);
    CHECK(renderer.statistics().raster.contributing_pairs > 0);
  });
}

SWIFTGS_CONTRACT("ray depth: cards of a wall have its depth") {
  Usual<B> renderer(make_backend<B>());
  const Wall wall{6, 0.7, -0.5};
  Camera camera = forward_camera(96, 64, 120);
  struct Errors {
    DepthError mean, first, median;
  };
  const auto errors = [&](double size, const Conventions& conventions) {
    const Frame frame = draw(renderer, wall.cards(4, size), camera, conventions);
    const auto of = [&](const std::vector<float>& depth) { return DepthError(wall, camera, frame, depth); };
    return Errors{of(frame.depth), of(frame.first_depth), of(frame.median_depth)};
  };
  // Slopes are those of the image at a card's centre, and blur makes them less.
  const Errors ray = errors(0.3, along_ray()), centre = errors(0.3, {});
  CHECK(ray.mean.root_mean_square <= 2.5e-3);
  CHECK(centre.mean.root_mean_square >= 3e-2);
  CHECK(ray.mean.worst <= 4e-3);
  CHECK(ray.first.worst <= 1.5e-2);
  CHECK(centre.first.worst >= 1e-1);
  CHECK(ray.median.worst <= 4e-3);
  CHECK(centre.median.worst >= 5e-2);
  const Errors smaller = errors(0.15, along_ray());
  CHECK(smaller.mean.root_mean_square <= 1.5e-3);
  CHECK(smaller.first.worst <= 8e-3);

  // Without perspective and blur no error is left but rounding.
  camera.lens.model = LensModel::orthographic, camera.fx = camera.fy = 24;
  CHECK(errors(0.3, along_ray()).mean.worst <= 5e-4);
  Conventions sharp = along_ray();
  sharp.blur = 0;
  const Errors exact = errors(0.3, sharp);
  const double slack = on_host<B> ? 1 : 4;
  CHECK(exact.mean.worst <= 1e-6 * slack);
  CHECK(exact.first.worst <= 5e-7 * slack);
  CHECK(exact.median.worst <= 5e-7 * slack);
}

SWIFTGS_CONTRACT("ray depth: a mesh cuts cards along the line where their walls meet") {
  Usual<B> renderer(make_backend<B>());
  const Wall wall{6, 0.7, -0.5}, mesh{6.1, -0.4, 0.3};
  const Camera camera = forward_camera(96, 64, 120);
  const Scene scene = wall.cards(4, 0.3);
  std::vector<float> occluder;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) occluder.push_back(float(mesh.depth(camera, x, y)));
  const Frame whole = draw(renderer, scene, camera, {});
  // Light that is missing where the wall lies in front of the mesh, or shows where it lies behind.
  const auto wrong = [&](const Conventions& conventions) {
    const Frame cut = draw(renderer, scene, camera, conventions, occluder);
    double sum = 0;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const std::size_t i = std::size_t(y) * std::size_t(camera.width) + std::size_t(x);
        const bool in_front = wall.depth(camera, x, y) < mesh.depth(camera, x, y);
        sum += std::abs(double(cut.alpha[i]) - (in_front ? double(whole.alpha[i]) : 0.0));
      }
    return sum / double(whole.pixels());
  };
  CHECK(wrong(along_ray()) <= 3e-3);
  CHECK(wrong({}) >= 3e-2);
}

SWIFTGS_CONTRACT("ray depth: needles and giants and extreme numbers stay finite, at centres too") {
  Random random(3);
  Scene scene = random_scene(300, 0, 4);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (i % 6 == 0) scene.scales[i] = vec3{random.f(1, 30), random.f(1e-6, 1e-3), random.f(1e-6, 1e-3)};
    if (i % 6 == 1) scene.scales[i] = vec3(1e-38f, 1e-20f, 0.5f);
    if (i % 6 == 2) scene.scales[i] = vec3(1e10f, 0.5f, 1e-10f);
    if (i % 6 == 3) scene.scales[i] = vec3(0), scene.means[i].z = 0.011f;
    if (i % 6 == 4) scene.scales[i].z = 0;
    if (i % 60 == 5) scene.scales[i] = vec3(1e16f), scene.means[i].z = 1e9f;
  }
  Usual<B> renderer(make_backend<B>());
  for (const double far : {1e10, 1e38})
    for (const float blur : {0.3f, 0.0f}) {
      const Camera camera = forward_camera(60, 44);
      for (Conventions conventions : {along_ray(), Conventions()}) {
        conventions.far_plane = float(far), conventions.blur = blur;
        for (const std::vector<float>& occluder : {std::vector<float>(), waves(camera, 2, 7)})
          CHECK(is_finite(draw(renderer, scene, camera, conventions, occluder)));
      }
      if (far == 1e10)
        scene.means[0].z = scene.means[7].z = 3e37f, scene.scales[0] = scene.scales[7] = vec3(1e37f);
    }
}

SWIFTGS_CONTRACT("ray depth: recorded frames refuse another depth than was reserved") {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(random_scene(400, 0, 3));
  const Camera camera = forward_camera(60, 44);
  PlanesOn<B> on(renderer.backend(), 60, 44, all_planes(), 7);
  View view = make_view(camera, along_ray(), on.view());
  for (const Conventions& other : {Conventions(), along_ray()}) {
    renderer.reserve(scene.view(), {&view, 1});
    view = make_view(camera, other, on.view());
    CHECK_THROWS_AS(renderer.set_views({&view, 1}), std::invalid_argument);
  }
}

}  // namespace swiftgs::test::ray_depth_test
