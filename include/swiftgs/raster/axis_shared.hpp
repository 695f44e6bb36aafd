// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/raster/exponents.hpp>
#include <swiftgs/tools/policy_lists.hpp>

namespace swiftgs {

namespace detail {
/// Terms of one splat in one raster block: sixteen of x, and the y term of the current row.
template <ExponentPolicy Exponent>
class SharedTerms {
 public:
  SWIFTGS_HD SharedTerms(const SplatShape& shape, vec2 first_centre)
      : terms_(shape, first_centre + 0.5f * float(raster_block_side - 1)) {
    for (int column = 0; column < raster_block_side; ++column)
      x_[column] = terms_.x_term(first_centre.x + float(column));
  }
  SWIFTGS_HD void start_row(float y) { y_ = terms_.y_term(y); }
  SWIFTGS_HD float exponent(int column) const { return Exponent::exponent(x_[column], y_); }

 private:
  Exponent terms_;
  typename Exponent::X x_[raster_block_side];
  typename Exponent::Y y_{};
};
}  // namespace detail

/// Axis-shared rasterization (SwiftGS, section 5.1): the terms of a column and of a row are computed once and
/// joined at each pixel, which then evaluates the exponential and looks at alpha.
template <ExponentPolicy Exponent>
struct SWIFTGS_API AxisShared {
  static constexpr ComposedName name_storage{"axis-shared-", Exponent::name};
  static constexpr std::string_view name = name_storage.view();

  class Kernel {
   public:
    SWIFTGS_HD Kernel(const SplatShape& s, vec2 first_centre, BlendRules rules)
        : terms_(s, first_centre), opacity_(s.opacity), rules_(rules) {}
    SWIFTGS_HD void start_row(float y) { terms_.start_row(y); }
    SWIFTGS_HD float alpha(int column) const {
      const float s = terms_.exponent(column);
      const float alpha = opacity_ * std::exp2(-s);
      if (!(s >= 0 && alpha >= rules_.alpha_min)) return 0;
      return alpha < rules_.alpha_max ? alpha : rules_.alpha_max;
    }

   private:
    detail::SharedTerms<Exponent> terms_;
    float opacity_;
    BlendRules rules_;
  };
};

/// Axis-shared rasterization with the dynamic threshold (SwiftGS, section 5.2): a pixel compares its exponent
/// with the splat's own ln(255 o), here in base 2, and evaluates the exponential only where the splat shows.
template <ExponentPolicy Exponent>
struct SWIFTGS_API AxisSharedThreshold {
  static constexpr ComposedName name_storage{"axis-shared-threshold-", Exponent::name};
  static constexpr std::string_view name = name_storage.view();

  class Kernel {
   public:
    SWIFTGS_HD Kernel(const SplatShape& s, vec2 first_centre, BlendRules rules)
        : terms_(s, first_centre), opacity_(s.opacity), cutoff_(s.cutoff), alpha_max_(rules.alpha_max) {}
    SWIFTGS_HD void start_row(float y) { terms_.start_row(y); }
    SWIFTGS_HD float alpha(int column) const {
      const float s = terms_.exponent(column);
      if (!(s >= 0 && s <= cutoff_)) return 0;
      const float alpha = opacity_ * std::exp2(-s);
      return alpha < alpha_max_ ? alpha : alpha_max_;
    }

   private:
    detail::SharedTerms<Exponent> terms_;
    float opacity_, cutoff_, alpha_max_;
  };
};

}  // namespace swiftgs
