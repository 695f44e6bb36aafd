// SPDX-License-Identifier: Apache-2.0

// Which chunks a view culls, through every lens, and what chunks hold.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/project/project.hpp>

#include "policies/random_splats.hpp"
#include "support/one_view.hpp"

namespace swiftgs::test::chunk_culling_test {

namespace {

constexpr LensModel models[] = {LensModel::perspective, LensModel::fisheye, LensModel::orthographic,
                                LensModel::equirectangular};

vec3 random_point(Random& random, double most) {
  const float z = random.f(-most, most), y = random.f(-most, most), x = random.f(-most, most);
  return vec3(x, y, z);
}

/// A lens of the model, distorted in half of the cases where it may be.
Lens random_lens(Random& random, LensModel model) {
  Lens lens{model, {}};
  if (model == LensModel::orthographic || model == LensModel::equirectangular || random.bits() % 2 == 0)
    return lens;
  Distortion& d = lens.distortion;
  const double strength = random.scale(0.001, 1);
  for (double* k = d.radial; k < d.radial + 4; ++k)
    *k = random.bits() % 2 == 0 ? 0 : random.in(-strength, strength);
  if (random.bits() % 4 == 0)
    for (double& q : d.rational) q = random.in(-strength, strength);
  for (int i = 0; i < 2; ++i)
    d.tangential[i] = 0.02 * random.in(-strength, strength),
    d.prism[i] = 0.02 * random.in(-strength, strength);
  return lens;
}

/// Cameras of every kind: turned, tele and wide, off centre, with parts of an image.
ViewConstants random_camera(Random& random, LensModel model) {
  const int width = 16 * int(random.in(2, 40)), height = 16 * int(random.in(2, 40));
  Camera camera = forward_camera(width, height, width * random.scale(0.2, 20));
  if (model == LensModel::equirectangular) camera.fx = std::max(camera.fx, width / 6.28);
  camera.cx += width * random.in(-0.5, 0.5), camera.cy += height * random.in(-0.5, 0.5);
  const LocalAxes<float> axes(random_rotation(random));
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) camera.rotation[column][row] = double(axes.column[column][row]);
  camera.translation = dvec3(random_point(random, random.bits() % 4 == 0 ? 1e6 : 10));
  camera.lens = random_lens(random, model);
  Conventions conventions = random.bits() % 2 == 0 ? Conventions::gsplat() : Conventions::inria();
  conventions.antialiased = random.bits() % 2 == 0;
  conventions.blur = random.bits() % 4 == 0 ? 0.0f : random.f(0.01, 2);
  conventions.near_plane = random.bits() % 4 == 0 ? 0.0f : conventions.near_plane;
  conventions.far_plane = random.bits() % 4 == 0 ? 8.0f : conventions.far_plane;
  if (model == LensModel::perspective && random.bits() % 4 == 0)
    conventions.depth = Conventions::Depth::distance;
  FrameView frame{.width = width, .height = height};
  FirstPixel first;
  if (random.bits() % 2 == 0) {
    frame.width = frame.height = 16;
    first = {16 * int(random.in(0, width / 16 - 1)), 16 * int(random.in(0, height / 16 - 1))};
  }
  return make_view(camera, conventions, frame, vec3(0), first).camera;
}

/// A point in and around what a pinhole camera shows, or behind it; through other lenses all around it, in
/// half of the cases.
vec3 random_point(Random& random, const ViewConstants& camera) {
  const auto between = [&](float first, float last) {
    return random.in(1.5 * first - 0.5 * last, 1.5 * last - 0.5 * first);
  };
  const bool parallel = camera.lens.model == LensModel::orthographic;
  const bool ahead = parallel || camera.lens.model == LensModel::perspective;
  dvec3 p(0, 0, random.in(0, 10) < 9 ? random.scale(0.01, 12) : random.in(-2, 0));
  p.x = (parallel ? 1 : p.z) * (between(camera.left, camera.right) - camera.cx) / camera.fx;
  p.y = (parallel ? 1 : p.z) * (between(camera.top, camera.bottom) - camera.cy) / camera.fy;
  if (!ahead && random.bits() % 2 == 0) p = dvec3(random_point(random, 3));
  vec3 point;
  for (int k = 0; k < 3; ++k)
    point[k] = float(camera.centre[k] + p.x * camera.rotation[0][k] + p.y * camera.rotation[1][k] +
                     p.z * camera.rotation[2][k]);
  return point;
}

/// A chunk of Gaussians around one place, of sizes, shapes and opacities that differ from chunk to chunk.
Scene random_chunk(Random& random, vec3 centre) {
  Scene scene;
  const double spread = random.scale(1e-3, 3), size = random.scale(1e-4, 1), faint = random.scale(0.004, 1);
  for (std::size_t i = 0; i < chunk_size; ++i) {
    scene.means.push_back(centre + random_point(random, spread));
    const float third = float(size * random.scale(0.01, 1)), second = float(size * random.scale(0.01, 1));
    scene.scales.push_back(vec3(i % 3 == 0 ? -float(size) : float(size), second, third));
    Quaternion rotation = random_rotation(random);
    const float length = i % 4 == 0 ? random.f(0.5, 1.5) : 1.0f;
    for (float* part : {&rotation.w, &rotation.x, &rotation.y, &rotation.z}) *part *= length;
    scene.rotations.push_back(rotation);
    scene.opacities.push_back(float(faint * random.in(0.5, 3)));
    scene.sh0.push_back(vec3(0));
  }
  return scene;
}

bool any_visible(const ViewConstants& view, const SceneView& scene) {
  for (std::size_t i = 0; i < scene.size(); ++i)
    if (project_shape(view, gaussian(scene, i)).visible) return true;
  return false;
}

}  // namespace

TEST_CASE("chunks: no Gaussian of a culled chunk is visible, and most chunks without one are culled") {
  for (const LensModel model : models) {
    CAPTURE(name_of(model));
    Random random(1);
    int culled = 0, without = 0;
    for (int round = 0; round < 20'000; ++round) {
      CAPTURE(round);
      const ViewConstants camera = random_camera(random, model);
      const Scene scene = random_chunk(random, random_point(random, camera));
      const SceneView chunk = view(scene);
      const bool culls = ChunkCuller(camera).culls(detail::bounds_of_chunk(chunk, 0));
      const bool visible = any_visible(camera, chunk);
      REQUIRE_FALSE((culls && visible));
      culled += culls, without += !visible;
    }
    MESSAGE(culled << " of " << without << " chunks without a visible Gaussian are culled");
    CHECK(culled > without * 0.5);
    CHECK(without > 4'000);
    CHECK(without < 16'000);
  }
}

TEST_CASE("chunks: what is not a number culls nothing, and what cannot be seen is culled") {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  for (const LensModel model : models) {
    CAPTURE(name_of(model));
    Camera camera = forward_camera(64, 48);
    camera.lens.model = model;
    const bool parallel = model == LensModel::orthographic, all_around = model == LensModel::equirectangular;
    if (parallel) camera.fx = camera.fy = 15;
    const OneView one(camera, Conventions::gsplat(), {});
    const ChunkCuller culler(one.view.camera);
    ChunkBounds bounds{.low = vec3(-1, -1, 3), .size = 0.1f, .high = vec3(1, 1, 4), .opacity = 0.5f};
    CHECK_FALSE(culler.culls(bounds));
    const auto with = [&](auto change) {
      ChunkBounds changed = bounds;
      change(changed);
      return culler.culls(changed);
    };
    CHECK_FALSE(with([&](ChunkBounds& b) { b.low.x = nan; }));
    CHECK_FALSE(with([&](ChunkBounds& b) { b.high.z = infinity; }));
    CHECK_FALSE(with([&](ChunkBounds& b) { b.size = infinity; }));
    CHECK_FALSE(with([&](ChunkBounds& b) { b.opacity = infinity; }));
    CHECK_FALSE(with([&](ChunkBounds& b) { b.opacity = nan; }));
    CHECK(with([](ChunkBounds& b) { b.opacity = 0.003f; }));
    const bool behind_is_a_circle = model == LensModel::fisheye;
    CHECK(with([](ChunkBounds& b) { b.low.z = -4, b.high.z = -3; }) != behind_is_a_circle);
    CHECK(with([](ChunkBounds& b) { b.low.x = 9, b.high.x = 10; }));
    CHECK(with([](ChunkBounds& b) { b.low.x = -10, b.high.x = -9; }));
    if (all_around) continue;
    CHECK(with([](ChunkBounds& b) { b.low.y = 9, b.high.y = 10; }));
    CHECK(with([](ChunkBounds& b) { b.low.y = -10, b.high.y = -9; }));
    CHECK_FALSE(with([](ChunkBounds& b) { b.low.x = 9, b.high.x = 10, b.size = 3; }));
  }
}

TEST_CASE("chunks: they hold all means, sizes and opacities") {
  const Scene scene = order_spatially(make_builtin_scene(20'001));
  const std::vector<ChunkBounds> chunks = chunk_bounds(view(scene));
  REQUIRE(chunks.size() == 157);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const ChunkBounds& chunk = chunks[i / chunk_size];
    for (int k = 0; k < 3; ++k) {
      CHECK(scene.means[i][k] >= chunk.low[k]);
      CHECK(scene.means[i][k] <= chunk.high[k]);
      CHECK(scene.scales[i][k] <= chunk.size);
    }
    CHECK(scene.opacities[i] <= chunk.opacity);
  }
}

TEST_CASE("chunks: a thousandth of strays takes none away") {
  Scene scene = order_spatially(make_builtin_scene(20'000));
  for (std::size_t i = 0; i < scene.size(); i += 1000) scene.means[i].x = i % 2000 ? 1e30f : -1e6f;
  CHECK_FALSE(chunk_bounds(view(scene)).empty());
  CHECK_FALSE(chunk_bounds(view(order_spatially(scene))).empty());
}

TEST_CASE("chunks: a scene has none where neighbours in its arrays are not neighbours in space") {
  Scene scene = make_builtin_scene(20'000);
  std::vector<std::uint32_t> shuffled = spatial_order(scene);
  CHECK_FALSE(chunk_bounds(view(subset(scene, shuffled))).empty());
  Random random(1);
  for (std::size_t i = shuffled.size(); i-- > 1;) std::swap(shuffled[i], shuffled[random.bits() % (i + 1)]);
  CHECK(chunk_bounds(view(subset(scene, shuffled))).empty());
  CHECK(chunk_bounds(view(Scene())).empty());
  CHECK(chunk_bounds(view(random_scene(100, 0, 1))).empty());
}

}  // namespace swiftgs::test::chunk_culling_test
