// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "colour.hpp"
#include "policies/random_splats.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

dmat3 random_matrix(Random& random) {
  const Quaternion q = random_rotation(random);
  return matrix_of(unit(DQuaternion{q.w, q.x, q.y, q.z}));
}

dvec3 random_direction(Random& random) {
  const double z = random.in(-1, 1), turn = random.in(0, 2 * std::numbers::pi), radius = std::sqrt(1 - z * z);
  return dvec3(radius * std::cos(turn), radius * std::sin(turn), z);
}

double largest(const dmat3& m) {
  double most = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) most = std::max(most, std::abs(m[i][j]));
  return most;
}

dmat3 covariance(const Scene& scene, std::size_t i) {
  const Quaternion& q = scene.rotations[i];
  const dmat3 axes = matrix_of(DQuaternion{q.w, q.x, q.y, q.z});
  const dvec3 s = dvec3(scene.scales[i]);
  const dmat3 columns(axes[0] * s.x, axes[1] * s.y, axes[2] * s.z);
  return columns * glm::transpose(columns);
}

Similarity random_similarity(Random& random, double scale) {
  Similarity by;
  by.rotation = random_matrix(random), by.scale = scale;
  by.translation = dvec3(random.in(-3, 3), random.in(-3, 3), random.in(-3, 3));
  return by;
}

dmat3 diagonal(const dmat3& axes, const dvec3& lengths) {
  return dmat3(axes[0] * lengths.x, axes[1] * lengths.y, axes[2] * lengths.z);
}

/// Lengths of an ellipsoid whose longest axis is up to `aspect` times its shortest, in any order.
dvec3 thin(Random& random, double aspect) {
  const double most = std::log(aspect);
  return {std::exp(-random.in(0, most)), std::exp(-random.in(0, most)), std::exp(-random.in(0, most))};
}

std::vector<double> image(const Scene& scene, const Camera& camera) {
  return render_reference(scene, camera, Conventions::gsplat()).colour;
}

}  // namespace

TEST_CASE("edit: a quaternion and its matrix are the same rotation") {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const dmat3 m = random_matrix(random);
    CHECK(largest(matrix_of(quaternion_of(m)) - m) < 1e-14);
    const dmat3 other = random_matrix(random);
    CHECK(largest(matrix_of(quaternion_of(m) * quaternion_of(other)) - m * other) < 1e-14);
  }
  // Half turns, where a quaternion's scalar part is zero.
  for (int axis = 0; axis < 3; ++axis) {
    dmat3 half(-1.0);
    half[axis][axis] = 1;
    CHECK(largest(matrix_of(quaternion_of(half)) - half) == 0);
  }
}

TEST_CASE("edit: rotating harmonics and direction together keeps the colour") {
  for (const bool mirror : {false, true})
    for (int degree = 0; degree <= max_sh_degree; ++degree) {
      CAPTURE(mirror);
      CAPTURE(degree);
      Random random(std::uint64_t(degree) + 5);
      for (int i = 0; i < 50; ++i) {
        const Scene before = random_scene(1, degree, random.bits());
        const dmat3 rotation = random_matrix(random) * (mirror ? dmat3(-1.0) : dmat3(1.0));
        Scene after = before;
        ShRotation(rotation, degree).apply(after.sh_rest.data());
        for (int j = 0; j < 20; ++j) {
          const dvec3 d = random_direction(random), turned = rotation * d;
          const Eigen::Vector3d expected = reference::colour(before, 0, {d.x, d.y, d.z});
          const Eigen::Vector3d got = reference::colour(after, 0, {turned.x, turned.y, turned.z});
          CHECK((expected - got).cwiseAbs().maxCoeff() < 4e-7);
        }
      }
    }
}

TEST_CASE("edit: a movement takes along means, shapes and nothing else") {
  Random random(7);
  Scene before = random_scene(200, 3, 11);
  before.model.antialiased = true;
  const Similarity by = random_similarity(random, 2.5);
  Scene after = before;
  transform(after, by);
  validate(after);
  for (std::size_t i = 0; i < before.size(); ++i) {
    CHECK(glm::length(dvec3(after.means[i]) - by(dvec3(before.means[i]))) < 1e-5);
    const dmat3 expected =
        by.scale * by.scale * by.rotation * covariance(before, i) * glm::transpose(by.rotation);
    CHECK(largest(covariance(after, i) - expected) < 2e-6 * largest(expected));
  }
  CHECK(after.opacities == before.opacities);
  CHECK((after.sh0 == before.sh0));
  CHECK(after.model.antialiased);

  transform(after, inverse(by));
  for (std::size_t i = 0; i < before.size(); ++i) {
    CHECK(glm::length(dvec3(after.means[i]) - dvec3(before.means[i])) < 1e-5);
    CHECK(largest(covariance(after, i) - covariance(before, i)) < 4e-6 * largest(covariance(before, i)));
  }
  for (std::size_t k = 0; k < before.sh_rest.size(); ++k)
    CHECK(after.sh_rest[k] == doctest::Approx(before.sh_rest[k]).epsilon(1e-6));
}

TEST_CASE("edit: no movement changes nothing, not even rotations that are not of unit length") {
  Scene before = random_scene(50, 3, 3);
  before.rotations[4] = {2, 0, -1, 0};
  Scene after = before;
  transform(after, {});
  CHECK((after.means == before.means));
  CHECK((after.scales == before.scales));
  CHECK((after.rotations == before.rotations));
  for (std::size_t k = 0; k < before.sh_rest.size(); ++k)
    CHECK(after.sh_rest[k] == doctest::Approx(before.sh_rest[k]).epsilon(1e-6));
}

TEST_CASE("edit: a moved scene seen by a moved camera is the same image, however long its rotations are") {
  const Camera camera = builtin_cameras(1, 320, 180).front();
  Random random(5);
  for (const auto& [length, scale] : {std::pair{1.0, 1.0},
                                      {1.0, 0.4},
                                      {1.0, 7.0},
                                      {0.5, 1.7},
                                      {0.7071067811865476, 1.7},
                                      {0.9, 1.7},
                                      {1.001, 1.7},
                                      {1.1, 1.7},
                                      {2.0, 1.7}}) {
    CAPTURE(length);
    CAPTURE(scale);
    Scene scene = make_builtin_scene(5'000);
    for (Quaternion& q : scene.rotations)
      q = rounded({length * q.w, length * q.x, length * q.y, length * q.z});
    const Similarity by = random_similarity(random, scale);
    Scene moved = scene;
    transform(moved, by);
    const std::vector<double> expected = image(scene, camera);
    CHECK(psnr(image(moved, transformed(camera, by)), expected) >= 100);
    // Harmonics that stay behind are another image.
    moved.sh_rest = scene.sh_rest;
    CHECK(psnr(image(moved, transformed(camera, by)), expected) < 60);
  }
}

TEST_CASE("edit: a stretch gives each Gaussian the axes of its covariance, however thin it is") {
  Random random(12);
  for (int i = 0; i < 2'000; ++i) {
    const dmat3 axes = random_matrix(random);
    const dmat3 linear = diagonal(random_matrix(random), thin(random, 1e3)) * random_matrix(random);
    const dvec3 scale = thin(random, i % 2 == 0 ? 1 : 1e6);
    const detail::Shape after = detail::stretched({scale, quaternion_of(axes)}, linear);
    // Where the covariances are the same, the new factor's inverse times the old one is orthogonal. Its rows
    // are divided by the new lengths, so the thinnest axis counts as much as the longest.
    dmat3 factor = glm::transpose(matrix_of(after.rotation)) * (linear * diagonal(axes, scale));
    for (int column = 0; column < 3; ++column) factor[column] /= after.scale;
    CHECK(largest(factor * glm::transpose(factor) - dmat3(1.0)) < 1e-8);
  }
}

TEST_CASE("edit: a stretch moves means and turns harmonics by the rotation in it") {
  Random random(13);
  for (int round = 0; round < 20; ++round) {
    CAPTURE(round);
    const Scene before = random_scene(20, 3, random.bits());
    const dmat3 turn = random_matrix(random), across = random_matrix(random);
    const dvec3 lengths(random.in(0.5, 2), random.in(0.1, 1), random.in(1, 5));
    const Affine by{turn * diagonal(across, lengths) * glm::transpose(across), {1, -2, 3}};
    Scene after = before;
    stretch(after, by, {1, 1, 1});
    validate(after);
    CHECK(after.origin == dvec3(1));
    CHECK(largest(rotation_of(by) - turn) < 1e-13);
    for (std::size_t i = 0; i < before.size(); ++i) {
      CHECK(glm::length(dvec3(after.means[i]) + dvec3(1) - by(dvec3(before.means[i]))) < 1e-5);
      const dmat3 expected = by.linear * covariance(before, i) * glm::transpose(by.linear);
      CHECK(largest(covariance(after, i) - expected) < 2e-6 * largest(expected));
      const dvec3 d = random_direction(random), turned = turn * d;
      const Eigen::Vector3d was = reference::colour(before, int(i), {d.x, d.y, d.z});
      const Eigen::Vector3d is = reference::colour(after, int(i), {turned.x, turned.y, turned.z});
      CHECK((was - is).cwiseAbs().maxCoeff() < 4e-7);
    }
    CHECK(after.opacities == before.opacities);
    CHECK((after.sh0 == before.sh0));
  }
}

TEST_CASE("edit: the rotation in a rotation after a stretch along the axes is that rotation") {
  Random random(14);
  for (int i = 0; i < 1'000; ++i) {
    const dmat3 turn = random_matrix(random);
    CHECK(largest(rotation_of({diagonal(turn, thin(random, 1e9))}) - turn) < 1e-14);
  }
  CHECK(rotation_of({dmat3(1e-60)}) == dmat3(1.0));
  CHECK(rotation_of({diagonal(dmat3(1.0), {1e60, 1, 1e-60})}) == dmat3(1.0));
}

TEST_CASE("edit: a stretch that is a similarity does what the similarity does") {
  Random random(15);
  const Scene before = random_scene(50, 3, 16);
  const Affine whole{dmat3(2.0), {0.5, 1, 2}};
  Scene stretched = before, transformed = before;
  stretch(stretched, whole, dvec3(0));
  transform(transformed, {.scale = 2, .translation = whole.translation}, dvec3(0));
  CHECK((stretched.means == transformed.means));
  CHECK((stretched.scales == transformed.scales));
  CHECK((stretched.rotations == transformed.rotations));
  CHECK(stretched.sh_rest == transformed.sh_rest);
}

TEST_CASE("edit: a stretched disk stays a disk, and a stretched needle a needle") {
  Random random(17);
  Scene before = random_scene(100, 0, 18);
  for (std::size_t i = 0; i < 100; ++i)
    before.scales[i][int(i % 3)] = 0, before.scales[i][int((i + 1) % 3)] *= i % 2 == 0 ? 1.0f : 0.0f;
  before.scales[99] = vec3(0);
  const Affine by{diagonal(random_matrix(random), {3, 1, 0.2}) * random_matrix(random)};
  Scene after = before;
  stretch(after, by, dvec3(0));
  for (std::size_t i = 0; i < 100; ++i) {
    CHECK(after.scales[i].z == 0);
    CHECK((after.scales[i].y == 0) == (i % 2 == 1));
    const dmat3 expected = by.linear * covariance(before, i) * glm::transpose(by.linear);
    CHECK(largest(covariance(after, i) - expected) <= 2e-6 * largest(expected));
  }
}

TEST_CASE("edit: rotations that are not of unit length are stretched as the matrices that they stand for") {
  Scene before = random_scene(20, 0, 19);
  for (Quaternion& q : before.rotations) q.w *= 1.5f, q.y *= 0.5f;
  const Affine by{dmat3(1, 0, 0, 0.5, 2, 0, 0, 0, 0.3)};
  Scene after = before;
  stretch(after, by, dvec3(0));
  for (std::size_t i = 0; i < 20; ++i) {
    const dmat3 expected = by.linear * covariance(before, i) * glm::transpose(by.linear);
    CHECK(largest(covariance(after, i) - expected) < 2e-6 * largest(expected));
  }
}

TEST_CASE("edit: stretches that mirror, flatten or leave the range of float are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expected = [](const Affine& by) { return std::string(by.unmet() ? by.unmet() : ""); };
  const auto sheared = [](double part) { return Affine{dmat3(1, 0, 0, 1, part, 0, 0, 0, 1)}; };
  CHECK(expected({}) == "");
  CHECK(expected(sheared(1e-8)) == "");
  CHECK(expected(sheared(1e-10)) == "a matrix that does not flatten");
  CHECK(expected(sheared(-1e-8)) == "a matrix that does not mirror");
  CHECK(expected({diagonal(dmat3(1.0), {1, 1, -1})}) == "a matrix that does not mirror");
  CHECK(expected({diagonal(dmat3(1.0), {-1, 1, -1})}) == "");  // half a turn
  CHECK(expected({diagonal(dmat3(1.0), {1, 1, 1e-30})}) == "");
  for (const double length : {0.0, nan, 1e-61, 1e61, 1e300})
    CHECK(expected({diagonal(dmat3(1.0), {1, length, 1})}) ==
          "a matrix of columns with lengths of 1e-60 to 1e60");
  CHECK(expected({.translation = dvec3(nan, 0, 0)}) == "a finite translation");

  Scene scene = random_scene(3, 1, 2);
  const Scene before = scene;
  CHECK_THROWS_AS(stretch(scene, sheared(-1), dvec3(0)), std::invalid_argument);
  CHECK_THROWS_AS(rotation_of(sheared(-1)), std::invalid_argument);
  CHECK_THROWS_AS(origin_for(scene, sheared(-1)), std::invalid_argument);
  for (const double scale : {1e50, 1e-50})
    CHECK_THROWS_WITH_AS(stretch(scene, {diagonal(dmat3(1.0), {1, 1, scale})}, dvec3(0)),
                         doctest::Contains("Gaussian 0"), std::range_error);
  CHECK((scene.means == before.means));
  CHECK((scene.scales == before.scales));
  CHECK((scene.rotations == before.rotations));
  CHECK(scene.sh_rest == before.sh_rest);
  // What is not drawn may move.
  scene.scales[1].y = INFINITY, scene.rotations[2].w = float(nan), scene.means[0].z = float(nan);
  stretch(scene, sheared(2), dvec3(0));
  CHECK(scene.scales[1].y == INFINITY);
  CHECK(std::isnan(scene.rotations[2].w));
  CHECK(std::isnan(scene.means[0].z));
}

TEST_CASE("edit: harmonics that a rotation would take out of the range of float are refused") {
  Random random(9);
  int moved = 0, refused = 0, infinite = 0;
  for (int round = 0; round < 2'000; ++round) {
    Scene scene = random_scene(1, 3, 1);
    const float largest = random.f(0.5e38, 3.4e38);
    for (float& coefficient : scene.sh_rest) coefficient = random.bits() % 2 == 0 ? largest : -largest;
    try {
      transform(scene, random_similarity(random, 1));
      ++moved;
    } catch (const std::range_error&) {
      ++refused;
    }
    for (const float coefficient : scene.sh_rest) infinite += !std::isfinite(coefficient);
  }
  CHECK(infinite == 0);
  CHECK(moved > 200);
  CHECK(refused > 200);
}

TEST_CASE("edit: bad movements are refused, and one out of the range of float moves nothing") {
  Scene scene = random_scene(3, 1, 2);
  scene.means[2].x = 3e38f;
  const Scene before = scene;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double scale : {0.0, -1.0, nan, double(INFINITY)})
    CHECK_THROWS_AS(transform(scene, Similarity{.scale = scale}), std::invalid_argument);
  CHECK_THROWS_AS(transform(scene, Similarity{.rotation = dmat3(1.1)}), std::invalid_argument);
  CHECK_THROWS_AS(transform(scene, Similarity{.rotation = dmat3(-1.0)}), std::invalid_argument);
  CHECK_THROWS_AS(transform(scene, Similarity{.translation = dvec3(0, nan, 0)}), std::invalid_argument);
  CHECK_THROWS_WITH_AS(transform(scene, Similarity{.scale = 2}), doctest::Contains("Gaussian 2"),
                       std::range_error);
  CHECK_THROWS_AS(transform(scene, Similarity{.scale = 1e-60}), std::range_error);
  scene.means[2].x = 0, scene.scales[2].y = 3e38f;
  CHECK_THROWS_WITH_AS(transform(scene, Similarity{.scale = 2}), doctest::Contains("Gaussian 2"),
                       std::range_error);
  // An infinite length stays so and excuses no other axis.
  scene.scales[2].x = INFINITY;
  CHECK_THROWS_AS(transform(scene, Similarity{.scale = 2}), std::range_error);
  Scene tiny = random_scene(1, 0, 2);
  tiny.scales[0] = vec3(1e-20f);
  CHECK_THROWS_AS(transform(tiny, Similarity{.scale = 1e-310}), std::range_error);  // 0 in double already
  scene.scales[2] = before.scales[2], scene.sh_rest.back() = -3e38f;
  CHECK_THROWS_WITH_AS(transform(scene, {}), doctest::Contains("Gaussian 2"), std::range_error);
  scene.means[2].x = before.means[2].x, scene.sh_rest.back() = before.sh_rest.back();
  CHECK((scene.means == before.means));
  CHECK((scene.scales == before.scales));
  CHECK((scene.rotations == before.rotations));
  CHECK((scene.sh_rest == before.sh_rest));
  CHECK_THROWS_AS(ShRotation(dmat3(1.0), 4), std::invalid_argument);
  // What is not drawn may move.
  scene.means[2].x = 0, scene.means[1].x = std::numeric_limits<float>::quiet_NaN();
  transform(scene, Similarity{.translation = dvec3(1, 0, 0)});
  CHECK(scene.means[0].x == doctest::Approx(before.means[0].x + 1));
}
