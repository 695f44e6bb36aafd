// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/bounds.hpp>

namespace swiftgs {

/// Exactly the tiles that the ellipse s <= cutoff meets.
struct SWIFTGS_API Ellipse {
  static constexpr std::string_view name = "ellipse";
  static constexpr bool conservative = true;

  class Tiles {
   public:
    TileRect rect;

    SWIFTGS_HD Tiles(const SplatShape& shape, const EllipseExtent& half, TileGrid grid)
        : rect(convex_box(shape, half, grid)),
          side_(grid.side),
          mean_(shape.mean),
          inverse_l0_(near_inverse(shape.l0)),
          l1_(shape.l1),
          l2_(shape.l2),
          cutoff_(shape.cutoff),
          height_(half.height),
          slack_(half.slack) {
      const float slope = l1_ * near_inverse(l2_);
      steepest_ = height_ * slope * near_inverse(near_sqrt(1 + slope * slope));
    }

    /// The part of the ellipse in a row of tiles is convex, so it spans one run of columns. Its ends are the
    /// ellipse's own if those lie in the row, else they lie on the row's nearer border.
    SWIFTGS_HD TileRun row(int row) const {
      const float top = float(row * side_) + 0.5f - mean_.y - slack_;
      const float bottom = top + float(side_ - 1) + 2 * slack_;
      const float right = mean_.x + edge(clamp(-steepest_, top, bottom), 1.0f) + slack_;
      const float left = mean_.x + edge(clamp(steepest_, top, bottom), -1.0f) - slack_;
      return tiles_meeting(left, right, side_).within(rect.columns);
    }

   private:
    /// y from `top` to `bottom` and within the ellipse.
    SWIFTGS_HD float clamp(float y, float top, float bottom) const {
      return limited(limited(y, top, bottom), -height_, height_);
    }
    SWIFTGS_HD static float limited(float x, float low, float high) {
#if defined(__CUDA_ARCH__)
      return fminf(fmaxf(x, low), high);
#else
      x = x < low ? low : x;
      return x > high ? high : x;
#endif
    }
    /// x = (u - l1 y) / l0 with u^2 + (l2 y)^2 = cutoff.
    SWIFTGS_HD float edge(float y, float sign) const {
      const float v = l2_ * y, rest = cutoff_ - v * v;
      return (sign * near_sqrt(rest > 0 ? rest : 0.0f) - l1_ * y) * inverse_l0_;
    }

    int side_;
    vec2 mean_;
    float inverse_l0_, l1_, l2_, cutoff_;
    float height_, slack_;
    float steepest_;  ///< the rightmost point lies at y = -steepest, the leftmost at +steepest
  };

  SWIFTGS_HD Tiles tiles(const SplatShape& shape, TileGrid grid) const {
    return {shape, EllipseExtent(shape), grid};
  }
};

static_assert(BoundsPolicy<Ellipse>);

}  // namespace swiftgs
