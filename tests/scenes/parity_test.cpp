// SPDX-License-Identifier: Apache-2.0

// Every cpu renderer on real scenes, at half the size of the photographs.
#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/swiftgs.hpp>

#include "scenes/captures.hpp"

using namespace swiftgs;
using swiftgs::test::has;

namespace {

constexpr std::string_view square = "three-sigma-square";

/// Least PSNR against the reference of renderers that share arithmetic. @units{dB}
struct Floors {
  double exact = std::numeric_limits<double>::infinity();  ///< per-pixel and float terms, conservative bounds
  double half = std::numeric_limits<double>::infinity();   ///< half terms, conservative bounds
  double square = std::numeric_limits<double>::infinity();  ///< per-pixel and float terms, 3-sigma square
  double largest =
      0;  ///< error of a colour where the footprint is what the conventions say, without half terms

  double& of(std::string_view renderer) {
    return has(renderer, "half-split") ? half : has(renderer, ::square) ? square : exact;
  }
};

/// What one view is rendered with and judged by.
struct Judge {
  RenderSettings settings;
  Camera camera;
  std::vector<double> reference;
  std::map<std::string, std::vector<float>> first_of;  ///< frame of each set of renderers with the same bits
  Floors floors;

  Judge(const test::TrainedCapture& capture, std::size_t view, const Conventions& conventions)
      : camera(scaled(capture.cameras.at(view), 0.5)) {
    settings.conventions = conventions;
    reference = render_reference(*capture.scene, camera, conventions).colour;
  }

  /// Whatever the run, the sort, and the bounds as long as they are conservative, the bits are the same.
  void judge(const RendererEntry& entry, const test::TrainedCapture& capture) {
    CAPTURE(entry.name);
    const auto renderer = entry.make();
    renderer->set_scene(capture.scene);
    Frame frame, again;
    renderer->render(camera, settings, frame);
    renderer->render(camera, settings, again);
    CHECK((frame.colour == again.colour));

    const std::string_view name = entry.name;
    const std::size_t raster = name.find('/', name.find('/') + 1) + 1, bounds = name.rfind('/');
    std::string group(name.substr(raster, bounds - raster));
    if (has(name, square)) group.append("/").append(square);
    const auto [first, is_first] = first_of.try_emplace(group, frame.colour);
    CHECK((first->second == frame.colour));
    if (!is_first) return;

    double& floor = floors.of(name);
    if (has(group, "half-split") && has(name, square)) return;  // two losses at once: no figure of its own
    floor = std::min(floor, psnr(frame.colour, reference));
    const bool by_square = settings.conventions.footprint == Conventions::Footprint::three_sigma_square;
    if (!has(group, "half-split") && has(name, square) == by_square)
      floors.largest = std::max(floors.largest, max_abs_difference(frame.colour, reference));
  }
};

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
    if (has(entry.name, "cpu/") && has(entry.name, square) && !has(entry.name, "half-split"))
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
