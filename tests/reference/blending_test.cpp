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

TEST_CASE("reference: a pixel is reached up to the radius where alpha falls to alpha_min") {
  for (const float opacity : {0.0039f, 0.004f, 0.02f, 0.3f, 1.0f}) {
    const ReferenceFrame frame = draw(scene_of(Gaussian{.opacity = opacity}));
    const double variance = std::pow(20 * double(0.1f), 2) + double(0.3f);
    const double log_ratio = std::log(double(opacity) / double(1.0f / 255));
    std::uint64_t inside = 0;
    for (int y = -16; y <= 16; ++y)
      for (int x = -16; x <= 16; ++x) inside += x * x + y * y <= 2 * variance * log_ratio;
    CHECK(frame.contributing_pairs == inside);
    CHECK(frame.visible == (inside > 0));
  }
}

TEST_CASE("reference: without a threshold a Gaussian reaches every pixel unless its opacity is 0") {
  Conventions k;
  k.alpha_min = 0;
  CHECK(draw(scene_of(Gaussian{.opacity = 0}), k).alpha == std::vector<double>(33 * 33, 0.0));
  const ReferenceFrame frame = draw(scene_of(Gaussian{}), k);
  CHECK(frame.contributing_pairs == 33 * 33);
  CHECK(alpha_at(frame, 0, 16) > 0);
}

TEST_CASE("reference: the nearer Gaussian is in front whatever the order in the scene") {
  const Gaussian front{.mean = {0, 0, 2}, .opacity = 0.5f, .sh0 = red};
  const Gaussian back{.mean = {0, 0, 3}, .opacity = 0.25f, .sh0 = green};
  for (const Scene& scene : {scene_of(front, back), scene_of(back, front)}) {
    const ReferenceFrame frame = draw(scene, Conventions::gsplat(), dvec3(0, 0, 1));
    CHECK(colour_at(frame, 16, 16, 0) == doctest::Approx(0.5 * bright).epsilon(1e-15));
    CHECK(colour_at(frame, 16, 16, 1) == doctest::Approx(0.125 * bright).epsilon(1e-15));
    CHECK(colour_at(frame, 16, 16, 2) == 0.375);
    CHECK(alpha_at(frame, 16, 16) == 0.625);
    CHECK(frame.depth[at(frame, 16, 16)] == doctest::Approx((0.5 * 2 + 0.125 * 3) / 0.625).epsilon(1e-15));
  }
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

TEST_CASE("reference: stopped pixels and contributions are counted") {
  // The pixels are so far apart that each Gaussian reaches only its own.
  Conventions k;
  k.stop = 0.25f;
  k.blur = 1e-6f;
  const vec3 point(0), left{-0.5f, 0, 2};
  const Scene scene = scene_of(Gaussian{.scale = point}, Gaussian{.scale = point}, Gaussian{.scale = point},
                               Gaussian{.mean = left, .scale = point}, Gaussian{.mean = {0, 0, -1}});
  const ReferenceFrame frame = draw(scene, k);
  CHECK(frame.contributing_pairs == 2);
  CHECK(frame.visible == 2);
  CHECK(frame.pixels_stopped == 1);
}

TEST_CASE("reference: the background shows through by transmittance") {
  const Scene scene = scene_of(Gaussian{.opacity = 0.75f, .sh0 = red});
  const ReferenceFrame frame = draw(scene, Conventions::gsplat(), vec3(1, 0.5f, 0.25f));
  CHECK(colour_at(frame, 16, 16, 0) == doctest::Approx(0.75 * bright + 0.25).epsilon(1e-15));
  CHECK(colour_at(frame, 16, 16, 1) == 0.125);
  CHECK(colour_at(frame, 0, 0, 2) == 0.25);
}

TEST_CASE("reference: depth is the mean z of what contributes and 0 where nothing does") {
  const ReferenceFrame frame = draw(scene_of(Gaussian{.mean = {0, 0, 5}, .opacity = 0.01f}));
  CHECK(frame.depth[at(frame, 16, 16)] == doctest::Approx(5).epsilon(1e-15));
  CHECK(frame.depth[at(frame, 0, 0)] == 0);
}

TEST_CASE("reference: an occluder hides splats at its depth and behind it") {
  const Scene scene =
      scene_of(Gaussian{.mean = {0, 0, 2}, .sh0 = red}, Gaussian{.mean = {0, 0, 3}, .sh0 = green});
  const ReferenceFrame bare = draw(scene);
  const std::size_t middle = 16 * 33 + 16;
  std::vector<float> occluder(33 * 33, NAN);
  const auto render = [&](float depth) {
    occluder[middle] = depth;
    return render_reference(scene, small_camera(), Conventions::gsplat(), dvec3(0, 0, 1), 1,
                            {occluder.data(), occluder.size()});
  };
  for (const float everything : {-1.0f, 0.0f, 2.0f}) CHECK(alpha_at(render(everything), 16, 16) == 0);
  for (const float second : {std::nextafter(2.0f, 3.0f), 3.0f}) {
    const ReferenceFrame frame = render(second);
    CHECK(alpha_at(frame, 16, 16) == 0.5);
    CHECK(alpha_at(frame, 17, 16) == alpha_at(bare, 17, 16));
    CHECK(colour_at(frame, 16, 16, 1) == 0);
    CHECK(colour_at(frame, 16, 16, 2) == 0.5);
    CHECK(frame.depth[middle] == doctest::Approx(2).epsilon(1e-15));
    CHECK(frame.pixels_stopped == 1);
  }
  CHECK(alpha_at(render(std::nextafter(3.0f, 4.0f)), 16, 16) == 0.75);
  occluder.pop_back();
  CHECK_THROWS_AS(render(1), std::invalid_argument);
}

}  // namespace
}  // namespace swiftgs::test
