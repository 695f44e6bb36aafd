// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <swiftgs/frame.hpp>

namespace swiftgs::cli {

/// A plane of a frame, to look at.
struct PlanePicture {
  std::string plane;
  Frame picture;  ///< colour alone
};

/// The planes of `frame` beside colour: alpha in grey; depths on a logarithmic scale from blue, near, to
/// yellow, far, cut at the nearest and the farthest hundredth; normals as (n + 1) / 2; each Gaussian in a
/// colour of its own. What no splat shows is black.
std::vector<PlanePicture> pictures_of_planes(const Frame& frame);

}  // namespace swiftgs::cli
