// SPDX-License-Identifier: Apache-2.0

// Renderers of `Cpu` on real scenes, at half the size of the photographs: each rasterizer with two bounds,
// and one of them with all sorts and bounds. tests/parity has every combination.
#include <string>

#include "scenes/judge.hpp"

using namespace swiftgs;
using swiftgs::test::has;
using swiftgs::test::Judge;

namespace {

/// Compares renderers with the reference. Exact ones stay above 95 dB: the rest is pixels where float and
/// double decide a threshold differently.
void check_gsplat(const std::string& name, std::size_t view) {
  const std::filesystem::path folder = test::capture_or_skip(name);
  if (folder.empty()) return;
  CAPTURE(name);
  const test::TrainedCapture capture = test::read_capture(folder);
  Judge judge(capture, view, Conventions::gsplat());
  std::size_t judged = 0;
  for (const RendererEntry& entry : renderers()) {
    const bool two_bounds = has(entry.name, "/ellipse") || has(entry.name, test::square);
    if ((has(entry.name, "cpu/early/") && two_bounds) ||
        (has(entry.name, "cpu/") && has(entry.name, "/axis-shared-threshold-float-cholesky/")))
      judge.judge(entry, capture), ++judged;
  }
  CHECK(judged == 2 * (AllRasters::size - 1) + AllSorts::size * AllBounds::size);
  CHECK(judge.first_of.size() == 2 * AllRasters::size);
  CHECK(judge.floors.exact >= 95);
  CHECK(judge.floors.half >= 45);
  CHECK(judge.floors.largest <= 1.0 / 255);
  MESSAGE(name, ", ", judge.camera.name, ": exact ", judge.floors.exact, " dB, half-split ",
          judge.floors.half, " dB, 3-sigma square ", judge.floors.square, " dB; largest error ",
          judge.floors.largest);
}

/// With INRIA's conventions the 3-sigma square is what the image is defined by, not a loss.
void check_inria(const std::string& name, std::size_t view) {
  const std::filesystem::path folder = test::capture_or_skip(name);
  if (folder.empty()) return;
  CAPTURE(name);
  const test::TrainedCapture capture = test::read_capture(folder);
  Judge inria(capture, view, Conventions::inria());
  std::size_t judged = 0;
  for (const RendererEntry& entry : renderers())
    if (has(entry.name, "cpu/early/") && has(entry.name, test::square) && !has(entry.name, "half-split"))
      inria.judge(entry, capture), ++judged;
  CHECK(judged == 5);
  CHECK(inria.floors.square >= 95);
  CHECK(inria.floors.largest <= 1.0 / 255);
  MESSAGE(name, ", ", inria.camera.name, ": with the inria preset ", inria.floors.square,
          " dB, largest error ", inria.floors.largest);
}

}  // namespace

TEST_CASE("scenes: cpu renderers draw garden as the reference does") { check_gsplat("garden", 0); }
TEST_CASE("scenes: cpu renderers draw herz as the reference does") { check_gsplat("herz", 0); }
TEST_CASE("scenes: cpu renderers draw fox as the reference does") { check_gsplat("fox", 0); }

TEST_CASE("scenes: cpu renderers draw garden with the inria preset as the reference does") {
  check_inria("garden", 8);
}
TEST_CASE("scenes: cpu renderers draw herz with the inria preset as the reference does") {
  check_inria("herz", 8);
}
TEST_CASE("scenes: cpu renderers draw fox with the inria preset as the reference does") {
  check_inria("fox", 8);
}

TEST_CASE("scenes: cpu renderers draw garden through lenses as the reference does") {
  const std::filesystem::path folder = test::capture_or_skip("garden");
  if (!folder.empty()) test::check_lenses(test::read_capture(folder), "cpu", 100);
}
