// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/reference.hpp>

#include "policies/backends.hpp"
#include "policies/random_splats.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// What `f` throws, or "accepted".
template <class F>
std::string refusal(const F& f) {
  try {
    f();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

template <class B>
using Exact = Renderer<B, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>;

template <class B>
Frame draw(const Scene& scene, const Camera& camera) {
  Exact<B> renderer(make_backend<B>());
  RenderSettings settings;
  settings.outputs = {true, true};
  return renderer.render(renderer.backend().upload(scene), camera, settings);
}

}  // namespace

TEST_CASE_TEMPLATE("limits: upload refuses numbers that are not finite and names the Gaussian", B,
                   SWIFTGS_TEST_BACKENDS) {
  const auto message = [](const auto& spoil) {
    Scene scene = random_scene(40, 2, 1);
    spoil(scene);
    return refusal([&] { (void)make_backend<B>().upload(scene); });
  };
  CHECK(message([](Scene&) {}) == "accepted");
  CHECK(message([](Scene& s) { s.means[7].y = NAN; }) ==
        "scene: means of Gaussian 7 is nan, expected finite numbers");
  CHECK(message([](Scene& s) { s.scales[0].z = INFINITY; }) ==
        "scene: scales of Gaussian 0 is inf, expected finite numbers");
  CHECK(message([](Scene& s) { s.rotations[39].w = -INFINITY; }) ==
        "scene: rotations of Gaussian 39 is -inf, expected finite numbers");
  CHECK(message([](Scene& s) { s.opacities[3] = INFINITY; }) ==
        "scene: opacities of Gaussian 3 is inf, expected finite numbers");
  CHECK(message([](Scene& s) { s.sh0[4].x = NAN; }) ==
        "scene: sh0 of Gaussian 4 is nan, expected finite numbers");
  CHECK(message([](Scene& s) { s.sh_rest[24 * 11 + 23] = NAN; }) ==
        "scene: sh_rest of Gaussian 11 is nan, expected finite numbers");
}

TEST_CASE("limits: a background that is not finite is refused by renderers and by the reference") {
  const Scene scene = random_scene(10, 1, 1);
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    CHECK(refusal([&] {
            Exact<Serial> renderer;
            RenderSettings settings;
            settings.background = vec3(0, bad, 0);
            (void)renderer.render(renderer.backend().upload(scene), forward_camera(40, 30), settings);
          }) ==
          "render: the background is " + std::to_string(bad) + " in channel 1, expected finite numbers");
    CHECK(refusal([&] {
            (void)render_reference(scene, forward_camera(40, 30), {}, dvec3(0, double(bad), 0));
          }) == "render_reference: expected a finite background");
  }
}

TEST_CASE("limits: cameras beyond what float holds are refused") {
  const auto message = [](const auto& change) {
    Camera camera = forward_camera(40, 30);
    change(camera);
    return refusal([&] { validate(camera); });
  };
  CHECK(message([](Camera& c) { c.fx = 1e-6, c.fy = 1e12, c.cx = -1e9, c.cy = 1e9; }) == "accepted");
  for (const double focal : {0.0, -1.0, 9e-7, 1.1e12, 1e300, double(INFINITY)})
    CHECK(message([&](Camera& c) { c.fy = focal; }) ==
          "camera: expected focal lengths of 1e-6 to 1e12 pixels");
  for (const double point : {1.1e9, -1e300, double(INFINITY)})
    CHECK(message([&](Camera& c) { c.cx = point; }) ==
          "camera: expected a principal point at most 1e9 pixels from the corner");
  // Rows are orthonormal to 1e-3: a product of two of them is off by less.
  for (const double off : {9.9e-4, -9.9e-4}) {
    CHECK(message([&](Camera& c) { c.rotation[0].y = off; }) == "accepted");
    CHECK(message([&](Camera& c) { c.rotation[2].z = std::sqrt(1 + off); }) == "accepted");
  }
  for (const double off : {1.01e-3, -1.01e-3, 1.0, double(NAN), double(INFINITY)}) {
    CAPTURE(off);
    CHECK(message([&](Camera& c) { c.rotation[0].y = off; }) ==
          "camera: expected a rotation with orthonormal rows");
    CHECK(message([&](Camera& c) { c.rotation[2].z = std::sqrt(1 + off); }) ==
          "camera: expected a rotation with orthonormal rows");
  }
}

TEST_CASE_TEMPLATE("limits: a mirrored rotation draws the mirrored world", B, SWIFTGS_TEST_BACKENDS) {
  // Camera and world mirrored alike: the same frame, but for the direction that harmonics are seen from.
  const Scene scene = random_scene(60, 0, 3);
  const Camera camera = forward_camera(64, 48);
  Scene mirrored = scene;
  for (vec3& mean : mirrored.means) mean.x = -mean.x;
  for (Quaternion& q : mirrored.rotations) q = {q.w, q.x, -q.y, -q.z};
  Camera mirror = camera;
  mirror.rotation[0].x = -1;
  const Frame expected = draw<B>(scene, camera), seen = draw<B>(mirrored, mirror);
  CHECK(expected.alpha == seen.alpha);
  CHECK(expected.colour == seen.colour);
  const ReferenceFrame reference = render_reference(mirrored, mirror, {});
  double worst = 0;
  for (std::size_t i = 0; i < seen.colour.size(); ++i)
    worst = std::max(worst, std::abs(double(seen.colour[i]) - reference.colour[i]));
  CHECK(worst < 1e-5);
}

TEST_CASE_TEMPLATE("limits: a splat wider than 1e18 pixels is not drawn and one below it is", B,
                   SWIFTGS_TEST_BACKENDS) {
  Scene scene = random_scene(1, 0, 1);
  scene.means[0] = vec3(0, 0, 2), scene.opacities[0] = 0.5f;
  Camera camera = forward_camera(32, 32);
  camera.fx = camera.fy = 2, camera.cx = camera.cy = 16;
  for (const bool wide : {false, true}) {
    scene.scales[0] = vec3(wide ? 1.01e18f : 0.99e18f, 1, 1);
    scene.rotations[0] = {};
    const Frame frame = draw<B>(scene, camera);
    const ReferenceFrame reference = render_reference(scene, camera, {});
    CHECK((frame.alpha[16 * 32 + 16] > 0.3f) == !wide);
    CHECK((reference.alpha[16 * 32 + 16] > 0.3) == !wide);
  }
}

TEST_CASE_TEMPLATE("limits: harmonics are seen from the right direction at any depth", B,
                   SWIFTGS_TEST_BACKENDS) {
  for (const double depth : {1e-12, 1.0, 1e20, 1e30}) {
    CAPTURE(depth);
    Scene scene = random_scene(1, 1, 1);
    scene.means[0] = vec3(float(0.3 * depth), float(-0.2 * depth), float(depth));
    scene.scales[0] = vec3(float(0.5 * depth)), scene.opacities[0] = 0.9f;
    scene.sh_rest.assign(9, 0.5f), scene.sh0[0] = vec3(1);
    RenderSettings settings;
    settings.conventions.near_plane = 0;
    settings.conventions.far_plane = INFINITY;
    Exact<B> renderer(make_backend<B>());
    const Frame frame = renderer.render(renderer.backend().upload(scene), forward_camera(32, 32), settings);
    const ReferenceFrame reference = render_reference(scene, forward_camera(32, 32), settings.conventions);
    double worst = 0;
    for (std::size_t i = 0; i < frame.colour.size(); ++i)
      worst = std::max(worst, std::abs(double(frame.colour[i]) - reference.colour[i]));
    CHECK(reference.alpha[16 * 32 + 16] > 0.5);
    CHECK(worst < 2e-6);
  }
}

TEST_CASE("limits: where half terms cancel infinitely the pixel skips the splat") {
  // a dx^2 is beyond 65,504 and b dx as far below.
  const SplatShape shape = make_splat(-40000, -40000, 90000, 0.6, 0.785398163, 0.9);
  const HalfSplit terms(shape, vec2(8));
  const float s = HalfSplit::exponent(terms.x_term(8.5f), terms.y_term(8.5f));
  CHECK(std::isnan(s));
  const BlendRules rules = BlendRules::from(Conventions::gsplat());
  AxisShared<HalfSplit>::Kernel plain(shape, vec2(0.5f), rules);
  AxisSharedThreshold<HalfSplit>::Kernel threshold(shape, vec2(0.5f), rules);
  plain.start_row(8.5f), threshold.start_row(8.5f);
  CHECK(plain.alpha(8) == 0);
  CHECK(threshold.alpha(8) == 0);
}
