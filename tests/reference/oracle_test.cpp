// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/edit/transform.hpp>

#include "reference/oracle_comparison.hpp"

namespace swiftgs::test {
namespace {

Camera turned_camera() {
  return look_at(dvec3(-1, 0.5, -2), dvec3(0.2, 0, 2), dvec3(0.1, -1, 0.2), 0.9, 53, 37);
}

/// Both cameras through a lens.
std::vector<Camera> cameras_through(const Lens& lens) {
  std::vector<Camera> cameras{oracle_camera(), turned_camera()};
  for (Camera& camera : cameras) {
    camera.lens = lens;
    if (lens.model == LensModel::orthographic) camera.fx = 9, camera.fy = 11;
    if (lens.model == LensModel::equirectangular) camera.width = 32, camera.fx = 40, camera.fy = 33;
  }
  return cameras;
}
constexpr LensModel models[] = {LensModel::perspective, LensModel::fisheye, LensModel::orthographic,
                                LensModel::equirectangular};

TEST_CASE("reference: mixtures of Gaussians agree with the oracle under each preset") {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    Random random(seed);
    Case c{.scene = mixture(random, 300)};
    check_presets(c);
    c.camera = turned_camera();
    check_presets(c);
  }
}

TEST_CASE("reference: lenses agree with the oracle") {
  const Distortion barrel{{-0.15, 0.02, 0, 0}, {0.03, 0.001, 0}, {0.002, -0.001}, {}};
  const Distortion thin_prism{{0.03, -0.004, 0.0005, -0.00002}, {}, {0.002, 0.001}, {-0.003, 0.002}};
  const Distortion folds{{-0.25, 0, 0, 0}, {}, {0.001, 0}, {}};  // 66 degrees from the axis
  for (const Lens& lens : {Lens{LensModel::perspective, barrel}, Lens{LensModel::fisheye, {}},
                           Lens{LensModel::fisheye, folds}, Lens{LensModel::fisheye, thin_prism},
                           Lens{LensModel::orthographic, {}}, Lens{LensModel::equirectangular, {}}})
    for (const auto depth :
         {Conventions::Depth::of_lens, Conventions::Depth::z, Conventions::Depth::distance}) {
      CAPTURE(name_of(lens.model));
      CAPTURE(int(depth));
      Random random(10);
      Case c{.scene = mixture(random, 300, 2)};
      for (const Camera& camera : cameras_through(lens)) {
        c.camera = camera;
        for (const Conventions& preset : {Conventions::gsplat(), Conventions::inria()}) {
          c.conventions = preset, c.conventions.depth = depth;
          check(c);
        }
      }
    }
}

TEST_CASE("reference: depths along the ray agree with the oracle") {
  for (const LensModel model : models)
    for (const float blur : {0.3f, 0.05f})
      for (const bool occluded : {false, true}) {
        CAPTURE(name_of(model));
        CAPTURE(blur);
        CAPTURE(occluded);
        Random random(15);
        Case c{.scene = mixture(random, 300)};
        c.conventions.depth_at = Conventions::DepthAt::ray, c.conventions.blur = blur;
        c.largest_bound = 1e-9L;
        for (const Camera& camera : cameras_through({model, {}})) {
          c.camera = camera;
          c.occluder.clear();
          for (int i = 0; occluded && i < camera.width * camera.height; ++i)
            c.occluder.push_back(1.5f + 0.37f * float(i % 11));
          check(c);
        }
      }
}

TEST_CASE("reference: harmonics of each degree and of large coefficients agree with the oracle") {
  for (const int degree : {0, 1, 2, 3})
    for (const double largest : {1.0, 1e4}) {
      CAPTURE(degree);
      Random random(std::uint64_t(10 + degree));
      check_presets({.scene = mixture(random, 200, degree, largest), .camera = turned_camera()});
    }
}

TEST_CASE("reference: needles and pancakes up to 1e8 times as long as thick agree with the oracle") {
  for (const std::uint64_t seed : {20u, 21u}) {
    Random random(seed);
    check_presets({.scene = needles_and_pancakes(random, 250)});
  }
}

TEST_CASE(
    "reference: Gaussians beside the image and of equal depths and in deep stacks and without extent agree "
    "with the oracle") {
  Random beside(30), equal(50), deep(80), flat(85);
  check_presets({.scene = far_off_screen(beside, 300)});
  check_presets({.scene = equal_depths(equal, 300)});
  check_presets({.scene = deep_stack(deep, 500)});
  Scene points_and_disks = mixture(flat, 300);
  for (std::size_t i = 0; i < points_and_disks.size(); ++i) {
    if (i % 3 == 0) points_and_disks.scales[i] = vec3(0);
    if (i % 3 == 1) points_and_disks.scales[i].y = 0;
  }
  check_presets({.scene = points_and_disks});
}

TEST_CASE("reference: depths at the planes and some floats off them agree with the oracle") {
  for (const Conventions& preset : {Conventions::gsplat(), Conventions::inria()})
    for (const double fraction : {0.0, 0.3, -0.3, 0.7, -0.7}) {
      CAPTURE(preset.cull_at_near);
      CAPTURE(fraction);
      Random random(40);
      Case c{.scene = at_planes(random, preset), .conventions = preset};
      // Part of the distance between floats: only rounding tells on which side of the plane such depths are.
      const float near = preset.near_plane;
      c.camera.translation.z = fraction * (double(std::nextafter(near, 1.0f)) - double(near));
      check(c);
    }
}

TEST_CASE("reference: splats without blur agree with the oracle") {
  Random random(60);
  Case c{.scene = mixture(random, 300)};
  c.conventions.blur = 0;
  check(c);
  c.scene = needles_and_pancakes(random, 250);
  check(c);
}

TEST_CASE("reference: worlds up to 1e7 from the origin agree with the oracle") {
  for (const double offset : {1e3, 1e5, 1e7}) {
    CAPTURE(offset);
    Random random(70);
    Case c{.scene = mixture(random, 300, 2), .camera = turned_camera()};
    // Far worlds are large too: floats lie a whole unit apart at 1e7.
    const double factor = std::max(1.0, 1e-5 * offset);
    move_world(c.scene, c.camera, factor, dvec3(offset, -offset, 0.5 * offset));
    // Camera space is a difference of numbers of 2.5 offsets. Four units of those at a depth of 0.1 factors
    // are so much of a pixel.
    c.largest_bound += 4 * unit * 2.5L * Real(offset) * Real(c.camera.fy) / (0.1L * Real(factor));
    c.unsure = 20;  // where depths may round to either of two floats
    check_presets(c);
  }
}

TEST_CASE("reference: mirrored cameras and rotations of five digits agree with the oracle") {
  Random random(90);
  Case c{.scene = mixture(random, 300, 3), .camera = turned_camera()};
  mirror(c.camera);
  check_presets(c);
  keep_five_digits(c.scene), keep_five_digits(c.camera);
  check_presets(c);
}

TEST_CASE("reference: placed scenes agree with the oracle through every lens") {
  for (const LensModel model : models)
    for (const double scale : {1e-3, 0.7, 1e3}) {
      // Of the lenses, a pose's scale changes the focal lengths of parallel rays alone.
      const bool takes_scale = model == LensModel::perspective || model == LensModel::orthographic;
      if (!takes_scale && scale != 0.7) continue;
      CAPTURE(name_of(model));
      CAPTURE(scale);
      Random random(130);
      Case c{.scene = mixture(random, 100, 2)};
      c.more.push_back(placed_by(mixture(random, 100, 3), pose_of(random, scale, dvec3(1, 2, 3)), 0.5f));
      Placed cut{mixture(random, 200, 1), pose_of(random, scale, dvec3(0, 0.5, 2))};
      for (vec3& mean : cut.scene.means) mean /= float(scale);
      for (vec3& size : cut.scene.scales) size /= float(scale);
      cut.clip = Clip::sphere(vec3(0, 0, float(2 / scale)), float(2 / scale));
      cut.clip.half_space_count = 1, cut.clip.half_spaces[0] = vec4(1, 0.5f, 0.2f, float(0.3 / scale));
      cut.tint = {vec3(2, 0, 0.75f), 0.3f};
      c.more.push_back(cut);
      for (const Camera& camera : cameras_through({model, {}})) {
        c.camera = camera;
        c.largest_bound = 1e-10L;  // poses add roundings
        check_presets(c);
        c.conventions = {}, c.conventions.depth_at = Conventions::DepthAt::ray, c.largest_bound = 1e-9L;
        check(c);
      }
    }
}

TEST_CASE("reference: placed needles of equal depths agree with the oracle") {
  Random random(140);
  Case c{.scene = needles_and_pancakes(random, 150)};
  c.more.push_back(placed_by(needles_and_pancakes(random, 150), pose_of(random, 30, dvec3(5, 0, 1)), 0.8f));
  check_presets(c);
  // The same scene at the same place, whose numbers alone order it.
  Placed again = c.more[0];
  again.opacity = 0.5f;
  c = {.scene = equal_depths(random, 150), .more = {again, again}};
  check_presets(c);
}

TEST_CASE("reference: placed millimetres 1e7 from zero agree with the oracle") {
  Random random(150);
  const dvec3 far(1e7, -2e7, 3e6);
  Scene small = mixture(random, 200, 2);
  transform(small, {dmat3(1.0), 1e-3, dvec3(0.0)}, dvec3(0.0));
  Case c{.scene = {}, .more = {placed_by(small, pose_of(random, 1e-3, dvec3(0))), {small, {}, 0.5f}}};
  c.camera = turned_camera();
  c.camera.translation *= 1e-3;
  for (Placed& p : c.more) {
    p.pose.translation += far;
    p.pose.rotation = c.more[0].pose.rotation;  // seldom as deep as each other
  }
  c.camera.translation -= c.camera.rotation * far;
  c.conventions.near_plane = 1e-5f;
  // As of worlds far from the origin: camera space is a difference of numbers of 2.5e7.
  c.largest_bound += 16 * unit * 7.5e7L * Real(c.camera.fy) / 0.1e-3L;
  c.unsure = 100;
  check(c);
}

TEST_CASE("reference: pixels behind an occluder agree with the oracle") {
  Random random(100);
  Case c{.scene = equal_depths(random, 300)};
  // Some occluders stand exactly at a splat's depth, some a float off, and some before the camera.
  for (int i = 0; i < c.camera.width * c.camera.height; ++i) {
    const float z = 1.5f + 0.25f * float(i % 6);
    c.occluder.push_back(i % 11 == 0   ? INFINITY
                         : i % 11 == 1 ? NAN
                         : i % 11 == 2 ? float(-(i % 2))
                         : i % 3 == 0  ? std::nextafter(z, 9.0f)
                                       : z);
  }
  check_presets(c);
  // Only rounding brings these depths to the occluders.
  c.camera.translation.z = -0.3 * 0x1p-23;
  check_presets(c);
}

TEST_CASE("reference: Gaussians with a number that is not finite agree with the oracle") {
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    Random random(110);
    Case c{.scene = mixture(random, 240, 3)};
    for (std::size_t i = 0; i < c.scene.size(); i += 2) {
      if (i % 12 == 0) c.scene.means[i][int(i / 12 % 3)] = bad;
      if (i % 12 == 2) c.scene.scales[i].y = bad;
      if (i % 12 == 4) c.scene.rotations[i].z = bad;
      if (i % 12 == 6) c.scene.opacities[i] = bad;
      if (i % 12 == 8) c.scene.sh0[i].y = bad;
      if (i % 12 == 10) c.scene.sh_rest[45 * i + i % 45] = bad;
    }
    check_presets(c);
  }
}

TEST_CASE("reference: splats of too large a variance agree with the oracle") {
  Random random(120);
  Case c{.scene = mixture(random, 200)};
  for (std::size_t i = 0; i < c.scene.size(); ++i) {
    c.scene.opacities[i] *= 0.1f;
    c.scene.scales[i] = vec3(float(random.scale(1e12, 1e22)));
    c.scene.means[i].z = std::abs(c.scene.means[i].z) + 0.5f;
  }
  check_presets(c);
}

TEST_CASE("reference: the frame does not depend on the number of threads") {
  Random random(4);
  const Scene scene = mixture(random, 300);
  const Camera camera = oracle_camera();
  const ReferenceFrame one = render_reference(scene, camera, Conventions::gsplat(), dvec3(0.5), 1);
  for (const int threads : {0, 2, 3, 8}) {
    const ReferenceFrame frame = render_reference(scene, camera, Conventions::gsplat(), dvec3(0.5), threads);
    CHECK(frame.colour == one.colour);
    CHECK(frame.alpha == one.alpha);
    CHECK(frame.depth == one.depth);
    CHECK(frame.visible == one.visible);
    CHECK(frame.contributing_pairs == one.contributing_pairs);
    CHECK(frame.pixels_stopped == one.pixels_stopped);
  }
}

}  // namespace
}  // namespace swiftgs::test
