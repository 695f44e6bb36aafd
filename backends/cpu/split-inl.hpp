// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_SPLIT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_SPLIT_INL
#undef SWIFTGS_CPU_SPLIT_INL
#else
#define SWIFTGS_CPU_SPLIT_INL
#endif

#include <cstddef>
#include <cstdint>

#include "raster-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// s = x_square[x] + y_square[y] + x_mixed[x] y_offset[y], the four computed and kept as `Split` has it.
/// Where the sum is not a number, no comparison holds and the pixel skips the splat.
template <class Split, bool kThreshold>
class SplitExponent {
 public:
  using Groups = Rows;

  explicit SplitExponent(const BlendRules& rules) : rules_(rules), least_exponent_(LeastExponent(rules)) {}

  HWY_INLINE Touched Prepare(std::size_t k, const SplatShape& shape, vec2 first_centre,
                             const RowFactors& factors) {
    Terms& HWY_RESTRICT t = terms_[k];
    t.opacity = shape.opacity, t.cutoff = shape.cutoff;
    t.log2_opacity = factors.log2_opacity[k];
    Split::Prepare(shape, first_centre, t);
    return PrepareRows(factors, k);
  }

  HWY_INLINE void Alphas(const std::uint32_t* HWY_RESTRICT k, Rows::Part at, Vec (&alpha)[at_once]) const {
    for (std::size_t i = 0; i < at_once; ++i) alpha[i] = Alpha(k[i], at);
  }

 private:
  HWY_INLINE Vec Alpha(std::size_t k, Rows::Part at) const {
    const F32 d;
    const Terms& HWY_RESTRICT t = terms_[k];
    const Vec squares = hn::Add(Split::Row(t.x_square + at.column), Split::All(t.y_square[at.row]));
    const Vec sum = hn::MulAdd(Split::Row(t.x_mixed + at.column), Split::All(t.y_offset[at.row]), squares);
    const Vec s = Split::Joined(sum);
    const Mask valid = Split::Valid(s);
    if constexpr (kThreshold) {
      const Mask kept[] = {hn::And(valid, hn::Le(s, hn::Set(d, t.cutoff)))};
      // As an exponent, opacity needs no product.
      Vec alpha[] = {hn::Sub(hn::Set(d, t.log2_opacity), s)};
      Exp2(d, alpha, kept);
      return hn::Min(alpha[0], hn::Set(d, rules_.alpha_max));
    } else {
      const Vec fall = Exp2(d, hn::Max(hn::Neg(s), hn::Set(d, least_exponent_)));
      return hn::IfThenElseZero(valid, CutAlpha(rules_, hn::Mul(hn::Set(d, t.opacity), fall)));
    }
  }

  using Cell = typename Split::Cell;
  struct alignas(64) Terms {
    Cell x_square[raster_block_side], x_mixed[raster_block_side], y_square[raster_block_side],
        y_offset[raster_block_side];
    float opacity, log2_opacity, cutoff;
  };
  BlendRules rules_;
  float least_exponent_;
  Terms terms_[batch_size];
};

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
