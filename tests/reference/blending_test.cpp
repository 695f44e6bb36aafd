// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <stdexcept>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>

#include "reference/gaussians.hpp"

namespace swiftgs::test {
namespace {

// sh0 of these: colour 0.5 + C0 in one channel, 0 in the others.
const vec3 red{1, -2, -2}, green{-2, 1, -2};
const double bright = 0.5 + sh_c0;

TEST_CASE("reference: an empty scene is background with no alpha and no depth") {
  const ReferenceFrame frame =
      render_reference(Scene{}, small_camera(5, 4), Conventions::gsplat(), dvec3(0.25, 0.5, 2));
  REQUIRE(frame.colour.size() == 60);
  CHECK(colour_at(frame, 4, 3, 0) == 0.25);
  CHECK(colour_at(frame, 0, 0, 2) == 2);
  CHECK(frame.alpha == std::vector<double>(20, 0.0));
  CHECK(frame.depth == std::vector<double>(20, 0.0));
  CHECK(frame.visible + frame.contributing_pairs + frame.pixels_stopped == 0);
}

TEST_CASE("reference: alpha is cut at alpha_max") {
  CHECK(alpha_at(draw(scene_of(Gaussian{.opacity = 1})), 16, 16) ==
        doctest::Approx(double(0.99f)).epsilon(1e-15));
}

TEST_CASE("reference: without a threshold a Gaussian reaches every pixel unless its opacity is 0") {
  Conventions k;
  k.alpha_min = 0;
  CHECK(draw(scene_of(Gaussian{.opacity = 0}), k).alpha == std::vector<double>(33 * 33, 0.0));
  const ReferenceFrame frame = draw(scene_of(Gaussian{}), k);
  CHECK(frame.contributing_pairs == 33 * 33);
  CHECK(alpha_at(frame, 0, 16) > 0);
}

TEST_CASE("reference: depths that are equal or are so once rounded to float keep index order") {
  for (const double away : {0.0, 1000.0}) {
    Camera camera = small_camera();
    camera.translation = dvec3(0, 0, away);
    // 1002 and 1002 + 2^-22 in double; floats are 2^-14 apart there.
    const float further = away > 0 ? std::nextafter(2.0f, 3.0f) : 2;
    const Scene scene = scene_of(Gaussian{.mean = {0, 0, further}, .opacity = 0.5f, .sh0 = red},
                                 Gaussian{.mean = {0, 0, 2}, .opacity = 0.5f, .sh0 = green});
    const ReferenceFrame frame = render_reference(scene, camera, Conventions::gsplat());
    CHECK(colour_at(frame, 16, 16, 0) == doctest::Approx(0.5 * bright).epsilon(1e-15));
    CHECK(colour_at(frame, 16, 16, 1) == doctest::Approx(0.25 * bright).epsilon(1e-15));
  }
}

TEST_CASE("reference: the Gaussian that would bring transmittance below the stop ends its pixel") {
  // In the middle pixel transmittance is 1/2 after the first and 1/4 after the second; the third is faint
  // enough to pass alone.
  const Scene scene =
      scene_of(Gaussian{.mean = {0, 0, 2}, .opacity = 0.5f}, Gaussian{.mean = {0, 0, 3}, .opacity = 0.5f},
               Gaussian{.mean = {0, 0, 4}, .opacity = 0.125f});
  Conventions k;
  for (const auto& [stop, at_equal, alpha] :
       {std::tuple{0.25f, true, 0.5}, {0.25f, false, 0.75}, {0.2f, false, 0.78125}}) {
    k.stop = stop, k.stop_at_equal = at_equal;
    CHECK(alpha_at(draw(scene, k), 16, 16) == alpha);
  }
}

}  // namespace
}  // namespace swiftgs::test
