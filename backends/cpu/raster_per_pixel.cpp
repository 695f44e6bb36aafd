// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu/stages.hpp>

#include "parts.hpp"

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster_per_pixel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "raster-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// Each pixel evaluates its whole exponent, from the factor as it is stored, and exponential.
class PerPixelExponent {
 public:
  using Groups = Rows;

  explicit PerPixelExponent(const BlendRules& rules) : rules_(rules), least_exponent_(LeastExponent(rules)) {}

  HWY_INLINE Touched Prepare(std::size_t k, const SplatShape& shape, vec2 first_centre,
                             const RowFactors& factors) {
    splats_[k] = {shape.from_mean(first_centre), shape.l0, shape.l1, shape.l2, shape.opacity};
    return PrepareRows(factors, k);
  }

  HWY_INLINE void Alphas(const std::uint32_t* HWY_RESTRICT k, Rows::Part at, Vec (&alpha)[at_once]) const {
    for (std::size_t i = 0; i < at_once; ++i) alpha[i] = Alpha(k[i], at);
  }

 private:
  HWY_INLINE Vec Alpha(std::size_t k, Rows::Part at) const {
    const F32 d;
    const Splat& HWY_RESTRICT splat = splats_[k];
    const Vec dx = hn::Add(hn::Iota(d, float(at.column)), hn::Set(d, splat.from_mean.x));
    const Vec dy = hn::Add(hn::Set(d, float(at.row)), hn::Set(d, splat.from_mean.y));
    const Vec u = hn::MulAdd(hn::Set(d, splat.l0), dx, hn::Mul(hn::Set(d, splat.l1), dy));
    const Vec v = hn::Mul(hn::Set(d, splat.l2), dy);
    const Vec exponent = hn::Neg(hn::MulAdd(u, u, hn::Mul(v, v)));
    const Vec fall = Exp2(d, hn::Max(exponent, hn::Set(d, least_exponent_)));
    return CutAlpha(rules_, hn::Mul(hn::Set(d, splat.opacity), fall));
  }

  struct Splat {
    vec2 from_mean;  ///< to the raster block's first pixel centre
    float l0, l1, l2, opacity;
  };
  BlendRules rules_;
  float least_exponent_;
  Splat splats_[batch_size];
};

void PerPixelRasterBlocks(const RasterJob& job, const RasterBlocks& blocks, std::size_t begin,
                          std::size_t end) {
  RenderRasterBlocksOf<PerPixelExponent>(job, blocks, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(PerPixelRasterBlocks);
}  // namespace

void rasterize(Cpu& cpu, PerPixel, const RasterJob& job) {
  for_raster_blocks(cpu, job, [&](const RasterBlocks& blocks, std::size_t begin, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(PerPixelRasterBlocks)(job, blocks, begin, end);
  });
}

}  // namespace swiftgs
#endif
