// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>

#include <doctest/doctest.h>

#include "reference/gaussians.hpp"

namespace swiftgs::test {
namespace {

const Conventions square = [] {
  Conventions k = Conventions::gsplat();
  k.footprint = Conventions::Footprint::three_sigma_square;
  return k;
}();

/// A Gaussian parallel to the image, round there, whose mean is (x, y), pixel centres at + 0.5, with standard
/// deviation `sigma` before blur @units{pixels}.
Scene round_at(double x, double y, double sigma, const Camera& camera) {
  return scene_of(Gaussian{.mean = {float((x - camera.cx) / 32), float((y - camera.cy) / 32), 2},
                           .scale = {float(sigma / 32), float(sigma / 32), 0},
                           .opacity = 1});
}

TEST_CASE("reference: the three-sigma square keeps its tiles and drops every other pixel") {
  // Variance 99.7 + 0.3: radius ceil(3 sqrt(100.3)) = 31, where alpha >= 1/255 reaches 33.3 pixels. From
  // pixel 47 the square spans 16 to 78: tiles 1 to 4, pixels 16 to 79.
  const Camera camera = small_camera(128, 128, 64);
  const Scene scene = round_at(47.5, 47.5, std::sqrt(99.7), camera);
  const ReferenceFrame whole = render_reference(scene, camera, Conventions::gsplat());
  const ReferenceFrame cut = render_reference(scene, camera, square);
  std::uint64_t kept = 0, dropped = 0;
  bool exact = true;
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) {
      const bool inside = x >= 16 && x < 80 && y >= 16 && y < 80;
      exact = exact && alpha_at(cut, x, y) == (inside ? alpha_at(whole, x, y) : 0);
      (inside ? kept : dropped) += alpha_at(whole, x, y) > 0;
    }
  CHECK(exact);
  CHECK(alpha_at(whole, 15, 47) > 0);
  CHECK(alpha_at(whole, 14, 47) > 0);
  CHECK(alpha_at(whole, 80, 47) > 0);
  CHECK(dropped > 20);
  CHECK(cut.contributing_pairs == kept);
  CHECK(whole.contributing_pairs == kept + dropped);
}

TEST_CASE("reference: the three-sigma square's end is rounded as if it were 15 pixels further") {
  // Radius 31 as above. The last tile starts at 16 floor((p + 31 + 15) / 16) - 16: a mean at p = 50 ends the
  // square at pixel 96, one at 49.9 at pixel 80.
  const Camera camera = small_camera(128, 128, 64);
  const double sigma = std::sqrt(99.7);
  const auto reaches = [&](double p, int x) {
    return alpha_at(render_reference(round_at(p + 0.5, 64, sigma, camera), camera, square), x, 64) > 0;
  };
  CHECK(reaches(50, 80));
  CHECK_FALSE(reaches(49.9, 80));
  CHECK(reaches(49.9, 79));
}

TEST_CASE("reference: the three-sigma square uses at least the root of 0.1 between the eigenvalues") {
  // Variance 10.78 + 0.3: 3 sqrt(11.08) = 9.99, but 3 sqrt(11.08 + sqrt(0.1)) = 10.13, so the radius is 11.
  // From pixel 42 that is pixel 31, in tile 1; 10 would begin with tile 2. Alpha reaches 11.08 pixels.
  const Camera camera = small_camera(64, 64, 64);
  const Scene scene = round_at(42.5, 32.5, std::sqrt(10.78), camera);
  const ReferenceFrame whole = render_reference(scene, camera, Conventions::gsplat());
  REQUIRE(alpha_at(whole, 31, 32) > 0);
  CHECK(alpha_at(render_reference(scene, camera, square), 31, 32) == alpha_at(whole, 31, 32));
}

TEST_CASE("reference: a three-sigma square off the image draws nothing where the ellipse still would") {
  // Radius 31; p = -32.2 ends the square at pixel -1.2, and alpha reaches pixel 0 (33.3 pixels).
  const Camera camera = small_camera(64, 64, 64);
  const Scene scene = round_at(-31.7, 32.5, std::sqrt(99.7), camera);
  CHECK(render_reference(scene, camera, Conventions::gsplat()).contributing_pairs > 0);
  CHECK(render_reference(scene, camera, square).contributing_pairs == 0);
  CHECK(Conventions::inria().footprint == Conventions::Footprint::three_sigma_square);
  CHECK(Conventions::gsplat().footprint == Conventions::Footprint::alpha);
}

}  // namespace
}  // namespace swiftgs::test
