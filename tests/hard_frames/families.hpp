// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "hard_frames/cameras.hpp"
#include "hard_frames/lenses.hpp"
#include "hard_frames/placed.hpp"
#include "hard_frames/shapes.hpp"
#include "hard_frames/thresholds.hpp"
#include "hard_frames/values.hpp"

namespace swiftgs {

/// Every family of hard frames, each with its severities in ascending order.
inline const std::vector<StressFamily>& stress_families() {
  using namespace stress;
  const double infinity = std::numeric_limits<double>::infinity();
  static const std::vector<StressFamily> families{
      {"needles", "length over width", {1e2, 1e4, 1e6, 1e8, 1e10}, needles},
      {"bare-needles", "length over width", {10, 1e2, 1e3, 1e4, 1e6, 1e8, 1e10, 1e14}, bare_needles},
      {"pancakes", "side over thickness", {1e2, 1e4, 1e6, 1e8, 1e10}, pancakes},
      {"ridges", "standard deviation along (px)", {1e2, 1e3, 1e4, 1e5, 1e6}, ridges},
      {"grazing", "standard deviation over depth", {0.1, 1, 10, 100, 1000}, grazing},
      {"little-blur", "1 / blur (1/px^2)", {3, 1e2, 1e4, 1e6, infinity}, little_blur},
      {"scales", "largest scale", {1e1, 1e3, 1e6, 1e10, 1e15}, scales},
      {"distant-means", "distance of means (px)", {1e2, 1e3, 1e4, 1e5, 1e6, 1e7}, distant_means},
      {"wide-angles", "1 / focal length (1/px)", {0.1, 1, 1e1, 1e2, 1e3, 1e6}, wide_angles},
      {"long-lenses", "focal length (px)", {1e2, 1e4, 1e6, 1e9, 1e12}, long_lenses},
      {"principal-points",
       "distance of the principal point (px)",
       {1e2, 1e3, 1e5, 1e7, 9e8},
       principal_points},
      {"uneven-focals", "ratio of focal lengths", {2, 10, 100}, uneven_focals},
      {"distorted-lenses", "corner over fold", {0.1, 0.5, 0.9, 0.999}, distorted_lenses},
      {"fisheyes", "field of view (degrees)", {30, 120, 180, 240, 340}, fisheyes},
      {"orthographic", "depth over width", {1, 1e2, 1e4, 1e6}, orthographic},
      {"panoramas", "1 / angle to a pole (1/radian)", {1, 10, 100, 1000}, panoramas},
      {"world-offsets", "distance from the origin", {1e2, 1e4, 1e6, 1e8}, world_offsets},
      {"distant-cameras", "distance of the camera", {1e1, 1e3, 1e5, 1e7}, distant_cameras},
      {"skewed-rotations", "distance from a rotation", {0, 1e-5, 1e-4, 4e-4}, skewed_rotations},
      {"placed-scenes", "distance from the origin", {1, 1e3, 1e6, 1e8}, placed_scenes},
      {"far-millimetres", "distance from the origin", {1, 1e3, 1e5, 1e7}, far_millimetres},
      {"clipped-scenes", "last places off the clip", {16, 1e3, 1e5, 1e6}, clipped_scenes},
      {"on-planes", "last places off the planes", {0, 1, 2, 4}, on_planes},
      {"on-alphas", "last places off alpha", {0, 1, 2, 4}, on_alphas},
      {"on-stops", "last places off the stop", {0, 1, 2, 4}, on_stops},
      {"on-ties", "last places off equal depths", {0, 1, 2, 4}, on_ties},
      {"equal-stacks", "layers", {10, 100, 1000, 10000}, equal_stacks},
      {"deep-stacks", "layers", {10, 100, 1000, 4000}, deep_stacks},
      {"harmonics", "magnitude of coefficients", {1, 1e3, 1e10, 1e20, 1e30, 1e38}, harmonics},
      {"backgrounds", "magnitude of the background", {1, 1e3, 1e10, 1e20, 3e38}, backgrounds},
      {"far-depths", "depth", {1, 1e5, 1e10, 1e15, 1e25, 1e36}, far_depths},
      {"mixtures", "Gaussians", {50, 500}, mixtures},
  };
  return families;
}

}  // namespace swiftgs
