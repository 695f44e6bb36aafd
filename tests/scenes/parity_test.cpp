// SPDX-License-Identifier: Apache-2.0

// Every cpu renderer on real scenes, at half the size of the photographs.
#include <string>

#include "scenes/judge.hpp"

using namespace swiftgs;
using swiftgs::test::has;
using swiftgs::test::Judge;

namespace {

/// All that must hold between all cpu renderers and the reference. The exact ones stay above 95 dB here:
/// what is left are the pixels where float and double decide a threshold differently.
void check_all(const std::string& name, std::size_t view) {
  const std::filesystem::path folder = test::capture_or_skip(name);
  if (folder.empty()) return;
  CAPTURE(name);
  const test::TrainedCapture capture = test::read_capture(folder);
  Judge judge(capture, view, Conventions::gsplat());
  std::size_t judged = 0;
  for (const RendererEntry& entry : renderers())
    if (has(entry.name, "cpu/")) judge.judge(entry, capture), ++judged;
  CHECK(judged == AllSorts::size * AllRasters::size * AllBounds::size);
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
    if (has(entry.name, "cpu/") && has(entry.name, test::square) && !has(entry.name, "half-split"))
      inria.judge(entry, capture), ++judged;
  CHECK(judged == 3 * 5);
  CHECK(inria.floors.square >= 95);
  CHECK(inria.floors.largest <= 1.0 / 255);
  const Judge gsplat(capture, view, Conventions::gsplat());
  MESSAGE(name, ", ", inria.camera.name, ": with the inria preset ", inria.floors.square,
          " dB, largest error ", inria.floors.largest, "; between the presets ",
          psnr(gsplat.reference, inria.reference), " dB");
}

}  // namespace

TEST_CASE("scenes: every cpu renderer draws garden as the reference does") { check_all("garden", 0); }
TEST_CASE("scenes: every cpu renderer draws herz as the reference does") { check_all("herz", 0); }
TEST_CASE("scenes: every cpu renderer draws fox as the reference does") { check_all("fox", 0); }

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
