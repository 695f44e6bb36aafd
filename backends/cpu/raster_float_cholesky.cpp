// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu/stages.hpp>

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

/// log2(alpha) = c - (p + q)^2: the terms that refuse rows are the terms of the pixels.
template <bool kThreshold>
class FloatCholeskyExponent {
 public:
  using Groups = Blocks;

  explicit FloatCholeskyExponent(const BlendRules& rules)
      : rules_(rules), least_exponent_(LeastExponent(rules)) {}

  HWY_INLINE Touched Prepare(std::size_t k, const SplatShape&, vec2, const RowFactors& factors) {
    return PrepareBlocks(factors, k, rules_.log2_alpha_min, terms_[k]);
  }

  HWY_INLINE void Alphas(const std::uint32_t* HWY_RESTRICT k, const Blocks::Part& at,
                         Vec (&alpha)[at_once]) const {
    const F32 d;
    for (std::size_t i = 0; i < at_once; ++i) {
      const CholeskyTerms& HWY_RESTRICT t = terms_[k[i]];
      const Vec u = hn::Add(at.OfPixels(t.p), at.OfRows(t.q));
      alpha[i] = hn::NegMulAdd(u, u, at.OfRows(t.c));
    }
    if constexpr (kThreshold) {
      Mask kept[at_once];
      for (std::size_t i = 0; i < at_once; ++i) kept[i] = hn::Ge(alpha[i], hn::Set(d, rules_.log2_alpha_min));
      Exp2(d, alpha, kept);
      for (std::size_t i = 0; i < at_once; ++i) alpha[i] = hn::Min(alpha[i], hn::Set(d, rules_.alpha_max));
    } else {
      for (std::size_t i = 0; i < at_once; ++i) alpha[i] = hn::Max(alpha[i], hn::Set(d, least_exponent_));
      Exp2(d, alpha);
      for (std::size_t i = 0; i < at_once; ++i) alpha[i] = CutAlpha(rules_, alpha[i]);
    }
  }

 private:
  BlendRules rules_;
  float least_exponent_;
  CholeskyTerms terms_[batch_size];
};

void FloatCholeskyRasterBlocks(const RasterJob& job, const RasterBlocks& blocks, bool threshold,
                               std::size_t begin, std::size_t end) {
  threshold ? RenderRasterBlocksOf<FloatCholeskyExponent<true>>(job, blocks, begin, end)
            : RenderRasterBlocksOf<FloatCholeskyExponent<false>>(job, blocks, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(FloatCholeskyRasterBlocks);

void run(Cpu& cpu, const RasterJob& job, bool threshold) {
  for_raster_blocks(cpu, job, [&](const RasterBlocks& blocks, std::size_t begin, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(FloatCholeskyRasterBlocks)(job, blocks, threshold, begin, end);
  });
}
}  // namespace

void rasterize(Cpu& cpu, AxisShared<FloatCholesky>, const RasterJob& job) { run(cpu, job, false); }
void rasterize(Cpu& cpu, AxisSharedThreshold<FloatCholesky>, const RasterJob& job) { run(cpu, job, true); }

}  // namespace swiftgs
#endif
