// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu.hpp>

#include "parts.hpp"

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster_float_cholesky.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "raster-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// log2(alpha) = c[y] - (p[x] + q[y])^2: the terms that refuse rows are the terms of the pixels.
template <bool kThreshold>
class FloatCholeskyForm {
 public:
  using Groups = Blocks;

  explicit FloatCholeskyForm(const BlendRules& rules)
      : alpha_min_(rules.alpha_min), log2_alpha_min_(std::log2(rules.alpha_min)) {}

  HWY_INLINE Touched Prepare(std::size_t k, const SplatShape& shape, vec2 first_centre,
                             float log2_alpha_min) {
    return PrepareBlocks(shape, first_centre, log2_alpha_min, terms_[k]);
  }

  HWY_INLINE void Alphas(const std::uint32_t* HWY_RESTRICT k, const Blocks::Part& at, Mask (&kept)[at_once],
                         Vec (&alpha)[at_once]) const {
    const F32 d;
    for (std::size_t i = 0; i < at_once; ++i) {
      const CholeskyTerms& HWY_RESTRICT t = terms_[k[i]];
      const Vec u = hn::Add(at.OfColumns(t.p), at.OfRows(t.q));
      const Vec log2_alpha = hn::NegMulAdd(u, u, at.OfRows(t.c));
      if constexpr (kThreshold) kept[i] = hn::Ge(log2_alpha, hn::Set(d, log2_alpha_min_));
      alpha[i] = kThreshold ? log2_alpha : hn::Max(log2_alpha, hn::Set(d, least_exponent));
    }
    Exp2(d, alpha);
    if constexpr (!kThreshold)
      for (std::size_t i = 0; i < at_once; ++i) kept[i] = hn::Ge(alpha[i], hn::Set(d, alpha_min_));
  }

 private:
  float alpha_min_, log2_alpha_min_;
  CholeskyTerms terms_[batch_size];
};

void FloatCholeskySquares(const RasterJob& job, const Squares& squares, bool threshold, std::size_t begin,
                          std::size_t end) {
  threshold ? RenderSquaresOf<FloatCholeskyForm<true>>(job, squares, begin, end)
            : RenderSquaresOf<FloatCholeskyForm<false>>(job, squares, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(FloatCholeskySquares);

void run(Cpu& cpu, const RasterJob& job, bool threshold) {
  for_squares(cpu, job, [&](const Squares& squares, std::size_t begin, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(FloatCholeskySquares)(job, squares, threshold, begin, end);
  });
}
}  // namespace

void rasterize(Cpu& cpu, AxisShared<FloatCholesky>, const RasterJob& job) { run(cpu, job, false); }
void rasterize(Cpu& cpu, AxisSharedThreshold<FloatCholesky>, const RasterJob& job) { run(cpu, job, true); }

}  // namespace swiftgs
#endif
