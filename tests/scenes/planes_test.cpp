// SPDX-License-Identifier: Apache-2.0

// Planes of real scenes beside the reference, at a quarter of the size of the photographs.
#include "policies/planes.hpp"

#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "policies/rasterizers.hpp"
#include "scenes/judge.hpp"

using namespace swiftgs;

namespace {

/// In decibels, for a peak of 1; of depths in parts of them.
double error_of(const std::vector<float>& found, const std::vector<double>& expected,
                bool of_depths = false) {
  double sum = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double unit = of_depths && expected[i] > 0 ? expected[i] : 1;
    sum += (double(found[i]) - expected[i]) / unit * (double(found[i]) - expected[i]) / unit;
  }
  return -10 * std::log10(sum / double(found.size()));
}

template <class Found, class Expected>
double part_unlike(const std::vector<Found>& found, const std::vector<Expected>& expected) {
  std::size_t unlike = 0;
  for (std::size_t i = 0; i < found.size(); ++i) unlike += found[i] != Found(expected[i]);
  return double(unlike) / double(found.size());
}

void check_planes(const std::string& name, const std::string& backend) {
  const std::filesystem::path folder = test::capture_or_skip(name);
  if (folder.empty()) return;
  const RendererEntry& entry = find_renderer(backend);
  if (!entry.usable) return test::skip(backend + " does not run here");
  CAPTURE(name);
  const test::TrainedCapture capture = test::read_capture(folder);
  Scene scene = *capture.scene;
  scene.feature_channels = 3;
  for (const vec3& sh0 : scene.sh0) scene.features.insert(scene.features.end(), {sh0.x, sh0.y, sh0.z});
  const Camera camera = scaled(capture.cameras.at(0), 0.25);
  const ReferencePlanes expected = render_reference_planes(scene, camera, {});
  const RenderSettings settings = test::settings_of_all(3);
  Frame frame;
  const auto renderer = entry.make();
  renderer->set_scene(std::make_shared<const Scene>(std::move(scene)));
  renderer->render(camera, settings, frame);

  const double depth = error_of(frame.depth, expected.depth, true),
               squared = error_of(frame.squared_depth, expected.squared_depth, true);
  const double normal = error_of(frame.normal, expected.normal),
               features = error_of(frame.features, expected.features);
  const double id = part_unlike(frame.id, expected.id),
               median = part_unlike(frame.median_id, expected.median_id);
  const double first = part_unlike(frame.first_depth, expected.first_depth);
  MESSAGE(name, " by ", backend, ": depth ", depth, " dB of itself, squared ", squared, ", normal ", normal,
          " dB, features ", features, "; unlike are ", id, " of ids, ", median, " of medians, ", first,
          " of first depths");
  CHECK(depth >= 100);
  CHECK(squared >= 95);
  CHECK(normal >= 93);
  CHECK(features >= 90);
  CHECK(id <= 1e-4);
  CHECK(median <= 1e-4);
  CHECK(first <= 1e-4);
}

}  // namespace

TEST_CASE("scenes: cpu draws planes of garden as the reference does") { check_planes("garden", "cpu"); }
TEST_CASE("scenes: cpu draws planes of herz as the reference does") { check_planes("herz", "cpu"); }
TEST_CASE("scenes: cpu draws planes of fox as the reference does") { check_planes("fox", "cpu"); }
