// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <swiftgs/raster/raster.hpp>

namespace swiftgs {

/// Every pixel evaluates the whole exponent and exponential before it looks at alpha, as INRIA's rasterizer
/// and gsplat do: the baseline of the paper, 12 instructions a (pixel, splat) pair.
struct PerPixel {
  static constexpr std::string_view name = "per-pixel";

  class Kernel {
   public:
    SWIFTGS_HD Kernel(const SplatShape& s, vec2 first_centre, BlendRules rules)
        : mean_(s.mean), opacity_(s.opacity), rules_(rules), first_x_(first_centre.x) {
      const float ln_2 = 0.69314718055994530942f;
      a_ = 2 * ln_2 * s.l0 * s.l0;
      b_ = 2 * ln_2 * s.l0 * s.l1;
      c_ = 2 * ln_2 * (s.l1 * s.l1 + s.l2 * s.l2);
    }
    SWIFTGS_HD void start_row(float y) { y_ = y; }
    SWIFTGS_HD float alpha(int column) const {
      const float dx = first_x_ + float(column) - mean_.x, dy = y_ - mean_.y;
      const float sigma = 0.5f * (a_ * dx * dx + c_ * dy * dy) + b_ * dx * dy;
      const float alpha = opacity_ * std::exp(-sigma);
      if (!(sigma >= 0 && alpha >= rules_.alpha_min)) return 0;
      return alpha < rules_.alpha_max ? alpha : rules_.alpha_max;
    }

   private:
    vec2 mean_;
    float opacity_;
    BlendRules rules_;
    float first_x_;
    float a_, b_, c_;  ///< conic: sigma = (a dx^2 + c dy^2) / 2 + b dx dy
    float y_ = 0;
  };
};

static_assert(RasterPolicy<PerPixel>);

}  // namespace swiftgs
