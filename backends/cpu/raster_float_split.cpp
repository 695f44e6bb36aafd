// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <swiftgs/cpu/stages.hpp>

#include "parts.hpp"

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster_float_split.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "split-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// `swiftgs::FloatSplit`: measured from the raster block's centre, terms as they are computed, s at least 0.
struct FloatSplitTerms {
  using Cell = float;
  static HWY_INLINE Vec Row(const Cell* HWY_RESTRICT terms) { return hn::Load(F32(), terms); }
  static HWY_INLINE Vec All(const Cell& term) { return hn::Set(F32(), term); }
  static HWY_INLINE Vec Joined(Vec s) { return hn::IfThenZeroElse(hn::Lt(s, hn::Zero(F32())), s); }
  static HWY_INLINE Mask Valid(Vec s) { return hn::Ge(s, hn::Zero(F32())); }

  template <class Terms>
  static HWY_INLINE void Prepare(const SplatShape& shape, vec2 first_centre, Terms& HWY_RESTRICT t) {
    const F32 d;
    constexpr float half_side = 0.5f * float(raster_block_side - 1);
    const vec2 from = shape.from_mean(first_centre + half_side);
    const float u = std::fma(shape.l0, from.x, shape.l1 * from.y), v = shape.l2 * from.y;
    const Vec a = hn::Set(d, shape.l0 * shape.l0), b = hn::Set(d, 2 * shape.l0 * shape.l1);
    const Vec c = hn::Set(d, shape.l1 * shape.l1 + shape.l2 * shape.l2);
    const Vec linear_x = hn::Set(d, 2 * shape.l0 * u),
              linear_y = hn::Set(d, 2 * (shape.l1 * u + shape.l2 * v));
    const Vec constant = hn::Set(d, u * u + v * v);
    for (std::size_t i = 0; i < raster_block_side; i += lanes) {
      const Vec from_centre = hn::Iota(d, float(i) - half_side);
      hn::Store(hn::Mul(hn::MulAdd(a, from_centre, linear_x), from_centre), d, t.x_square + i);
      hn::Store(hn::Mul(b, from_centre), d, t.x_mixed + i);
      hn::Store(hn::MulAdd(hn::MulAdd(c, from_centre, linear_y), from_centre, constant), d, t.y_square + i);
      hn::Store(from_centre, d, t.y_offset + i);
    }
  }
};

void FloatSplitRasterBlocks(const RasterJob& job, const RasterBlocks& blocks, bool threshold,
                            std::size_t begin, std::size_t end) {
  threshold ? RenderRasterBlocksOf<SplitExponent<FloatSplitTerms, true>>(job, blocks, begin, end)
            : RenderRasterBlocksOf<SplitExponent<FloatSplitTerms, false>>(job, blocks, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(FloatSplitRasterBlocks);

void run(Cpu& cpu, const RasterJob& job, bool threshold) {
  for_raster_blocks(cpu, job, [&](const RasterBlocks& blocks, std::size_t begin, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(FloatSplitRasterBlocks)(job, blocks, threshold, begin, end);
  });
}
}  // namespace

void rasterize(Cpu& cpu, AxisShared<FloatSplit>, const RasterJob& job) { run(cpu, job, false); }
void rasterize(Cpu& cpu, AxisSharedThreshold<FloatSplit>, const RasterJob& job) { run(cpu, job, true); }

}  // namespace swiftgs
#endif
