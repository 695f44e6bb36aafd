// SPDX-License-Identifier: Apache-2.0

// Projection in pairs of floats against projection in double.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include <doctest/doctest.h>

#include <swiftgs/project/colour.hpp>
#include <swiftgs/project/project.hpp>

#include "reference/pair_cases.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

double ulp(float value) { return std::nextafter(std::abs(value), INFINITY) - std::abs(value); }

/// How splats of pairs differ from those of doubles.
struct Differences {
  std::size_t visible = 0;                ///< in double
  std::size_t alone = 0;                  ///< visible in one of both
  std::size_t means = 0;                  ///< splats whose means differ by more than a unit of what is kept
  std::size_t depths = 0;                 ///< splats whose depths' bits differ
  double mean_ulps = 0, mean_pixels = 0;  ///< at most; ulps of a thousandth of a pixel at least
  double depth_ulps = 0;                  ///< at most

  void add(const ProjectedShape& in_double, const ProjectedShape& in_pairs) {
    visible += in_double.visible, alone += in_double.visible != in_pairs.visible;
    if (!in_double.visible || !in_pairs.visible) return;
    depths += in_double.depth != in_pairs.depth;
    bool differs = false;
    for (int k = 0; k < 2; ++k) {
      const double exact = in_double.shape.exact_mean()[k];
      const double off = std::abs(in_pairs.shape.exact_mean()[k] - exact);
      differs = differs || off > double(SplatShape::low_unit);
      mean_pixels = std::max(mean_pixels, off);
      mean_ulps = std::max(mean_ulps, off / ulp(float(std::max(std::abs(exact), 1e-3))));
    }
    means += differs;
    const double off = std::abs(double(in_pairs.depth) - in_double.depth);
    depth_ulps = std::max(depth_ulps, off / ulp(in_double.depth));
  }
};

Differences differences(const ViewConstants& view, const Scene& scene) {
  Differences out;
  const SceneView all = swiftgs::view(scene);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Gaussian g = gaussian(all, i);
    out.add(project_through_pinhole<double>(view, g), project_through_pinhole<FloatPair>(view, g));
  }
  return out;
}

/// Whether digits cancel that pairs do not have: camera and scene a million units off, or a camera that is
/// ten million units from its scene; a principal point ten million pixels off; or depths beyond 2^102.
bool cancels(const PairCase& c) {
  return c.severity >= 1e6 && (c.name == "moved" || c.name == "moved-long" || c.name == "distant-cameras" ||
                               c.name == "principal-points" || (c.name == "far-depths" && c.severity > 1e30));
}

}  // namespace

TEST_CASE("pairs: means and depths are within an ulp of those in double") {
  std::size_t visible = 0, means = 0, depths = 0;
  for (const PairCase& c : pair_cases()) {
    CAPTURE(c.name);
    CAPTURE(c.severity);
    const Differences d = differences(c.view, c.scene);
    CHECK(d.alone == 0);
    CHECK(d.depth_ulps <= 1);
    if (cancels(c)) {
      CHECK(d.mean_pixels <= 2 * ulp(c.view.width));
    } else {
      CHECK(d.mean_ulps <= 1);
      visible += d.visible, means += d.means, depths += d.depths;
    }
  }
  CHECK(visible > 200'000);
  CHECK(means <= 10);
  CHECK(depths <= 10);
}

TEST_CASE("pairs: at the ends of float's range a Gaussian is drawn as in double or not at all") {
  stress::Random random(5);
  std::size_t drawn = 0, wrong = 0;
  double depth_ulps = 0, pixels = 0;
  const ImageSize size{640, 480};
  for (int i = 0; i < 40'000; ++i) {
    Conventions conventions;
    conventions.near_plane = 0, conventions.far_plane = INFINITY;
    const double z = i % 2 ? random.scale(1e-28, 1e-20) : random.scale(1e28, 1e39);
    const dvec3 ahead(random.in(-1, 1), random.in(-0.6, 0.6), 1);
    Camera camera = look_at(dvec3(0), dvec3(random.in(-1, 1), random.in(-1, 1), random.in(0.1, 1)),
                            dvec3(0.1, -1, 0.2), 0.9, size.width, size.height);
    const dvec3 centre = i % 3 ? z * dvec3(random.in(-1, 1), random.in(-1, 1), random.in(-1, 1)) : dvec3(0);
    camera.translation = -(camera.rotation * centre);
    const ViewConstants view = view_constants(camera, conventions);
    const auto scale = float(0.001 * z);
    const Gaussian g{vec3(z * ahead * camera.rotation + centre), vec3(scale), {}, 0.5f};
    const ProjectedShape in_double = project_through_pinhole<double>(view, g);
    const ProjectedShape in_pairs = project_through_pinhole<FloatPair>(view, g);
    Differences d;
    d.add(in_double, in_pairs);
    drawn += in_pairs.visible, wrong += in_pairs.visible && !in_double.visible;
    depth_ulps = std::max(depth_ulps, d.depth_ulps), pixels = std::max(pixels, d.mean_pixels);
    // Only beyond half of the largest float.
    if (in_double.visible && !in_pairs.visible) CHECK(z > 0x1p126);
  }
  CHECK(drawn > 10'000);
  CHECK(wrong == 0);
  CHECK(depth_ulps <= 1);
  CHECK(pixels <= 4 * ulp(640));
}

TEST_CASE("pairs: what is not finite in pairs is not drawn") {
  Camera camera = stress::forward_camera({}, 50);
  const Gaussian g{{0, 0, 2}, vec3(0.1f), {}, 0.5f};
  REQUIRE(project_through_pinhole<FloatPair>(view_constants(camera, {}), g).visible);
  for (const double far : {1e39, -1e300})
    for (int axis = 0; axis < 3; ++axis) {
      Camera moved = camera;
      moved.translation[axis] = far;
      const ViewConstants view = view_constants(moved, {});
      CHECK(!project_through_pinhole<double>(view, g).visible);
      CHECK(!project_through_pinhole<FloatPair>(view, g).visible);
    }
  for (const float bad : {INFINITY, -INFINITY, NAN})
    for (int axis = 0; axis < 3; ++axis) {
      Gaussian hostile = g;
      hostile.mean[axis] = bad;
      CHECK(!project_through_pinhole<FloatPair>(view_constants(camera, {}), hostile).visible);
    }
}

TEST_CASE("pairs: directions are those in double") {
  std::size_t all = 0, different = 0;
  double most = 0;
  for (const PairCase& c : pair_cases()) {
    if (cancels(c)) continue;
    for (const vec3& mean : c.scene.means) {
      const vec3 in_double = view_direction<double>(c.view, mean),
                 in_pairs = view_direction<FloatPair>(c.view, mean);
      for (int k = 0; k < 3; ++k) most = std::max(most, std::abs(double(in_double[k]) - in_pairs[k]));
      ++all, different += in_double != in_pairs;
    }
  }
  CHECK(most <= 0x1p-22);
  CHECK(different * 100 <= all);
}
