// SPDX-License-Identifier: Apache-2.0

// A renderer of one's own is judged by this header alone.
#include <doctest/doctest.h>

#include <swiftgs/stress.hpp>

namespace {

using namespace swiftgs;

/// A needle across the image before a flat Gaussian.
Scene needle_before_a_wall() {
  Scene scene;
  scene.means = {{0.1f, 0, 2}, {0, 0, 3}}, scene.scales = {{3, 1e-4f, 1e-4f}, {1, 1, 0}};
  scene.rotations.resize(2), scene.opacities = {0.8f, 0.6f}, scene.sh0 = {{1, 0, -1}, {-1, 1, 0}};
  return scene;
}

/// The best that a renderer in float can do: each value is rounded once.
Frame rounded(const ReferenceFrame& exact) {
  Frame frame;
  frame.width = exact.width, frame.height = exact.height;
  frame.colour.assign(exact.colour.begin(), exact.colour.end());
  frame.alpha.assign(exact.alpha.begin(), exact.alpha.end());
  frame.depth.assign(exact.depth.begin(), exact.depth.end());
  return frame;
}

TEST_CASE("judge: users judge frames of their own and find what is off and where") {
  Camera camera;
  camera.width = 32, camera.height = 24, camera.fx = camera.fy = 30, camera.cx = 16, camera.cy = 12;
  const ConditionedFrame reference = render_conditioned(needle_before_a_wall(), camera, Conventions());
  Frame frame = rounded(reference.frame);
  const StressVerdict good = judge(reference, frame, ExponentRepresentation::factor);
  CHECK(good.strict_normalised_error <= 1);
  CHECK(good.normalised_depth_error <= 1);
  CHECK(good.judged == 1);
  CHECK(good.psnr_db > 120);

  const std::size_t middle = 12 * 32 + 16;
  frame.colour[3 * middle + 1] += 1e-3f;
  const StressVerdict bad = judge(reference, frame, ExponentRepresentation::factor);
  CHECK(bad.normalised_error > 100);
  CHECK(bad.worst_pixel == middle);
  CHECK(bad.max_abs == doctest::Approx(1e-3).epsilon(1e-3));
}

}  // namespace
