// SPDX-License-Identifier: Apache-2.0

// Where lenses show points, with derivatives, limits and parts, against the oracle's formulas.
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/lens/limits.hpp>
#include <swiftgs/lens/point.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/project/project.hpp>

#include "reference/oracle_lens.hpp"

namespace swiftgs::test::lens_arithmetic_test {

namespace {

const double pi = std::acos(-1.0);

/// Where a lens shows a point, and the derivatives, by the oracle's formulas.
Sight exact(const Lens& lens, const dvec3& p) {
  const Dual x(p.x, {1, 0, 0}), y(p.y, {0, 1, 0}), z(p.z, {0, 0, 1});
  switch (lens.model) {
    case LensModel::perspective:
      return test::distorted(lens.distortion, {x / z, y / z});
    case LensModel::fisheye: {
      const Dual across = root(x * x + y * y), theta = angle(across, z);
      return test::distorted(lens.distortion, {theta * x / across, theta * y / across});
    }
    case LensModel::orthographic:
      return {x, y};
    case LensModel::equirectangular:
      return {angle(x, z), angle(y, root(x * x + z * z))};
  }
  return {};
}

/// A lens of each model, those that take distortion with and without.
std::vector<Lens> lenses() {
  const Distortion opencv{{-0.12, 0.03, -0.002, 0}, {0.01, 0.002, 0.0001}, {0.004, -0.003}, {}};
  const Distortion thin_prism{{0.03, -0.004, 0.0005, -0.00002}, {}, {0.002, 0.001}, {-0.003, 0.002}};
  return {{LensModel::perspective, {}},  {LensModel::perspective, opencv},
          {LensModel::fisheye, {}},      {LensModel::fisheye, thin_prism},
          {LensModel::orthographic, {}}, {LensModel::equirectangular, {}}};
}

Camera camera_with(const Lens& lens, int width = 640, int height = 480) {
  Camera camera;
  camera.width = width, camera.height = height, camera.lens = lens;
  camera.fx = camera.fy = lens.model == LensModel::equirectangular ? width / (2 * pi) : 300;
  camera.cx = 0.5 * width, camera.cy = 0.5 * height;
  return camera;
}

/// The fold found by stepping: the first of many radii at which the next shows nearer to the axis.
double fold_by_steps(const Distortion& d, double most) {
  constexpr int steps = 200'000;
  Real before = 0;
  for (int i = 1; i <= steps; ++i) {
    const Real radius = most * i / steps, shown = test::distorted(d, {radius, 0}).u.value;
    if (shown < before) return double(most * (i - 1) / steps);
    before = shown;
  }
  return most;
}

}  // namespace

TEST_CASE("lens: points and derivatives are those of the formulas") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> in(-3, 3);
  for (const Lens& lens : lenses()) {
    CAPTURE(name_of(lens.model));
    CAPTURE(lens.is_distorted());
    const LensLimits limits = lens_limits(camera_with(lens, 100'000, 100'000), Conventions::gsplat());
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
      const dvec3 p(in(random), in(random), in(random));
      const LensPoint at = point_through(lens, limits, p);
      if (!at.inside || (lens.model == LensModel::perspective && p.z < 0.05)) continue;  // within the limits
      ++inside;
      const Sight wanted = exact(lens, p);
      const double scale = 1 + std::fabs(at.u) + std::fabs(at.v);
      CHECK(std::fabs(double(wanted.u.value) - at.u) <= 1e-13 * scale);
      CHECK(std::fabs(double(wanted.v.value) - at.v) <= 1e-13 * scale);
      const double size = std::sqrt(dot(at.du, at.du)) + std::sqrt(dot(at.dv, at.dv));
      for (int k = 0; k < 3; ++k) {
        CHECK(std::fabs(double(wanted.u.by[std::size_t(k)]) - at.du[k]) <= 1e-7 * size);
        CHECK(std::fabs(double(wanted.v.by[std::size_t(k)]) - at.dv[k]) <= 1e-7 * size);
      }
    }
    CHECK(inside >= 300);
  }
}

TEST_CASE("lens: bounds of a box hold what the lens shows of its points") {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> in(-1, 1);
  const auto direction = [&] { return dvec3(in(random), in(random), in(random)); };
  for (const Lens& lens : lenses()) {
    CAPTURE(name_of(lens.model));
    CAPTURE(lens.is_distorted());
    const LensLimits limits = lens_limits(camera_with(lens, 100'000, 100'000), Conventions::gsplat());
    int outside = 0, bounded = 0;
    for (int i = 0; i < 3000; ++i) {
      // About two corners: often one is near, and both are in one direction.
      const double spread = std::exp(-5 * std::fabs(in(random))), deep = std::exp(-3 * std::fabs(in(random)));
      const dvec3 far = direction(), near = deep * (far + spread * direction());
      CameraBox box{0.5 * (far + near), 0.5 * (far - near)};
      for (int k = 0; k < 3; ++k) box.half[k] = std::fabs(box.half[k]);
      const LensBox bounds = box_through(lens, limits, box);
      bounded += bounds.bounded && bounds.inside;
      for (int n = 0; n < 20; ++n) {
        dvec3 of_corners = n == 0 ? near : box.centre;
        for (int k = 0; k < 3 && n > 0; ++k) of_corners[k] += in(random)*box.half[k];
        const LensPoint at = point_through(lens, limits, of_corners);
        if (!at.inside) continue;
        outside += !bounds.inside;
        if (!bounds.bounded) continue;
        const double turn = lens.model == LensModel::equirectangular ? 2 * pi : INFINITY;
        outside += std::fabs(std::remainder(at.u - bounds.u, turn)) > bounds.half_u + 1e-9;
        outside += std::fabs(at.v - bounds.v) > bounds.half_v + 1e-9;
        outside += std::sqrt(dot(at.du, at.du)) > bounds.du * (1 + 1e-9);
        outside += std::sqrt(dot(at.dv, at.dv)) > bounds.dv * (1 + 1e-9);
      }
    }
    CHECK(outside == 0);
    CHECK(bounded > 500);
  }
}

TEST_CASE("lens: splats land within 1e-3 pixels of their points in images of 4096 pixels") {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> in(-3, 3);
  for (const Lens& lens : lenses()) {
    CAPTURE(name_of(lens.model));
    CAPTURE(lens.is_distorted());
    Camera camera = camera_with(lens, 4096, 4096);
    if (lens.model != LensModel::equirectangular) camera.fx = camera.fy = 1500;
    if (lens.model == LensModel::orthographic) camera.fx = camera.fy = 700;
    const ViewConstants view = view_constants(camera, Conventions::gsplat());
    int visible = 0;
    for (int i = 0; i < 4000; ++i) {
      const vec3 p(float(in(random)), float(in(random)), float(in(random)));
      const ProjectedShape splat = project_shape(view, {p, vec3(1e-5f), {}, 0.9f});
      if (!splat.visible) continue;
      ++visible;
      const Sight wanted = exact(lens, dvec3(p));
      CHECK(std::fabs(camera.fx * double(wanted.u.value) + camera.cx - splat.shape.exact_mean().x) <= 1e-5);
      CHECK(std::fabs(camera.fy * double(wanted.v.value) + camera.cy - splat.shape.exact_mean().y) <= 1e-5);
    }
    CHECK(visible >= 150);
  }
}

TEST_CASE("lens: a fisheye shows its axis and all but the last 0.001 radians straight behind") {
  const Lens lens{LensModel::fisheye, {}};
  const LensLimits limits = lens_limits(camera_with(lens), Conventions::gsplat());
  const LensPoint ahead = point_through(lens, limits, dvec3(0, 0, 2));
  CHECK(ahead.inside);
  CHECK(ahead.u == 0);
  CHECK(ahead.du == dvec3(0.5, 0, 0));
  CHECK(ahead.dv == dvec3(0, 0.5, 0));
  CHECK_FALSE(point_through(lens, limits, dvec3(0, 0, -2)).inside);
  const auto shows = [&](double from_behind) {
    return point_through(lens, limits, 2.0 * dvec3(std::sin(from_behind), 0, -std::cos(from_behind))).inside;
  };
  CHECK(shows(1.001e-3));
  CHECK_FALSE(shows(0.999e-3));
}

TEST_CASE("lens: the fold-over is where radii stop to grow") {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> in(-1, 1);
  int folded = 0;
  for (int i = 0; i < 30; ++i) {
    Distortion d{{0.3 * in(random), 0.1 * in(random), 0.02 * in(random), 0.004 * in(random)}, {}, {}, {}};
    if (i % 2) d.rational[0] = 0.2 * std::fabs(in(random)), d.rational[1] = 0.05 * std::fabs(in(random));
    const double found = std::sqrt(lens::fold_squared(d, 9)), expected = fold_by_steps(d, 3);
    CHECK(found == doctest::Approx(expected).epsilon(1e-4));
    folded += found < 3;
  }
  CHECK(folded >= 10);
  // A pole of the rational term ends the lens too.
  CHECK(lens::fold_squared({{}, {-0.25, 0, 0}, {}, {}}, 100) == doctest::Approx(4));
}

TEST_CASE("lens: undistorted points are where the distortion takes them from") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> in(-0.8, 0.8);
  for (const Lens& lens : lenses()) {
    if (!lens.is_distorted()) continue;
    const double fold = lens::fold_squared(lens.distortion, 100);
    for (int i = 0; i < 200; ++i) {
      const double u = in(random), v = in(random);
      const lens::Distorted to = lens::distort(lens.distortion, u, v);
      const lens::Undistorted back = lens::undistorted(lens.distortion, fold, to.u, to.v);
      REQUIRE(back.found);
      CHECK(back.u == doctest::Approx(u).epsilon(1e-10));
      CHECK(back.v == doctest::Approx(v).epsilon(1e-10));
    }
  }
  // Beyond the largest radius that a barrel shows there is nothing to come from.
  const Distortion barrel{{-1.0 / 3, 0, 0, 0}, {}, {}, {}};
  CHECK(lens::fold_squared(barrel, 100) == doctest::Approx(1));
  CHECK(lens::undistorted(barrel, 1, 0.66, 0).found);
  const lens::Undistorted beyond = lens::undistorted(barrel, 1, 0.67, 0);
  CHECK_FALSE(beyond.found);
  CHECK(beyond.u > 0.8);  // the last that was found on the way
}

TEST_CASE("lens: limits of tangents are those that the border shows, found by a dense search") {
  Camera camera = camera_with({LensModel::perspective, {{-0.12, 0.03, -0.002, 0}, {}, {0.004, -0.003}, {}}});
  camera.cx = 280;
  const LensLimits limits = lens_limits(camera, Conventions());
  // Of all points of the plane, those that the image shows.
  double least_u = INFINITY, most_u = -INFINITY;
  for (int i = 0; i < 1500; ++i)
    for (int j = 0; j < 300; ++j) {
      const double u = -3 + 6.0 * i / 1500, v = -2 + 4.0 * j / 300;
      if (u * u + v * v >= limits.fold_squared) continue;
      const Sight at = test::distorted(camera.lens.distortion, {u, v});
      const double x = 300 * double(at.u.value) + camera.cx, y = 300 * double(at.v.value) + camera.cy;
      if (x < 0 || x > camera.width || y < 0 || y > camera.height) continue;
      least_u = std::fmin(least_u, u), most_u = std::fmax(most_u, u);
    }
  const double margin = 0.15 * (most_u - least_u);
  CHECK(limits.least_u == doctest::Approx(least_u - margin).epsilon(0.01));
  CHECK(limits.most_u == doctest::Approx(most_u + margin).epsilon(0.01));
}

TEST_CASE("lens: a pinhole ordered by distance has no fold") {
  Camera camera = camera_with({}, 100, 100);
  camera.fx = camera.fy = 1e-5, camera.cx = camera.cy = 50;
  Conventions conventions;
  conventions.depth = Conventions::Depth::distance;
  CHECK(project_shape(view_constants(camera, conventions), {{2e6f, 0, 1}, vec3(1e5f), {}, 0.9f}).visible);
}

TEST_CASE("lens: limits of tangents are a pinhole's where there is no distortion") {
  for (const auto clamp :
       {Conventions::JacobianClamp::around_image, Conventions::JacobianClamp::around_centre}) {
    Conventions conventions;
    conventions.clamp = clamp;
    Camera camera = camera_with({});
    camera.cx = 200, camera.cy = 300;
    const ViewConstants pinhole = view_constants(camera, conventions);
    const LensLimits limits = lens_limits(camera, conventions);
    CHECK(limits.least_u == doctest::Approx(pinhole.limits.least_u));
    CHECK(limits.most_u == doctest::Approx(pinhole.limits.most_u));
    CHECK(limits.least_v == doctest::Approx(pinhole.limits.least_v));
    CHECK(limits.most_v == doctest::Approx(pinhole.limits.most_v));
  }
}

TEST_CASE("lens: points beyond the fold or behind a perspective lens show nothing") {
  Lens lens;
  lens.distortion.radial[0] = -1.0 / 3;  // r - r^3 / 3 folds at 1
  const LensLimits limits = lens_limits(camera_with(lens), Conventions::gsplat());
  CHECK(point_through(lens, limits, dvec3(0.99, 0, 1)).inside);
  CHECK_FALSE(point_through(lens, limits, dvec3(1.01, 0, 1)).inside);
  CHECK_FALSE(point_through(lens, limits, dvec3(0.1, 0, -1)).inside);
  CHECK_FALSE(point_through(lens, limits, dvec3(0.1, 0, 0)).inside);
}

TEST_CASE("lens: depth is z or the distance, as the lens and the conventions say") {
  const Gaussian g{{1, 2, 2}, vec3(0.1f), {}, 0.9f};
  const auto depth_of = [&](const Lens& lens, Conventions::Depth depth) {
    Conventions conventions;
    conventions.depth = depth;
    return project_shape(view_constants(camera_with(lens, 4000, 4000), conventions), g).depth;
  };
  using enum Conventions::Depth;
  for (const Lens& lens : lenses()) {
    CAPTURE(name_of(lens.model));
    const bool sees_behind = lens.model == LensModel::fisheye || lens.model == LensModel::equirectangular;
    CHECK(depth_of(lens, of_lens) == (sees_behind ? 3 : 2));
    CHECK(depth_of(lens, z) == 2);
    CHECK(depth_of(lens, distance) == 3);
  }
}

TEST_CASE("lens: panoramas are drawn in parts of an eighth of a turn or somewhat more") {
  const Lens lens{LensModel::equirectangular, {}};
  CHECK(panorama_part(camera_with(lens, 4096, 2048)) == 512);
  CHECK(panorama_part(camera_with(lens, 1792, 896)) == 224);
  CHECK(panorama_part(camera_with(lens, 520, 260)) == 96);  // in steps of coarse tiles
  CHECK(panorama_part(camera_with(lens, 100, 50)) == 16);
  CHECK(panorama_part(camera_with(lens, 32, 16)) == 16);
  Camera narrow = camera_with(lens, 100, 50);
  narrow.fx = 1e12;
  CHECK(panorama_part(narrow) == 0);
  CHECK(panorama_part(camera_with({LensModel::fisheye, {}}, 4096, 2048)) == 0);
}

TEST_CASE("lens: a part of a panorama culls chunks at its other side, and none about a pole") {
  const Camera camera = camera_with({LensModel::equirectangular, {}}, 256, 128);
  FrameView frame{.width = 32, .height = 128};
  const View part =
      make_view(camera, Conventions::gsplat(), frame, vec3(0), {128, 0});  // azimuths of 0 to 45 degrees
  const ChunkCuller culler(part.camera);
  const auto chunk_at = [](vec3 centre) {
    ChunkBounds chunk;
    chunk.low = centre - vec3(0.1f), chunk.high = centre + vec3(0.1f);
    chunk.size = 0.05f, chunk.opacity = 0.9f;
    return chunk;
  };
  CHECK(culler.culls(chunk_at({0, 0, -3})));
  CHECK(culler.culls(chunk_at({-3, 0.5f, 0})));
  CHECK_FALSE(culler.culls(chunk_at({1, 0.5f, 3})));
  CHECK_FALSE(culler.culls(chunk_at({0, 3, 0})));
  CHECK(culler.culls(chunk_at({1, 0.5f, 3e11f})));  // beyond the far plane
}

TEST_CASE("lens: what cannot be is refused in words") {
  Camera camera = camera_with({LensModel::orthographic, {}});
  camera.lens.distortion.radial[0] = 0.1;
  CHECK_THROWS_WITH_AS(validate(camera), doctest::Contains("no distortion of an orthographic lens"),
                       std::invalid_argument);
  camera = camera_with({LensModel::equirectangular, {}});
  camera.width = 700;
  CHECK_THROWS_WITH_AS(validate(camera), doctest::Contains("at most 2 pi fx pixels a row"),
                       std::invalid_argument);
  camera = camera_with({});
  camera.lens.distortion.prism[1] = NAN;
  CHECK_THROWS_AS(validate(camera), std::invalid_argument);
  CHECK_THROWS_WITH_AS(lens_model_named("fish"), doctest::Contains("lens 'fish' is not known; expected "),
                       std::invalid_argument);
}

}  // namespace swiftgs::test::lens_arithmetic_test
