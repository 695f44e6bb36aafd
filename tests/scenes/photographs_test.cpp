// SPDX-License-Identifier: Apache-2.0

// Frames against the photographs that training never saw: every eighth by image name.
#include <algorithm>
#include <map>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/io/image.hpp>
#include <swiftgs/metrics.hpp>

#include "scenes/captures.hpp"

using namespace swiftgs;
using swiftgs::test::has;

namespace {

/// Photographs by the name of their camera, without extension.
std::map<std::string, std::filesystem::path> photographs_of(const test::TrainedCapture& capture) {
  std::map<std::string, std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(capture.photos))
    files[entry.path().stem().string()] = entry.path();
  return files;
}

/// PSNR of a frame against the photograph, clamped to what a photograph can hold. @units{dB}
double psnr_against(const Image& photograph, const Camera& camera, AnyRenderer& renderer) {
  Frame frame;
  renderer.render(camera, {}, frame);
  for (float& value : frame.colour) value = std::clamp(value, 0.0f, 1.0f);
  return psnr(frame.colour, photograph.pixels);
}

/// The mean over all held-out views is `expected`, and on the first view every policy that is no
/// approximation comes to the same.
void check_photographs(const std::string& name, std::size_t views, double expected) {
  const std::filesystem::path folder = test::capture_or_skip(name, "photos");
  if (folder.empty()) return;
  CAPTURE(name);
  const test::TrainedCapture capture = test::read_capture(folder);
  const auto files = photographs_of(capture);
  const std::string usual = "cpu/early/axis-shared-threshold-float-cholesky/ellipse";
  const auto renderer = make_renderer(usual);
  renderer->set_scene(capture.scene);
  double sum = 0, first = 0;
  std::size_t matched = 0;
  for (std::size_t i = 0; i < capture.cameras.size(); i += 8) {
    const Camera& camera = capture.cameras[i];
    const Image photograph = read_image(files.at(std::filesystem::path(camera.name).stem().string()));
    CHECK(photograph.width == camera.width);
    CHECK(photograph.height == camera.height);
    const double psnr_db = psnr_against(photograph, camera, *renderer);
    sum += psnr_db, ++matched;
    if (i > 0) continue;
    first = psnr_db;
    for (const RendererEntry& entry : renderers()) {
      if (!has(entry.name, "cpu/early/") || has(entry.name, "half-split") ||
          has(entry.name, "three-sigma-square"))
        continue;
      CAPTURE(entry.name);
      const auto other = entry.make();
      other->set_scene(capture.scene);
      CHECK(std::abs(psnr_against(photograph, camera, *other) - first) <= 0.01);
    }
  }
  CHECK(matched == views);
  CHECK(matched == files.size());
  CHECK(std::abs(sum / double(matched) - expected) <= 0.01);
  MESSAGE(name, ": ", sum / double(matched), " dB against ", matched, " photographs");
}

}  // namespace

TEST_CASE("scenes: garden is as close to its photographs as it was trained to be") {
  check_photographs("garden", 12, 24.83);
}
TEST_CASE("scenes: herz is as close to its photographs as it was trained to be") {
  check_photographs("herz", 4, 22.00);
}
TEST_CASE("scenes: fox is as close to its photographs as it was trained to be") {
  check_photographs("fox", 7, 29.18);
}
