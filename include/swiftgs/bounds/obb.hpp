// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/bounds.hpp>

namespace swiftgs {

/// The tiles that the oriented bounding box of the ellipse s <= cutoff meets: the rectangle around it along
/// its own axes, as in GSCore (Lee et al. 2024).
struct SWIFTGS_API Obb {
  static constexpr std::string_view name = "obb";
  static constexpr bool conservative = true;

  class Tiles {
   public:
    TileRect rect;

    SWIFTGS_HD Tiles(const SplatShape& shape, const EllipseExtent& half, TileGrid grid)
        : rect(convex_box(shape, half, grid)), side_(grid.side), mean_(shape.mean), slack_(half.slack) {
      const vec2 axis = short_axis(shape);
      across_ = Slab(shape, axis), along_ = Slab(shape, vec2(-axis.y, axis.x));
      corner_ = across_.half * across_.tilt + along_.half * along_.tilt;
      top_ = std::fabs(across_.half * across_.tilt) + std::fabs(along_.half * along_.tilt);
    }

    /// The box is convex, so it meets a row of tiles in one run of columns. The ends of the run are the
    /// corners of the box where those lie in the row, and on the row's nearer border where they do not.
    SWIFTGS_HD TileRun row(int row) const {
      const float top = float(row * side_) + 0.5f - mean_.y - slack_;
      const float bottom = top + float(side_ - 1) + 2 * slack_;
      const float right = mean_.x + right_end(top, bottom) + slack_;
      const float left = mean_.x - right_end(-bottom, -top) - slack_;  // the box is its own mirror image
      return tiles_meeting(left, right, side_).within(rect.columns);
    }

   private:
    /// Points whose distance along a unit normal is at most `half`, on either side of the mean.
    struct Slab {
      float half = 0;       ///< @units{pixels}
      float tilt = 0;       ///< y of the normal that points to the right
      float inverse_x = 0;  ///< 1 / its x; 0 if the slab is too level to bound x in float

      Slab() = default;
      SWIFTGS_HD Slab(const SplatShape& s, vec2 normal) {
        // On the ellipse, the largest normal . p is sqrt(cutoff) times the length of the normal seen through
        // the inverse of the factor, whatever the normal: rounding it cuts nothing.
        const float u = normal.x / s.l0, v = (normal.y - s.l1 * u) / s.l2;
        half = std::sqrt(s.cutoff) * std::sqrt(u * u + v * v);
        tilt = normal.x < 0 ? -normal.y : normal.y;
        inverse_x = std::fabs(normal.x) > 0.01f ? 1 / std::fabs(normal.x) : 0.0f;
      }
    };

    /// Unit vector along the shorter axis of the ellipse, where the precision is largest.
    SWIFTGS_HD static vec2 short_axis(const SplatShape& s) {
      const float largest = std::fmax(std::fmax(s.l0, std::fabs(s.l1)), s.l2);
      const float l0 = s.l0 / largest, l1 = s.l1 / largest, l2 = s.l2 / largest;
      const float level = l0 * l0 - (l1 * l1 + l2 * l2), mixed = 2 * l0 * l1;
      const float length = std::sqrt(level * level + mixed * mixed);
      if (!(length > 0)) return vec2(1, 0);  // a circle has no axis
      // cos and sin of half the angle whose cosine is level / length. The larger one first: nothing cancels.
      const float larger = std::sqrt(0.5f + 0.5f * std::fabs(level) / length);
      const float smaller = mixed / (2 * length * larger);
      return level >= 0 ? vec2(larger, smaller) : vec2(std::fabs(smaller), mixed < 0 ? -larger : larger);
    }

    /// Largest x of the box from `top` to `bottom`, all from the mean. It lies at the right corner or at the
    /// border nearest to it.
    SWIFTGS_HD float right_end(float top, float bottom) const {
      float y = corner_ < top ? top : corner_ > bottom ? bottom : corner_;
      y = y < -top_ ? -top_ : y > top_ ? top_ : y;
      float x = INFINITY;
      if (across_.inverse_x > 0) x = (across_.half - across_.tilt * y) * across_.inverse_x;
      if (along_.inverse_x > 0) x = std::fmin(x, (along_.half - along_.tilt * y) * along_.inverse_x);
      return x;
    }

    int side_;
    vec2 mean_;
    float slack_;
    Slab across_, along_;
    float corner_;  ///< y of the right corner, from the mean
    float top_;     ///< half the height of the box
  };

  SWIFTGS_HD Tiles tiles(const SplatShape& shape, TileGrid grid) const {
    return {shape, EllipseExtent(shape), grid};
  }
};

static_assert(BoundsPolicy<Obb>);

}  // namespace swiftgs
