// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu.hpp>

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster_half_split.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "raster-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// s = x_square[x] + y_square[y] + x_mixed[x] y_offset[y], the four stored as IEEE half. A term too large for
/// a half is infinite; where the sum is then not a number, no comparison holds and the pixel skips the splat.
template <bool kThreshold>
class HalfSplitForm {
 public:
  explicit HalfSplitForm(const BlendRules& rules) : alpha_min_(rules.alpha_min) {}

  HWY_INLINE std::uint32_t Prepare(std::size_t k, const SplatShape& shape, vec2 first_centre,
                                   float log2_alpha_min) {
    const F32 d;
    Terms& HWY_RESTRICT t = terms_[k];
    t.opacity = shape.opacity, t.reach = shape.reach;
    const Vec a = hn::Set(d, shape.l0 * shape.l0), b = hn::Set(d, 2 * shape.l0 * shape.l1);
    const Vec c = hn::Set(d, shape.l1 * shape.l1 + shape.l2 * shape.l2);
    const float first_dx = first_centre.x - shape.mean.x, first_dy = first_centre.y - shape.mean.y;
    for (std::size_t i = 0; i < tile_side; i += lanes) {
      const Vec dx = hn::Add(hn::Set(d, first_dx), hn::Iota(d, float(i)));
      const Vec dy = hn::Add(hn::Set(d, first_dy), hn::Iota(d, float(i)));
      StoreHalf(hn::Mul(hn::Mul(a, dx), dx), t.x_square + i);
      StoreHalf(hn::Mul(b, dx), t.x_mixed + i);
      StoreHalf(hn::Mul(hn::Mul(c, dy), dy), t.y_square + i);
      StoreHalf(dy, t.y_offset + i);
    }
    CholeskyTerms rows;
    return PrepareRows(shape, first_centre, log2_alpha_min, rows);
  }

  HWY_INLINE bool Alpha(std::size_t k, std::size_t row, std::size_t column, Mask& kept, Vec& alpha) const {
    const F32 d;
    const Terms& HWY_RESTRICT t = terms_[k];
    const Vec squares = hn::Add(Row(t.x_square + column), All(t.y_square[row]));
    const Vec s = hn::MulAdd(Row(t.x_mixed + column), All(t.y_offset[row]), squares);
    const Mask positive = hn::Ge(s, hn::Zero(d));
    if constexpr (kThreshold) {
      kept = hn::And(positive, hn::Le(s, hn::Set(d, t.reach)));
      if (hn::AllFalse(d, kept)) return false;
      alpha = hn::Mul(hn::Set(d, t.opacity), Exp2(d, hn::Neg(s)));
    } else {
      alpha = hn::Mul(hn::Set(d, t.opacity), Exp2(d, hn::Max(hn::Neg(s), hn::Set(d, -64.0f))));
      kept = hn::And(positive, hn::Ge(alpha, hn::Set(d, alpha_min_)));
    }
    return true;
  }

 private:
  using F16 = hn::Rebind<hwy::float16_t, F32>;
  using U16 = hn::Rebind<std::uint16_t, F32>;
  /// Rounds to the nearest half, as `to_half` does.
  static HWY_INLINE void StoreHalf(Vec v, hwy::float16_t* HWY_RESTRICT to) {
#if HWY_ARCH_X86 && HWY_TARGET >= HWY_SSE4
    // Where the processor has no such conversion, Highway's truncates and has no infinity.
    alignas(64) float values[lanes];
    hn::Store(v, F32(), values);
    for (std::size_t i = 0; i < lanes; ++i) to[i].bits = to_half(values[i]).bits;
#else
    hn::Store(hn::DemoteTo(F16(), v), F16(), to);
#endif
  }
  static HWY_INLINE Vec Row(const hwy::float16_t* HWY_RESTRICT terms) {
    return hn::PromoteTo(F32(), hn::Load(F16(), terms));
  }
  static HWY_INLINE Vec All(const hwy::float16_t& term) {
    return hn::PromoteTo(F32(), hn::BitCast(F16(), hn::Set(U16(), term.bits)));
  }
  struct alignas(64) Terms {
    hwy::float16_t x_square[tile_side], x_mixed[tile_side], y_square[tile_side], y_offset[tile_side];
    float opacity, reach;
  };
  float alpha_min_;
  Terms terms_[batch_size];
};

void HalfSplitTiles(const RasterJob& job, bool threshold, std::size_t begin, std::size_t end) {
  threshold ? RenderTilesOf<HalfSplitForm<true>>(job, begin, end)
            : RenderTilesOf<HalfSplitForm<false>>(job, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(HalfSplitTiles);

void run(Cpu& cpu, const RasterJob& job, bool threshold) {
  cpu.for_parts(job.grid.size(), 4, [&](std::size_t begin, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(HalfSplitTiles)(job, threshold, begin, end);
  });
}
}  // namespace

void rasterize(Cpu& cpu, AxisShared<HalfSplit>, const RasterJob& job) { run(cpu, job, false); }
void rasterize(Cpu& cpu, AxisSharedThreshold<HalfSplit>, const RasterJob& job) { run(cpu, job, true); }

}  // namespace swiftgs
#endif
