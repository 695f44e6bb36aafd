// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/raster.hpp>

namespace swiftgs {

/// Every pixel evaluates the whole exponent and exponential before it looks at alpha, as INRIA's rasterizer
/// and gsplat do: the baseline of the paper. The exponent is a sum of squares of the stored factor; the
/// textbook's conic loses all digits on a long oblique splat.
struct SWIFTGS_API PerPixel {
  static constexpr std::string_view name = "per-pixel";

  class Kernel {
   public:
    SWIFTGS_HD Kernel(const SplatShape& s, vec2 first_centre, BlendRules rules)
        : shape_(s), rules_(rules), first_x_(first_centre.x) {}
    SWIFTGS_HD void start_row(float y) { y_ = y; }
    SWIFTGS_HD float alpha(int column) const {
      const float dx = shape_.right_of_mean(first_x_ + float(column)), dy = shape_.below_mean(y_);
      const float u = shape_.l0 * dx + shape_.l1 * dy, v = shape_.l2 * dy;
      const float alpha = shape_.opacity * std::exp2(-(u * u + v * v));
      if (!(alpha >= rules_.alpha_min)) return 0;
      return alpha < rules_.alpha_max ? alpha : rules_.alpha_max;
    }

   private:
    const SplatShape& shape_;
    BlendRules rules_;
    float first_x_;
    float y_ = 0;
  };
};

static_assert(RasterPolicy<PerPixel>);

}  // namespace swiftgs
