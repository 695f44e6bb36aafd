// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include <swiftgs/frame/float_pair.hpp>
#include <swiftgs/frame/view_constants.hpp>

namespace swiftgs::vulkan {

/// What shaders know of a view and a placed scene that it shows, as project.glsl declares it.
struct Eye {
  FloatPair rotation[9], centre[3], fx, fy, cx, cy, depth_scale;
  FloatPair least_u, most_u, least_v, most_v, log2_alpha_min;
  float blur, opacity, alpha_min, min_compensation;
  float near_plane, far_plane, width, height;
  float left, top, right, bottom;
  std::uint32_t antialiased;

  Eye() = default;
  explicit Eye(const ViewConstants& v)
      : fx(pair(v.fx)),
        fy(pair(v.fy)),
        cx(pair(v.cx)),
        cy(pair(v.cy)),
        depth_scale(pair(v.depth_scale)),
        least_u(pair(v.limits.least_u)),
        most_u(pair(v.limits.most_u)),
        least_v(pair(v.limits.least_v)),
        most_v(pair(v.limits.most_v)),
        log2_alpha_min(pair(std::log2(double(v.alpha_min)))),
        blur(v.blur),
        opacity(v.opacity),
        alpha_min(v.alpha_min),
        min_compensation(v.min_compensation),
        near_plane(v.near_plane),
        far_plane(v.far_plane),
        width(v.width),
        height(v.height),
        left(v.left),
        top(v.top),
        right(v.right),
        bottom(v.bottom),
        antialiased(v.antialiased) {
    for (int k = 0; k < 9; ++k) rotation[k] = pair(v.rotation[k / 3][k % 3]);
    for (int k = 0; k < 3; ++k) centre[k] = pair(v.centre[k]);
  }

 private:
  /// Infinite numbers have nothing below them.
  static FloatPair pair(double x) { return std::isinf(x) ? FloatPair{float(x), 0} : FloatPair::from(x); }
};

}  // namespace swiftgs::vulkan
