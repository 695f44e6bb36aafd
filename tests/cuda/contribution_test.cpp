// SPDX-License-Identifier: Apache-2.0

// Weights of Gaussians from the device against the serial backend's.
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

#include <swiftgs/any_contributions.hpp>
#include <swiftgs/builtin_scene.hpp>

#include "cuda/device.hpp"
#include "policies/contribution_sums.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Compares with the serial backend. Exponentials differ by 2 units in the last place; and where alpha or
/// transmittance is at a threshold, a pixel more or less keeps a splat: with a weight of 1/255 at most at
/// the first, of 0.01 at most at the second, where transmittance was 1e-4 / (1 - 0.99).
void check_against_serial(const Scene& scene, const std::vector<Camera>& cameras,
                          const Conventions& conventions) {
  const Sums sums = sums_of<Cuda>(scene, cameras, conventions);
  const Sums expected = sums_of<Serial>(scene, cameras, conventions);
  REQUIRE(sums.size() == expected.size());
  std::size_t at_threshold = 0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    CAPTURE(i);
    const double weight = weight_of_parts(expected[i]);
    const double difference = std::abs(weight_of_parts(sums[i]) - weight);
    CHECK(difference <= 1e-4 * weight + 0.02);
    at_threshold += difference > 1e-4 * weight + 1e-6;
  }
  CHECK(double(at_threshold) <= 0.02 * double(sums.size()));
  CHECK(total(sums) == doctest::Approx(total(expected)).epsilon(1e-5));
  CHECK(total(sums) > 1000);
}

}  // namespace

TEST_CASE("cuda contribution: sums are the same bits from run to run and on a stream of the caller") {
  if (without_device()) return;
  const Scene scene = make_builtin_scene(20'000);
  const std::vector<Camera> cameras = builtin_cameras(6, 320, 180);
  const Sums sums = sums_of<Cuda>(scene, cameras, Conventions::gsplat());
  const Stream stream;
  for (int run = 0; run < 5; ++run) {
    CHECK(sums_of<Cuda>(scene, cameras, Conventions::gsplat()) == sums);
    CHECK(sums_of(scene, cameras, Conventions::gsplat(), Cuda(stream.get())) == sums);
  }
}

TEST_CASE("cuda contribution: sums are those of the serial backend but for roundings at thresholds") {
  if (without_device()) return;
  for (const Conventions& conventions : {Conventions::gsplat(), Conventions::inria()}) {
    check_against_serial(random_scene(3000, 0, 13), {forward_camera(131, 77), forward_camera(64, 64)},
                         conventions);
    check_against_serial(make_builtin_scene(8000), builtin_cameras(3, 192, 108), conventions);
  }
  Conventions antialiased;
  antialiased.antialiased = true;
  check_against_serial(make_builtin_scene(8000), builtin_cameras(3, 192, 108), antialiased);
}

TEST_CASE("cuda contribution: an image of more than 65536 tiles is summed as on the serial backend") {
  if (without_device()) return;
  check_against_serial(random_scene(200, 0, 14), {forward_camera(4600, 4000)}, Conventions::gsplat());
}

TEST_CASE("cuda contribution: the device is the first choice where there is one") {
  if (without_device()) return;
  CHECK(contribution_backend("").backend == "cuda");
  const auto contributions = contribution_backend("cuda").make(std::make_shared<const Scene>(Scene()));
  CHECK(contributions->sums().empty());
}
