// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <swiftgs/frame/view_constants.hpp>
#include <swiftgs/project/project.hpp>

namespace swiftgs {

/// Which Gaussians a pinhole view cannot show: none of them is `visible` to `project_through_pinhole`, which
/// takes ten times as long. In float, by the ball around the Gaussian and the inequalities of `ChunkCuller`,
/// for splats of alpha 1. In captures it leaves a tenth more than are visible.
struct GaussianCuller {
  float wide, high;                ///< half of a splat of size and depth 1 @units{pixels}
  float left, top, right, bottom;  ///< of the shown part beside the principal point, widened @units{pixels}

  SWIFTGS_HD explicit GaussianCuller(const ViewConstants& v) {
    const float x = v.most_wide * v.focal_x, y = v.most_high * v.focal_y;
    // The slack of projection is 2e-4 of both half sizes, and 0.02.
    wide = std::fma(3e-4f, y, x), high = std::fma(3e-4f, x, y);
    // sqrt(blur) <= (1 + blur) / 2.
    const float margin = std::fma(v.most_blur, std::fma(0.5f, v.blur, 0.5f), 0.05f);
    const float cx = v.pairs.cx.high, cy = v.pairs.cy.high;
    left = cx - v.left + margin, right = v.right - cx + margin;
    top = cy - v.top + margin, bottom = v.bottom - cy + margin;
  }

  /// A number that is NaN hides nothing.
  template <class Real = PlacingReal>
  SWIFTGS_HD bool hides(const ViewConstants& v, const Gaussian& g) const {
    const float opacity = v.opacity * g.opacity;
    if (opacity < v.alpha_min) return true;
    if (!(opacity <= 1)) return false;
    const PlacingConstants<Real> placing(v);
    const vec3 d(float(g.mean.x - placing.centre(0)), float(g.mean.y - placing.centre(1)),
                 float(g.mean.z - placing.centre(2)));
    const auto along = [&](int row) {
      return std::fma(v.axes[row][0], d.x, std::fma(v.axes[row][1], d.y, v.axes[row][2] * d.z));
    };
    const float x = along(0), y = along(1), z = along(2);
    // No coordinate errs by more than a third of it.
    const float rounding = 1e-6f * (std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z));
    const float scale = float(v.depth_scale);
    if (scale * (z + rounding) <= v.near_plane || scale * (z - rounding) > v.far_plane) return true;

    // As a quaternion that is no unit one lengthens it: see `most_lengthened`.
    const Quaternion& q = g.rotation;
    const float squares = std::fma(q.w, q.w, std::fma(q.x, q.x, std::fma(q.y, q.y, q.z * q.z)));
    const float largest =
        std::fmax(std::fabs(g.scale.x), std::fmax(std::fabs(g.scale.y), std::fabs(g.scale.z)));
    const float size = largest * std::fmax(1.0f, std::fma(2.0f, squares, -1.0f));
    const auto beyond = [&](float at, float focal, float side, float half) {
      return std::fma(focal, at, -side * z) > std::fma(size, half, rounding * (focal + std::fabs(side)));
    };
    return beyond(x, v.focal_x, right, wide) || beyond(-x, v.focal_x, left, wide) ||
           beyond(y, v.focal_y, bottom, high) || beyond(-y, v.focal_y, top, high);
  }
};

}  // namespace swiftgs
