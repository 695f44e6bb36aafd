// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Renderers on real scenes, at half the size of the photographs.

#include <algorithm>
#include <limits>
#include <map>
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
      : camera(scaled(capture.cameras.at(view), 0.5)) {
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

}  // namespace swiftgs::test
