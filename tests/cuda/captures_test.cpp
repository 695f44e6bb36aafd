// SPDX-License-Identifier: Apache-2.0

// Every renderer of the device on real scenes, at half the size of the photographs.
#include <cstddef>
#include <string>

#include "cuda/device.hpp"
#include "scenes/judge.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

void check_capture(const std::string& name) {
  if (without_device()) return;
  const std::filesystem::path folder = capture_or_skip(name);
  if (folder.empty()) return;
  const TrainedCapture capture = read_capture(folder);
  for (const std::size_t view : {0, 8}) {
    CAPTURE(view);
    Judge gsplat(capture, view, Conventions::gsplat()), inria(capture, view, Conventions::inria());
    std::size_t judged = 0;
    for (const RendererEntry& entry : renderers())
      if (has(entry.name, "cuda/")) gsplat.judge(entry, capture), inria.judge(entry, capture), ++judged;
    CHECK(judged == AllSorts::size * AllRasters::size * AllBounds::size);
    for (const Judge* judge : {&gsplat, &inria}) {
      CHECK(judge->first_of.size() == 2 * AllRasters::size);
      CHECK(judge->floors.largest <= 1.0 / 255);
    }
    CHECK(gsplat.floors.exact >= 90);
    CHECK(gsplat.floors.half >= 45);
    CHECK(inria.floors.square >= 90);
    MESSAGE(name, ", view ", view, ": gsplat ", gsplat.floors.exact, " dB, half-split ", gsplat.floors.half,
            " dB; inria ", inria.floors.square, " dB");
  }
}

}  // namespace

TEST_CASE("cuda captures: every renderer draws garden as the reference does") { check_capture("garden"); }
TEST_CASE("cuda captures: every renderer draws herz as the reference does") { check_capture("herz"); }
TEST_CASE("cuda captures: every renderer draws fox as the reference does") { check_capture("fox"); }

TEST_CASE("cuda captures: renderers draw garden through lenses as the reference does") {
  if (without_device()) return;
  const std::filesystem::path folder = capture_or_skip("garden");
  // As for pinholes: a pixel whose alpha stands at the threshold costs up to ten decibels.
  if (!folder.empty()) check_lenses(read_capture(folder), "cuda", 90);
}
