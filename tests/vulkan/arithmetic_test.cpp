// SPDX-License-Identifier: Apache-2.0

// The shaders' arithmetic against that of the library, without a device.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/plane/attribute_stage.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/project/project.hpp>
#include <swiftgs/tools/policy_lists.hpp>

#include "policies/lenses.hpp"
#include "policies/planes.hpp"
#include "policies/random_splats.hpp"
#include "seen.hpp"
#include "vulkan/glsl.hpp"

namespace swiftgs::test {
namespace {

glsl::FloatPair pair_of(double x) {
  const FloatPair p = FloatPair::from(x);
  return glsl::pair(p.high, p.low);
}
double value_of(glsl::FloatPair p) { return double(p.high) + double(p.low); }

/// The eye as shaders have it. Both structs hold the same floats.
glsl::Eye in_glsl(const vulkan::Eye& eye) {
  static_assert(sizeof(glsl::Eye) == sizeof(vulkan::Eye));
  return std::bit_cast<glsl::Eye>(eye);
}
glsl::Gaussian in_glsl(const Gaussian& g) {
  return {g.mean, g.scale, vec4(g.rotation.w, g.rotation.x, g.rotation.y, g.rotation.z), g.opacity};
}
SplatShape from_glsl(const glsl::Shape& shape) { return std::bit_cast<SplatShape>(shape); }

/// Units in the last place between two floats of one sign.
int ulps(float a, float b) {
  return std::abs(__builtin_bit_cast(std::int32_t, a) - __builtin_bit_cast(std::int32_t, b));
}

}  // namespace

TEST_CASE("vulkan arithmetic: pairs of floats are as exact as their bounds say") {
  Random random(7);
  const double unit = 0x1p-24, squared = unit * unit;
  for (int i = 0; i < 100000; ++i) {
    glsl::FUSES = i % 2 != 0;
    const double a = random.f(-100, 100) * (1 + 1e-9), b = random.f(0.01, 100) * (1 + 1e-9),
                 c = random.f(-100, 100);
    const glsl::FloatPair x = pair_of(a), y = pair_of(b), z = pair_of(c);
    const double of_x = value_of(x), of_y = value_of(y), of_z = value_of(z);
    const auto check = [&](glsl::FloatPair found, double expected, double scale) {
      REQUIRE(std::fabs(value_of(found) - expected) <= 16 * squared * scale);
    };
    check(glsl::add(x, z), of_x + of_z, std::fabs(of_x) + std::fabs(of_z));
    check(glsl::times(x, y), of_x * of_y, std::fabs(of_x * of_y));
    check(glsl::multiply_add(x, y, z), std::fma(of_x, of_y, of_z), std::fabs(of_x * of_y) + std::fabs(of_z));
    check(glsl::inverse_pair(y), 1 / of_y, 1 / of_y);
    check(glsl::inverse_root(y), 1 / std::sqrt(of_y), 1 / std::sqrt(of_y));
    REQUIRE(std::fabs(value_of(glsl::log2_of(y.high)) - std::log2(double(y.high))) < 2e-9);
    REQUIRE(ulps(glsl::root(y.high), float(std::sqrt(double(y.high)))) <= 1);
  }
  glsl::FUSES = false;
}

TEST_CASE("vulkan arithmetic: powers of two are off by three units at most on both sides of 0") {
  Random random(9);
  for (int i = 0; i < 100000; ++i) {
    const float s = random.f(-2, 126);
    CAPTURE(s);
    REQUIRE(ulps(glsl::exp2_negative(s), float(std::exp2(-double(s)))) <= 3);
  }
  REQUIRE(glsl::exp2_negative(127) == 0);
}

TEST_CASE("vulkan arithmetic: products are split into the bits of a product that is rounded once") {
  Random random(8);
  for (int i = 0; i < 100000; ++i) {
    const float a = random.f(-100, 100), b = random.f(-1, 1);
    const glsl::FloatPair split = glsl::two_product(a, b);
    glsl::FUSES = true;
    const glsl::FloatPair fused = glsl::two_product(a, b);
    glsl::FUSES = false;
    REQUIRE(split.high == fused.high);
    REQUIRE(split.low == fused.low);
  }
}

namespace {

/// Chunks of a scene that the library culls for a view, and those that shaders cull, which are some of them.
struct CulledChunks {
  std::size_t by_library = 0, by_shaders = 0;

  void add(const ViewConstants& camera, const std::vector<ChunkBounds>& chunks) {
    const ChunkCuller culler(camera);
    const glsl::Eye eye = in_glsl(vulkan::Eye(camera));
    const auto in_shader = std::bit_cast<glsl::Culler>(vulkan::Culler(culler));
    for (const ChunkBounds& chunk : chunks) {
      const bool expected = culler.culls(chunk);
      const bool culls = glsl::culls(eye.lens, eye, in_shader, std::bit_cast<glsl::Chunk>(chunk));
      REQUIRE((expected || !culls));
      by_library += expected, by_shaders += culls;
    }
  }
};

}  // namespace

TEST_CASE("vulkan arithmetic: chunks that shaders cull are culled by the library and few others are") {
  const Scene scene = order_spatially(make_builtin_scene(100'000));
  const std::vector<ChunkBounds> chunks = chunk_bounds(view(scene));
  std::vector<Camera> cameras = cameras_of_lenses(640, 360);
  cameras.push_back(cameras[0]);  // by distance
  for (std::size_t lens = 0; lens < cameras.size(); ++lens) {
    Random random(9);
    CulledChunks culled;
    Conventions conventions;
    if (lens + 1 == cameras.size()) conventions.depth = Conventions::Depth::distance;
    for (int i = 0; i < 50; ++i) {
      Camera camera = cameras[lens];
      const bool panorama = camera.lens.model == LensModel::equirectangular;
      if (!panorama) camera.fx = camera.fy = camera.fx * random.scale(0.5, 40);
      camera.cx += random.in(-300, 300), camera.translation.z += random.in(-5, 1);
      conventions.near_plane = float(random.scale(0.1, 10));
      conventions.far_plane = conventions.near_plane + float(random.scale(1, 30));
      FrameView part{.width = 96, .height = 96};
      culled.add(
          make_view(camera, conventions, part, vec3(0), {.x = 16 * (i % 34), .y = 16 * (i % 16)}).camera,
          chunks);
      culled.add(view_constants(camera, conventions), chunks);
    }
    CAPTURE(name_of(cameras[lens].lens.model));
    MESSAGE(culled.by_shaders, " of ", culled.by_library, " culled chunks of ", 100 * chunks.size(),
            " are culled");
    CHECK(culled.by_library > 20 * chunks.size());
    CHECK(culled.by_shaders * 100 > culled.by_library * 98);
  }
}

TEST_CASE("vulkan arithmetic: projection has the bits of the library but for ties of its rounding") {
  const Scene scene = make_builtin_scene(50000);
  const SceneView gaussians = view(scene);
  std::size_t splats = 0, other = 0;
  for (const bool antialiased : {false, true}) {
    glsl::FUSES = antialiased;
    Conventions conventions;
    conventions.antialiased = antialiased;
    const ViewConstants camera = view_constants(builtin_camera(640, 360), conventions);
    const glsl::Eye eye = in_glsl(vulkan::Eye(camera));
    for (std::size_t i = 0; i < gaussians.size(); ++i) {
      const Gaussian g = gaussian(gaussians, i);
      const ProjectedShape expected = project_through_pinhole<double>(camera, g);
      const glsl::ProjectedShape found = glsl::project_through_pinhole(eye, in_glsl(g));
      REQUIRE(found.visible == expected.visible);
      if (!expected.visible) continue;
      ++splats;
      const SplatShape shape = from_glsl(found.shape);
      REQUIRE(found.depth == expected.depth);
      REQUIRE(ulps(shape.mean.x, expected.shape.mean.x) <= 1);
      REQUIRE(ulps(shape.l0, expected.shape.l0) <= 1);
      REQUIRE(ulps(shape.l2, expected.shape.l2) <= 1);
      REQUIRE(std::fabs(shape.l1 - expected.shape.l1) <= 1.2e-7f * std::fabs(expected.shape.l1));
      REQUIRE(std::fabs(shape.cutoff - expected.shape.cutoff) <= 1e-6f);
      REQUIRE(std::fabs(shape.exact_mean().x - expected.shape.exact_mean().x) <= 0x1p-24);
      REQUIRE(std::fabs(shape.exact_mean().y - expected.shape.exact_mean().y) <= 0x1p-24);
      other += shape.mean != expected.shape.mean || shape.low != expected.shape.low ||
               shape.l0 != expected.shape.l0 || shape.l1 != expected.shape.l1 ||
               shape.l2 != expected.shape.l2;
    }
  }
  glsl::FUSES = false;
  MESSAGE(other, " of ", splats, " splats have other bits");
  CHECK(splats > 10000);
  CHECK(other * 1000 < splats);
}

TEST_CASE("vulkan arithmetic: lenses and depths along the ray are those of the library") {
  const Scene scene = order_spatially(make_builtin_scene(20'000));
  const SceneView gaussians = view(scene);
  std::vector<Camera> cameras = cameras_of_lenses(320, 160);
  for (Camera& camera : cameras) {
    CAPTURE(name_of(camera.lens.model));
    for (const bool by_distance : {false, true}) {
      Conventions conventions = along_ray();
      conventions.order = by_distance ? SplatOrder::distance : SplatOrder::depth;
      if (by_distance) conventions.depth = Conventions::Depth::z;
      const ViewConstants constants = view_constants(camera, conventions);
      const glsl::Eye eye = in_glsl(vulkan::Eye(constants));
      std::size_t splats = 0, other_visible = 0;
      double mean_error = 0, factor_error = 0, depth_error = 0;
      for (std::size_t i = 0; i < gaussians.size(); ++i) {
        const Gaussian g = gaussian(gaussians, i);
        const ProjectedShape expected = project_shape(constants, g);
        const glsl::ProjectedShape found = eye.lens == glsl::pinhole
                                               ? glsl::project_through_pinhole(eye, in_glsl(g))
                                               : glsl::project_through_lens(eye.lens, eye, in_glsl(g));
        other_visible += found.visible != expected.visible;
        if (!expected.visible || !found.visible) continue;
        ++splats;
        const SplatShape shape = from_glsl(found.shape);
        const auto mean = shape.exact_mean(), wanted = expected.shape.exact_mean();
        mean_error = std::max({mean_error, std::fabs(mean.x - wanted.x), std::fabs(mean.y - wanted.y)});
        const float largest = std::max(std::fabs(expected.shape.l0), std::fabs(expected.shape.l1));
        for (const float error : {shape.l0 - expected.shape.l0, shape.l1 - expected.shape.l1})
          factor_error = std::max(factor_error, double(std::fabs(error) / largest));
        REQUIRE(ulps(found.depth, expected.depth) <= 1);
        const float depth = drawn_depth(constants, gaussians, i, expected.depth);
        REQUIRE(ulps(glsl::drawn_depth(eye, g.mean, found.depth), depth) <= 1);
        const RayDepth slopes = ray_depth(constants, g, expected.shape.exact_mean(), depth, 1e30f);
        const vec3 of_shader = glsl::ray_depth(eye, in_glsl(g), found.shape, depth, 1e30f);
        const double around = std::fabs(slopes.x) * 320 + std::fabs(slopes.y) * 160 + std::fabs(depth);
        depth_error = std::max({depth_error, std::fabs(of_shader.x - slopes.middle) / around,
                                std::fabs(of_shader.y - slopes.x) * 320 / around,
                                std::fabs(of_shader.z - slopes.y) * 160 / around});
      }
      MESSAGE(name_of(camera.lens.model), ": ", splats, " splats, means off by ", mean_error,
              " px, factors by ", factor_error, ", depths by ", depth_error);
      CHECK(splats > 500);
      CHECK(other_visible == 0);
      CHECK(mean_error < 1e-6);
      CHECK(factor_error < 2e-7);
      CHECK(depth_error < 1e-6);
    }
  }
}

TEST_CASE("vulkan arithmetic: bounds list the tiles of the library") {
  Random random(3);
  const TileGrid grid = TileGrid::covering(1000, 700);
  const glsl::TileGrid in_shader = std::bit_cast<glsl::TileGrid>(grid);
  std::size_t tiles = 0;
  glsl::uint bounds = 0;
  for_each_type(AllBounds(), [&]<class Bounds>(const Bounds& of_library) {
    for (int i = 0; i < 20000; ++i) {
      const SplatShape shape = i % 10 == 0 ? random_splat(random, 1000, 700) : usual_splat(random, 1000, 700);
      const Footprint expected = find_footprint(of_library, shape, grid);
      const glsl::uvec4 found = glsl::footprint_of(bounds, std::bit_cast<glsl::Shape>(shape), in_shader);
      CAPTURE(Bounds::name);
      CAPTURE(i);
      REQUIRE(found.z == expected.count);
      if (found.z == 0) continue;
      REQUIRE(found.w == expected.first);
      REQUIRE((std::uint64_t(found.y) << 32 | found.x) == expected.mask);
      tiles += found.z;
    }
    ++bounds;
  });
  CHECK(tiles > 100000);
}

}  // namespace swiftgs::test
