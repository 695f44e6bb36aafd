// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <swiftgs/frame.hpp>
#include <swiftgs/frame/math.hpp>

namespace swiftgs::cli {

/// The depths between which colours tell depths apart, on a logarithmic scale. Nearer ones look like `low`,
/// farther ones like `high`. @units{world, to `length_power`}
struct DepthRange {
  float low = 0, high = 0;
  int length_power = 1;

  /// 0 of `low`, 1 of `high`. Expects a depth above 0.
  float part(float depth) const;
  /// The depth of a part; the other way round.
  float depth(float part) const;
};

/// The colour of a depth, by its part of the range; parts below 0 and above 1 have those of 0 and 1.
vec3 false_colour(float part);

/// A plane of a frame, to look at.
struct PlanePicture {
  Frame picture;                    ///< colour alone
  std::optional<DepthRange> range;  ///< of a plane of depths, unless it is empty
};

/// The one plane that `frame` has beside colour: alpha in grey; depths on a logarithmic scale from blue,
/// near, to yellow, far, cut at the nearest and the farthest hundredth; normals as (n + 1) / 2; each Gaussian
/// in a colour of its own. What no splat shows is black.
PlanePicture picture_of_plane(const Frame& frame);

}  // namespace swiftgs::cli
