// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <iterator>

#include <swiftgs/frame/float_pair.hpp>
#include <swiftgs/frame/lens.hpp>
#include <swiftgs/frame/view_constants.hpp>

namespace swiftgs::vulkan {

/// What shaders know of a view and a placed scene that it shows, as project.glsl declares it.
struct Eye {
  FloatPair rotation[9], centre[3], fx, fy, cx, cy, depth_scale;
  FloatPair least_u, most_u, least_v, most_v, log2_alpha_min;
  FloatPair radial[4], rational[3], tangential[2], prism[2], fold_squared, most_cosecant, turn,
      panorama_middle;
  float blur, opacity, alpha_min, min_compensation;
  float near_plane, far_plane, width, height;
  float left, top, right, bottom;
  std::uint32_t antialiased, lens, depth_is_distance, order_is_distance;

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
        fold_squared(pair(v.limits.fold_squared)),
        most_cosecant(pair(v.limits.most_cosecant)),
        turn(pair(v.turn)),
        panorama_middle(pair(v.panorama_middle)),
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
        antialiased(v.antialiased),
        lens(lens_of(v)),
        depth_is_distance(v.depth_is_distance),
        order_is_distance(v.order_is_distance) {
    for (int k = 0; k < 9; ++k) rotation[k] = pair(v.rotation[k / 3][k % 3]);
    for (int k = 0; k < 3; ++k) centre[k] = pair(v.centre[k]);
    const Distortion& d = v.lens.distortion;
    for (int k = 0; k < 4; ++k) radial[k] = pair(d.radial[k]);
    for (int k = 0; k < 3; ++k) rational[k] = pair(d.rational[k]);
    for (int k = 0; k < 2; ++k) tangential[k] = pair(d.tangential[k]), prism[k] = pair(d.prism[k]);
  }

  /// A `LensModel`, or the number of a pinhole that takes z alone.
  static std::uint32_t lens_of(const ViewConstants& v) {
    return v.through_lens ? std::uint32_t(v.lens.model) : std::uint32_t(std::size(lens_traits));
  }

 private:
  /// Infinite numbers have nothing below them.
  static FloatPair pair(double x) { return std::isinf(x) ? FloatPair{float(x), 0} : FloatPair::from(x); }
};

}  // namespace swiftgs::vulkan
