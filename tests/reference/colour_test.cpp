// SPDX-License-Identifier: Apache-2.0
#include "colour.hpp"

#include <array>
#include <cmath>
#include <cstddef>

#include <doctest/doctest.h>

#include "reference/gaussians.hpp"

namespace swiftgs::test {
namespace {

const double pi = std::acos(-1.0);

Eigen::Vector3d on_sphere(double z, double phi) {
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Associated Legendre function P_l^m(z), m >= 0, with the Condon-Shortley sign, by its recurrence in l.
double legendre(int l, int m, double z) {
  double previous = 0, current = 1;
  for (int i = 1; i <= m; ++i) current *= -(2 * i - 1) * std::sqrt(1 - z * z);
  for (int i = m + 1; i <= l; ++i) {
    const double next = ((2 * i - 1) * z * current - (i + m - 1) * previous) / (i - m);
    previous = current, current = next;
  }
  return current;
}

/// Real spherical harmonic of band l, order m, from its definition in angles.
double harmonic(int l, int m, double z, double phi) {
  const int order = std::abs(m);
  const double norm =
      std::sqrt((2 * l + 1) / (4 * pi) * std::tgamma(l - order + 1) / std::tgamma(l + order + 1));
  const double angle = m == 0 ? 1 : std::sqrt(2.0) * (m > 0 ? std::cos(m * phi) : std::sin(order * phi));
  return norm * legendre(l, order, z) * angle;
}

TEST_CASE("reference: each SH function is the textbook's, sign included") {
  double worst = 0;
  for (int i = 0; i < 50; ++i) {
    const double z = -0.98 + 0.04 * i, phi = 2.4 * i;
    const std::array<double, 16> basis = reference::sh_basis(on_sphere(z, phi));
    for (int l = 0; l <= 3; ++l)
      for (int m = -l; m <= l; ++m)
        worst = std::max(worst, std::abs(basis[std::size_t(l * l + l + m)] - harmonic(l, m, z, phi)));
  }
  CHECK(worst < 1e-14);
}

TEST_CASE("reference: bands are evaluated in the direction from the camera to the Gaussian") {
  // The camera stands at (1, 2, 3), turned so that it looks along (2, -1, 2) / 3.
  const dvec3 eye(1, 2, 3), target(3, 1, 5);
  const Camera camera = look_at(eye, target, dvec3(0, 1, 0), 0.5, 33, 33);
  const double z = 2.0 / 3, phi = std::atan2(-1.0, 2.0);
  for (int degree = 1; degree <= 3; ++degree) {
    Scene scene = scene_of(Gaussian{.mean = {3, 1, 5}, .opacity = 0.5f, .sh0 = vec3(1)});
    scene.sh_degree = degree;
    double expected = 0.5 + sh_c0;
    for (int l = 1; l <= degree; ++l)
      for (int m = -l; m <= l; ++m) {
        const float coefficient = 0.03125f * float(1 + l * l + l + m);
        scene.sh_rest.insert(scene.sh_rest.end(), 3, coefficient);
        expected += double(coefficient) * harmonic(l, m, z, phi);
      }
    const ReferenceFrame frame = render_reference(scene, camera, Conventions::gsplat());
    CHECK(colour_at(frame, 16, 16, 1) == doctest::Approx(0.5 * std::max(0.0, expected)).epsilon(1e-13));
  }
}

}  // namespace
}  // namespace swiftgs::test
