// SPDX-License-Identifier: Apache-2.0

// Every renderer of the device on real scenes, at half the size of the photographs.
#include "scenes/captures.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <string>

#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "cuda/drawings.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Least PSNR against the reference. @units{dB}
struct Floors {
  double exact = std::numeric_limits<double>::infinity(), half = exact;
  double largest = 0;  ///< error of a colour, without half terms
};

/// Whatever the run, the sort, and the bounds as long as they are conservative, the bits are the same. Where
/// `square` says so, the 3-sigma square is what the image is defined by.
Floors judge(const TrainedCapture& capture, std::size_t view, const Conventions& conventions, bool square) {
  const Camera camera = scaled(capture.cameras.at(view), 0.5);
  const std::vector<double> reference = render_reference(*capture.scene, camera, conventions).colour;
  RenderSettings settings;
  settings.conventions = conventions;
  Floors floors;
  std::map<std::string, std::vector<float>> first_of;
  std::size_t judged = 0;
  for (const RendererEntry& entry : renderers()) {
    if (!has(entry.name, "cuda/")) continue;
    CAPTURE(entry.name);
    const auto renderer = entry.make();
    renderer->set_scene(capture.scene);
    Frame frame, again;
    renderer->render(camera, settings, frame);
    renderer->render(camera, settings, again);
    CHECK(same_bits(frame.colour, again.colour));
    ++judged;
    const std::string name(entry.name);
    const std::size_t raster = name.find('/', name.find('/') + 1), bounds = name.rfind('/');
    const bool cut = has(name, "three-sigma-square");
    const auto [first, is_first] =
        first_of.try_emplace(name.substr(raster, bounds - raster) + (cut ? "/square" : ""), frame.colour);
    CHECK(same_bits(first->second, frame.colour));
    if (!is_first || cut != square) continue;
    const bool half = has(name, "half-split");
    double& floor = half ? floors.half : floors.exact;
    floor = std::min(floor, psnr(frame.colour, reference));
    if (!half) floors.largest = std::max(floors.largest, max_abs_difference(frame.colour, reference));
  }
  CHECK(judged == AllSorts::size * AllRasters::size * AllBounds::size);
  CHECK(first_of.size() == 2 * AllRasters::size);
  return floors;
}

void check_capture(const std::string& name) {
  if (without_device()) return;
  const std::filesystem::path folder = capture_or_skip(name);
  if (folder.empty()) return;
  const TrainedCapture capture = read_capture(folder);
  for (const std::size_t view : {0, 8}) {
    CAPTURE(view);
    const Floors gsplat = judge(capture, view, Conventions::gsplat(), false);
    const Floors inria = judge(capture, view, Conventions::inria(), true);
    CHECK(gsplat.exact >= 90);
    CHECK(gsplat.largest <= 1.0 / 255);
    CHECK(gsplat.half >= 45);
    CHECK(inria.exact >= 90);
    CHECK(inria.largest <= 1.0 / 255);
    MESSAGE(name, ", view ", view, ": gsplat ", gsplat.exact, " dB, half-split ", gsplat.half, " dB; inria ",
            inria.exact, " dB, half-split ", inria.half, " dB");
  }
}

}  // namespace

TEST_CASE("cuda captures: every renderer draws garden as the reference does") { check_capture("garden"); }
TEST_CASE("cuda captures: every renderer draws herz as the reference does") { check_capture("herz"); }
TEST_CASE("cuda captures: every renderer draws fox as the reference does") { check_capture("fox"); }
