// SPDX-License-Identifier: Apache-2.0

// Weights of Gaussians from the device: against the frames of its own rasterizer, and against the serial
// backend's.
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

using Usual = Renderer<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>;

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

TEST_CASE("cuda contribution: what Gaussians get is what covers the pixels of the device's frame") {
  if (without_device()) return;
  const Scene scene = random_scene(3000, 0, 11);
  for (const Conventions& conventions : {Conventions::gsplat(), Conventions::inria()}) {
    const Camera camera = forward_camera(213, 147);
    Usual renderer;
    RenderSettings settings;
    settings.conventions = conventions, settings.outputs.alpha = true, settings.count = true;
    const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
    const double covered = std::accumulate(frame.alpha.begin(), frame.alpha.end(), 0.0);
    // Roundings as on hosts.
    const double bound =
        double(renderer.statistics().raster.contributing_pairs) * (0x1p-24 + 0x1p-25 + 0x1p-31) +
        double(frame.pixels()) * 0x1p-25;
    const double sum = total(sums_of<Cuda>(scene, {camera}, conventions));
    CHECK(sum > 1000);
    CHECK(std::abs(sum - covered) <= bound);
    CHECK(bound < 1e-5 * sum);
  }
}

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

TEST_CASE("cuda contribution: sees the Gaussians that a renderer sees") {
  if (without_device()) return;
  const auto scene = std::make_shared<const Scene>(random_scene(50'000, 0, 12));
  Usual renderer;
  Contributions<Cuda> contributions(scene);
  for (const Camera& camera :
       {forward_camera(80, 60), forward_camera(300, 20, 900), forward_camera(500, 400)}) {
    renderer.render(renderer.backend().upload(scene), camera);
    contributions.add(camera, Conventions::gsplat());
    CHECK(contributions.visible() == renderer.statistics().visible);
    CHECK(contributions.visible() > 1000);
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

TEST_CASE("cuda contribution: what is hidden or culled gets nothing") {
  if (without_device()) return;
  Scene scene;
  append(scene, vec3(0, 0, 4), 1, 1);  // behind the three that follow
  for (int i = 0; i < 3; ++i) append(scene, vec3(0, 0, float(i + 1)), 1000, 1);
  append(scene, vec3(0, 0, -2), 1, 1);             // behind the camera
  append(scene, vec3(90, 0, 1), 0.01f, 1);         // beside the image
  append(scene, vec3(0, 0, 0.5f), 0.1f, 0.0039f);  // fainter than 1/255
  const Sums sums = sums_of<Cuda>(scene, {forward_camera(50, 41)}, Conventions::gsplat());
  CHECK(sums[1] == 50 * 41 * std::uint64_t(weight_parts(0.99f)));
  for (const std::size_t hidden : {0, 3, 4, 5, 6}) {
    CAPTURE(hidden);
    CHECK(sums[hidden] == 0);
  }
}

TEST_CASE("cuda contribution: Gaussians that frames hide get nothing and those behind them all") {
  if (without_device()) return;
  const Scene scene = scene_with_hidden(3000, 16);
  const Camera camera = forward_camera(213, 147);
  Usual renderer;
  RenderSettings settings;
  settings.outputs.alpha = true;
  const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
  const double covered = std::accumulate(frame.alpha.begin(), frame.alpha.end(), 0.0);
  const Sums sums = sums_of<Cuda>(scene, {camera}, settings.conventions);
  for (std::size_t i = 0; i < sums.size(); i += 10) CHECK(sums[i] == 0);
  CHECK(total(sums) > 1000);
  CHECK(total(sums) == doctest::Approx(covered).epsilon(1e-4));
}

TEST_CASE("cuda contribution: scenes of no and of one Gaussian have as many sums") {
  if (without_device()) return;
  const Camera camera = forward_camera(20, 30);
  CHECK(sums_of<Cuda>(Scene(), {camera}, Conventions::gsplat()).empty());
  Scene one;
  append(one, vec3(0, 0, 1), 1000, 1);
  CHECK(sums_of<Cuda>(one, {}, Conventions::gsplat()) == Sums{0});
  CHECK(sums_of<Cuda>(one, {camera, camera}, Conventions::gsplat()) ==
        Sums{1200 * std::uint64_t(weight_parts(0.99f))});
}

TEST_CASE("cuda contribution: the device is the first choice where there is one") {
  if (without_device()) return;
  CHECK(contribution_backend("").backend == "cuda");
  const auto contributions = contribution_backend("cuda").make(std::make_shared<const Scene>(Scene()));
  CHECK(contributions->sums().empty());
}
