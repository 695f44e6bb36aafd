// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Renderers on real scenes, at half the size of the photographs.

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/tile_lists.hpp"
#include "scenes/captures.hpp"

namespace swiftgs::test {

inline constexpr std::string_view square = "three-sigma-square";

/// Least PSNR against the reference of renderers that share arithmetic. @units{dB}
struct Floors {
  double exact = std::numeric_limits<double>::infinity();  ///< per-pixel and float terms, conservative bounds
  double half = std::numeric_limits<double>::infinity();   ///< half terms, conservative bounds
  double square = std::numeric_limits<double>::infinity();  ///< per-pixel and float terms, 3-sigma square
  double largest =
      0;  ///< error of a colour where the footprint is what the conventions say, without half terms

  double& of(std::string_view renderer) {
    return has(renderer, "half-split") ? half : has(renderer, test::square) ? square : exact;
  }
};

/// What one view is rendered with and judged by.
struct Judge {
  RenderSettings settings;
  Camera camera;
  std::vector<double> reference;
  std::map<std::string, std::vector<float>> first_of;  ///< frame of each set of renderers with the same bits
  Floors floors;

  Judge(const TrainedCapture& capture, std::size_t view, const Conventions& conventions)
      : Judge(capture, scaled(capture.cameras.at(view), 0.5), conventions) {}
  Judge(const TrainedCapture& capture, const Camera& from, const Conventions& conventions) : camera(from) {
    settings.conventions = conventions;
    reference = render_reference(*capture.scene, camera, conventions).colour;
  }

  /// Whatever the run, the sort, and the bounds as long as they are conservative, the bits are the same.
  void judge(const RendererEntry& entry, const TrainedCapture& capture) {
    CAPTURE(entry.name);
    const auto renderer = entry.make();
    renderer->set_scene(capture.scene);
    Frame frame, again;
    renderer->render(camera, settings, frame);
    renderer->render(camera, settings, again);
    CHECK(same_bits(frame.colour, again.colour));

    const std::string_view name = entry.name;
    const std::size_t raster = name.find('/', name.find('/') + 1) + 1, bounds = name.rfind('/');
    std::string group(name.substr(raster, bounds - raster));
    if (has(name, square)) group.append("/").append(square);
    const auto [first, is_first] = first_of.try_emplace(group, frame.colour);
    CHECK(same_bits(first->second, frame.colour));
    if (!is_first) return;

    double& floor = floors.of(name);
    if (has(group, "half-split") && has(name, square)) return;  // two losses at once: no figure of its own
    floor = std::min(floor, psnr(frame.colour, reference));
    const bool by_square = settings.conventions.footprint == Conventions::Footprint::three_sigma_square;
    if (!has(group, "half-split") && has(name, square) == by_square)
      floors.largest = std::max(floors.largest, max_abs_difference(frame.colour, reference));
  }
};

/// The view of a pinhole through OpenCV's lens, a fisheye, and all around.
inline std::vector<Camera> through_lenses(const Camera& pinhole) {
  std::vector<Camera> cameras(3, pinhole);
  cameras[0].lens.distortion = {{-0.1, 0.02, 0, 0}, {}, {0.001, -0.002}, {}};
  cameras[1].lens = {LensModel::fisheye, {{0.02, -0.004, 0.001, 0}, {}, {}, {}}};
  Camera& panorama = cameras[2];
  panorama.lens.model = LensModel::equirectangular;
  panorama.height = panorama.width / 2;
  panorama.fx = panorama.fy = panorama.width / (2 * std::numbers::pi);
  panorama.cx = 0.5 * panorama.width, panorama.cy = 0.5 * panorama.height;
  return cameras;
}

/// Checks the exact rasterizers of a backend through lenses.
inline void check_lenses(const TrainedCapture& capture, std::string_view backend, double least_db) {
  for (const Camera& camera : through_lenses(scaled(capture.cameras.at(0), 0.5))) {
    CAPTURE(name_of(camera.lens.model));
    Judge judge(capture, camera, Conventions::gsplat());
    for (const RendererEntry& entry : renderers())
      if (has(entry.name, std::string(backend) + "/early/") && has(entry.name, "/ellipse") &&
          !has(entry.name, "half-split"))
        judge.judge(entry, capture);
    CHECK(judge.first_of.size() == 5);
    CHECK(judge.floors.exact >= least_db);
    MESSAGE(name_of(camera.lens.model), ": ", judge.floors.exact, " dB, largest error ",
            judge.floors.largest);
  }
}

}  // namespace swiftgs::test
