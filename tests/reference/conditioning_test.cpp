// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/stress.hpp>

#include "reference/gaussians.hpp"
#include "rendering.hpp"
#include "varied_splats.hpp"

namespace swiftgs::test {
namespace {

using reference::VariedSplat;

/// Splats in the order of their depths, of which each may be any float of a range.
struct Range {
  float least, largest;
};
std::vector<bool> ambiguous_of(const std::vector<Range>& ranges) {
  std::vector<VariedSplat> splats;
  for (const Range& range : ranges) {
    VariedSplat splat{};
    splat.splat.index = splats.size();
    splat.least_order = range.least, splat.largest_order = range.largest;
    splats.push_back(splat);
  }
  reference::mark_ambiguous_orders(splats);
  std::vector<bool> ambiguous;
  for (const VariedSplat& splat : splats) ambiguous.push_back(splat.order_is_ambiguous);
  return ambiguous;
}

TEST_CASE("conditioning: the order of depths that may be the same float is ambiguous") {
  CHECK(ambiguous_of({{1, 2}, {2, 3}, {4, 5}}) == std::vector{true, true, false});
  CHECK(ambiguous_of({{1, 1}, {1, 1}, {2, 2}}) == std::vector{false, false, false});
  CHECK(ambiguous_of({{1, 1}, {1, 2}}) == std::vector{true, true});
}

TEST_CASE("conditioning: a depth of wide range is ambiguous against one that is not its neighbour") {
  // The least ends do not ascend with the depths.
  CHECK(ambiguous_of({{1, 1}, {2, 2}, {0, 5}}) == std::vector{true, true, true});
  CHECK(ambiguous_of({{0, 9}, {3, 3}, {4, 4}, {1, 8}}) == std::vector{true, true, true, true});
}

TEST_CASE(
    "conditioning: a Gaussian far beside the camera is ambiguous in order against all that its depth may "
    "be") {
  // Depths of a turned camera: the third Gaussian's is a difference of terms of 5e9, which a unit in the last
  // place of double moves by some floats.
  Camera camera = small_camera(32, 32, 32);
  camera.rotation = dmat3(0.8, 0, 0.6, 0, 1, 0, -0.6, 0, 0.8);
  camera.translation = dvec3(0, 0, 1);
  const auto at_depth = [](float off) {
    return Gaussian{.mean = {0.6f * off, 0, 0.8f * off}, .scale = vec3(0.1f), .opacity = 0.5f};
  };
  Gaussian far = at_depth(0);
  far.mean = {0x1p33f * 4, 0, -0x1p33f * 3}, far.scale = vec3(1e12f);
  const Scene scene = scene_of(at_depth(-0x1p-21f), at_depth(-0x1p-22f), far);
  const ReferenceScene alone{scene};
  const std::vector<VariedSplat> splats =
      reference::project_all_varied(reference::views_of({&alone, 1}, camera, Conventions::gsplat()), {});
  REQUIRE(splats.size() == 3);
  for (const VariedSplat& splat : splats) CHECK(splat.order_is_ambiguous);
}

TEST_CASE("conditioning: trials of the scene alone turn no line as the rounding of its factor does") {
  // No float of an unrotated line turns it; the last place of its factor does, before a rolled camera.
  Camera camera = small_camera(256, 192, 256);
  camera.rotation = dmat3(0.8, 0.6, 0, -0.6, 0.8, 0, 0, 0, 1);
  const Scene scene = scene_of(Gaussian{.scale = {1, 0, 0}});
  const auto largest_move = [&](bool scene_only) {
    const StressTrials trials{.scene_only = scene_only};
    const ConditionedFrame frame =
        render_conditioned(scene, camera, Conventions::gsplat(), dvec3(0), trials, 1);
    return *std::max_element(frame.alpha_move.begin(), frame.alpha_move.end());
  };
  CHECK(largest_move(true) > 0);
  CHECK(largest_move(true) < 0.25 * largest_move(false));
}

TEST_CASE("conditioning: frames of linear light are the reference's") {
  Scene scene = scene_of(Gaussian{.mean = {0.01f, 0, 4}, .opacity = 0.4f},
                         Gaussian{.mean = {0.02f, 0.01f, 5}, .scale = vec3(0.5f), .opacity = 0.8f});
  scene.model.colours = ColourSpace::linear;
  const Camera camera = small_camera(32, 32, 32);
  const dvec3 background(0.2, 0.5, 0.9);
  const ConditionedFrame found = render_conditioned(scene, camera, Conventions::gsplat(), background);
  const ReferenceFrame expected = render_reference(scene, camera, Conventions::gsplat(), background);
  CHECK(max_abs_difference(found.frame.colour, expected.colour) < 1e-15);
  // Near black a little light is much of an encoded value.
  CHECK(found.colour_change(1e-4) == doctest::Approx(12.92e-4 * found.colour_span));
}

TEST_CASE("conditioning: an edge at three standard deviations is ambiguous and the inside is not") {
  // Variances of 9 without blur, centred on a pixel: pixel 9 to the right is on the edge.
  const Scene scene = scene_of(Gaussian{.mean = {0, 0, 4}, .scale = vec3(3), .opacity = 0.5f});
  Camera camera = small_camera(33, 33, 4);
  camera.cx = camera.cy = 16.5;
  Conventions conventions = Conventions::khronos();
  conventions.blur = 0;
  const ConditionedFrame frame = render_conditioned(scene, camera, conventions);
  const std::size_t centre = 16 * 33 + 16;
  const std::vector<double>& ambiguous = frame.ambiguous[0];
  CHECK(ambiguous[centre + 9] == doctest::Approx(0.5 * std::exp(-4.5)));
  CHECK(ambiguous[centre + 8] == 0);
  CHECK(ambiguous[centre + 10] == 0);
  CHECK(frame.frame.alpha[centre + 8] > 0);
  CHECK(frame.frame.alpha[centre + 10] == 0);
}

/// What the judge says of two pixels, the second of which is off by `error`. Of it `ambiguous` may change
/// hands.
StressVerdict judge_planted(double error, double ambiguous) {
  ConditionedFrame reference;
  reference.frame.width = 2, reference.frame.height = 1;
  reference.frame.colour.assign(6, 0.5), reference.frame.alpha.assign(2, 0.75);
  reference.frame.depth.assign(2, 1);
  reference.colour_move.assign(6, 1e-7), reference.alpha_move.assign(2, 1e-7);
  reference.depth_move.assign(2, 1e-7);
  for (std::vector<double>& weights : reference.ambiguous) weights = {0, ambiguous};
  reference.colour_span = 2, reference.peak = 1, reference.depth_span = 1;
  Frame frame;
  frame.width = 2, frame.height = 1;
  frame.colour.assign(6, 0.5f), frame.alpha.assign(2, 0.75f);
  frame.colour[4] = float(0.5 + error);
  return judge(reference, frame, ExponentRepresentation::factor);
}

TEST_CASE("judge: a flip within what may change hands is taken off the error and counted") {
  // A weight of 1/64 times a span of 2.
  for (const double error : {0.9 / 32, -0.9 / 32}) {
    const StressVerdict within = judge_planted(error, 1.0 / 64);
    CHECK(within.strict_normalised_error == 0);
    CHECK(within.normalised_error == 0);
    CHECK(within.flips == 1);
    CHECK(within.judged == 1);
    CHECK(within.max_abs == doctest::Approx(0.9 / 32));
  }
}

TEST_CASE("judge: a flip beyond what may change hands is an error and no flip") {
  for (const double error : {1.1 / 32, -1.1 / 32}) {
    const StressVerdict beyond = judge_planted(error, 1.0 / 64);
    // What is beyond, over the move and the rounding of the value.
    CHECK(beyond.normalised_error == doctest::Approx(0.1 / 32 / (1e-7 + 0x1p-24)).epsilon(1e-3));
    CHECK(beyond.strict_normalised_error == beyond.normalised_error);
    CHECK(beyond.worst_pixel == 1);
    CHECK(beyond.flips == 0);
  }
  CHECK(judge_planted(0.9 / 32, 0).normalised_error > 1e5);
}

TEST_CASE("judge: pixels whose whole weight may change hands are not counted as judged") {
  const StressVerdict open = judge_planted(0.3, 1);
  CHECK(open.normalised_error == 0);
  CHECK(open.judged == 0.5);
  CHECK(open.ambiguity == 1);
}

}  // namespace
}  // namespace swiftgs::test
