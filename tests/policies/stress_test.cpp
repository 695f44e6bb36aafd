// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "policies/double_drawing.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Calls `f` with renderers that have every rasterizer's arithmetic, every sort and every bounds.
template <class F>
void for_each_renderer(const F& f) {
  f(Renderer<Serial, EarlySort, PerPixel, Ellipse>());
  f(Renderer<Serial, StandardSort, AxisSharedThreshold<FloatCholesky>, Ellipse>());
  f(Renderer<Cpu, EarlySort, PerPixel, OpacityBox>(Cpu(2)));
  f(Renderer<Cpu, EarlySort, AxisShared<FloatSplit>, Ellipse>(Cpu(2)));
  f(Renderer<Cpu, EarlySort, AxisShared<FloatCholesky>, Ellipse>(Cpu(2)));
  f(Renderer<Cpu, StandardSort, AxisSharedThreshold<FloatCholesky>, Ellipse>(Cpu(2)));
  f(Renderer<Cpu, StandardSort, AxisSharedThreshold<HalfSplit>, ThreeSigmaSquare>(Cpu(2)));
}

/// Least PSNR against the reference; -INFINITY where it is enough that frames are finite.
struct LeastDb {
  LeastDb(double all) : cholesky(all), split(all) {}
  LeastDb(double cholesky_db, double split_db) : cholesky(cholesky_db), split(split_db) {}

  double cholesky;
  double split;  ///< of `PerPixel` and `FloatSplit`, whose terms may cancel
};

/// Renders with every renderer: all must give finite frames, and all but half precision the reference's
/// image.
void check_frames(const Scene& scene, const Camera& camera, LeastDb least,
                  const Conventions& conventions = {}) {
  const ReferenceFrame reference = render_reference(scene, camera, conventions, dvec3(0.25), 2);
  for_each_renderer([&](auto renderer) {
    CAPTURE(renderer.name);
    RenderSettings settings;
    settings.conventions = conventions, settings.background = vec3(0.25f), settings.outputs = {true, true};
    Frame frame;
    // As a caller's own arrays, which nothing looks at before.
    const SceneView own = view(scene);
    renderer.render_into(own, camera, settings,
                         prepare(frame, camera.width, camera.height, settings.outputs));
    const auto finite = [](const std::vector<float>& values) {
      return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
    };
    CHECK(finite(frame.colour));
    CHECK(finite(frame.alpha));
    CHECK(finite(frame.depth));
    const auto named = [&](const char* word) { return renderer.name.find(word) != std::string_view::npos; };
    if (!named("half"))
      CHECK(psnr(frame.colour, reference.colour) >= (named("cholesky") ? least.cholesky : least.split));
  });
}

Camera camera() { return forward_camera(96, 64); }

/// A scene like any other to put extremes among.
Scene usual_scene(std::uint64_t seed, std::size_t count = 200) { return random_scene(count, 1, seed); }

}  // namespace

TEST_CASE("stress: scales from 1e-12 to 1e12") {
  // A Gaussian of 1e12 is flat over the image; one of 1e-12 is a dot of the blur.
  Random random(1);
  Scene scene = usual_scene(1);
  for (vec3& scale : scene.scales)
    for (int k = 0; k < 3; ++k) scale[k] = float(random.scale(1e-12, 1e12));
  // Most are needles without end: what the split forms add up cancels.
  check_frames(scene, camera(), {80, 70});
  for (vec3& scale : scene.scales) scale = vec3(0);
  check_frames(scene, camera(), 80);
  for (vec3& scale : scene.scales) scale = vec3(1e12f);
  check_frames(scene, camera(), 80);
}

TEST_CASE("stress: scales whose squares no float holds are left out and nothing is infinite") {
  Scene scene = usual_scene(2);
  for (std::size_t i = 0; i < scene.size(); i += 3) scene.scales[i] = vec3(1e30f, 1e-30f, 1e25f);
  for (std::size_t i = 1; i < scene.size(); i += 3) scene.scales[i] = vec3(3e38f);
  check_frames(scene, camera(), -INFINITY);
}

TEST_CASE("stress: needles of ratio 1e6 across the image") {
  Random random(3);
  Scene scene = usual_scene(3);
  for (vec3& scale : scene.scales) scale = vec3(random.f(1, 100), random.f(1e-5, 1e-4), random.f(1e-6, 1e-4));
  for (vec3& mean : scene.means) mean.z = std::abs(mean.z) + 0.5f;
  check_frames(scene, camera(), 80);
}

TEST_CASE("stress: Gaussians on the near plane and just off it") {
  for (const Conventions& conventions : {Conventions::gsplat(), Conventions::inria()}) {
    Random random(4);
    Scene scene = usual_scene(4, 100);
    const float near = conventions.near_plane;
    for (std::size_t i = 0; i < scene.size(); ++i) {
      const float z[] = {near, std::nextafter(near, 0.0f), std::nextafter(near, 1.0f), near * 1.01f, 0,
                         -near};
      scene.means[i] = vec3(random.f(-0.5, 0.5) * near, random.f(-0.3, 0.3) * near, z[i % 6]);
      scene.scales[i] = vec3(random.f(0.01, 0.2) * near);
    }
    Conventions whole = conventions;
    whole.footprint = Conventions::Footprint::alpha;
    check_frames(scene, camera(), 80, whole);
  }
}

TEST_CASE("stress: everything behind the camera leaves the background") {
  Scene scene = usual_scene(5);
  for (vec3& mean : scene.means) mean.z = -std::abs(mean.z) - 0.01f;
  check_frames(scene, camera(), 200);
}

TEST_CASE("stress: a world a million units from its origin") {
  // The scene's own floats step by 1/16 there, as they do for the reference; the camera is in double.
  Scene scene = usual_scene(6);
  for (vec3& mean : scene.means) mean = mean * 20.0f + vec3(1e6f, -2e6f, 3e6f);
  for (vec3& scale : scene.scales) scale = scale * 20.0f;
  Camera far = camera();
  far.translation = dvec3(-1e6, 2e6, -3e6);
  check_frames(scene, far, 80);
}

TEST_CASE("stress: a rotation of which only five digits are known") {
  Camera turned = look_at(dvec3(-3, 2, -8), dvec3(0.2, 0, 5), dvec3(0.1, -1, 0.2), 0.9, 96, 64);
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row)
      turned.rotation[column][row] = std::round(1e5 * turned.rotation[column][row]) / 1e5;
  // With the transpose in the place of the inverse it would be 87 dB.
  check_frames(usual_scene(12), turned, 100);
}

TEST_CASE("stress: Gaussians whose colours or depths are not finite are not drawn") {
  const Camera in_front = camera();
  Scene scene = usual_scene(13, 60);
  for (std::size_t i = 0; i < scene.size(); i += 4) {
    scene.sh0[i] = vec3(i % 8 == 0 ? INFINITY : -INFINITY);
    if (i % 12 == 0) scene.means[i] = vec3(3e38f);
  }
  Camera oblique = look_at(dvec3(0), dvec3(1, 1, 1), dvec3(0, -1, 0), 0.9, 96, 64);
  for (const Camera& view : {in_front, oblique}) check_frames(scene, view, 100);
}

TEST_CASE("stress: focal lengths from 1 to 1e6") {
  for (const double focal : {1.0, 10.0, 1e3, 1e4, 1e5, 1e6}) {
    CAPTURE(focal);
    Random random(7);
    Scene scene = usual_scene(7);
    for (std::size_t i = 0; i < scene.size(); ++i) {
      // In the field of view whatever it is, at a size of some pixels.
      const float z = random.f(2, 10), pixel = float(double(z) / focal);
      scene.means[i] = vec3(random.f(-60, 60) * pixel, random.f(-40, 40) * pixel, z);
      scene.scales[i] = vec3(random.f(1, 8), random.f(1, 8), random.f(1, 8)) * pixel;
    }
    Camera camera = forward_camera(96, 64, focal);
    // A float's 24 bits of a mean are 6e-8 of its distance, for the reference as well: the same input.
    check_frames(scene, camera, 80);
  }
}

TEST_CASE("stress: opacities of 0 and 1 and between with denormal ones among them") {
  Random random(8);
  Scene scene = usual_scene(8);
  const float opacities[] = {0,
                             1,
                             std::numeric_limits<float>::denorm_min(),
                             std::numeric_limits<float>::min() / 3,
                             1.0f / 255,
                             std::nextafter(1.0f / 255, 0.0f),
                             std::nextafter(1.0f / 255, 1.0f),
                             std::nextafter(1.0f, 0.0f)};
  for (std::size_t i = 0; i < scene.size(); ++i) scene.opacities[i] = opacities[i % 8];
  check_frames(scene, camera(), 80);
}

TEST_CASE("stress: rotations that are not unit are taken as they are") {
  Random random(9);
  Scene scene = usual_scene(9);
  for (Quaternion& q : scene.rotations) {
    const float factor = random.f(0.5, 1.5);
    q = {q.w * factor, q.x * factor, q.y * factor, q.z * factor};
  }
  check_frames(scene, camera(), 80);
}

TEST_CASE("stress: numbers that are not finite are left out and reach no pixel") {
  const float wild[] = {NAN, INFINITY, -INFINITY};
  Scene scene = usual_scene(10, 300);
  for (std::size_t i = 0; i < scene.size(); i += 2) {
    const float value = wild[i / 2 % 3];
    switch (i / 6 % 7) {
      case 0:
        scene.means[i][int(i) % 3] = value;
        break;
      case 1:
        scene.scales[i][int(i) % 3] = value;
        break;
      case 2:
        scene.rotations[i].x = value;
        break;
      case 3:
        scene.opacities[i] = value;
        break;
      case 4:
        scene.means[i] = vec3(value);
        break;
      case 5:
        scene.sh_rest[3 * sh_rest_count(scene.sh_degree) * i + 4] = value;
        break;
      default:
        scene.rotations[i] = {value, value, value, value};
    }
  }
  check_frames(scene, camera(), 80);
}

TEST_CASE("stress: depths from the near plane to the far plane") {
  Random random(11);
  Scene scene = usual_scene(11);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const float z = float(random.scale(0.0101, 9.9e9));
    scene.means[i] = vec3(random.f(-0.5, 0.5) * z, random.f(-0.3, 0.3) * z, z);
    scene.scales[i] = vec3(random.f(0.005, 0.05), random.f(0.005, 0.05), random.f(0.005, 0.05)) * z;
  }
  check_frames(scene, camera(), 80);
}
