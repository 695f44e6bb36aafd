// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cstdint>

#include <swiftgs/cpu/stages.hpp>

#include "parts.hpp"

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster_half_split.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "half-inl.hpp"
#include "split-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// `swiftgs::HalfSplit`: measured from the mean, terms as IEEE half; one that is too large is infinite.
struct HalfSplitTerms {
  using Cell = hwy::float16_t;
  static HWY_INLINE Vec Row(const Cell* HWY_RESTRICT terms) { return ToFloat(hn::Load(F16(), terms)); }
  static HWY_INLINE Vec All(const Cell& term) {
    return ToFloat(hn::BitCast(F16(), hn::Set(U16(), std::bit_cast<std::uint16_t>(term))));
  }
  static HWY_INLINE Vec Joined(Vec s) { return s; }
  static HWY_INLINE Mask Valid(Vec s) { return hn::Ge(s, hn::Zero(F32())); }

  template <class Terms>
  static HWY_INLINE void Prepare(const SplatShape& shape, vec2 first_centre, Terms& HWY_RESTRICT t) {
    const F32 d;
    const Vec a = hn::Set(d, shape.l0 * shape.l0), b = hn::Set(d, 2 * shape.l0 * shape.l1);
    const Vec c = hn::Set(d, shape.l1 * shape.l1 + shape.l2 * shape.l2);
    const vec2 from = shape.from_mean(first_centre);
    for (std::size_t i = 0; i < raster_block_side; i += lanes) {
      const Vec dx = hn::Add(hn::Set(d, from.x), hn::Iota(d, float(i)));
      const Vec dy = hn::Add(hn::Set(d, from.y), hn::Iota(d, float(i)));
      Store(hn::Mul(hn::Mul(a, dx), dx), t.x_square + i);
      Store(hn::Mul(b, dx), t.x_mixed + i);
      Store(hn::Mul(hn::Mul(c, dy), dy), t.y_square + i);
      Store(dy, t.y_offset + i);
    }
  }

 private:
  /// Rounds to the nearest half, as `to_half` does.
  static HWY_INLINE void Store(Vec v, Cell* HWY_RESTRICT to) {
    hn::Store(hn::BitCast(F16(), ToHalf(v)), F16(), to);
  }
};

void HalfSplitRasterBlocks(const RasterJob& job, const RasterBlocks& blocks, bool threshold,
                           std::size_t begin, std::size_t end) {
  threshold ? RenderRasterBlocksOf<SplitExponent<HalfSplitTerms, true>>(job, blocks, begin, end)
            : RenderRasterBlocksOf<SplitExponent<HalfSplitTerms, false>>(job, blocks, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(HalfSplitRasterBlocks);

void run(Cpu& cpu, const RasterJob& job, bool threshold) {
  for_raster_blocks(cpu, job, [&](const RasterBlocks& blocks, std::size_t begin, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(HalfSplitRasterBlocks)(job, blocks, threshold, begin, end);
  });
}
}  // namespace

void rasterize(Cpu& cpu, AxisShared<HalfSplit>, const RasterJob& job) { run(cpu, job, false); }
void rasterize(Cpu& cpu, AxisSharedThreshold<HalfSplit>, const RasterJob& job) { run(cpu, job, true); }

}  // namespace swiftgs
#endif
