// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu.hpp>

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster_float_split.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "raster-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// s = x_square[x] + y_square[y] + x_mixed[x] y_offset[y].
template <bool kThreshold>
class FloatSplitForm {
 public:
  explicit FloatSplitForm(const BlendRules& rules) : alpha_min_(rules.alpha_min) {}

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
      hn::Store(hn::Mul(hn::Mul(a, dx), dx), d, t.x_square + i);
      hn::Store(hn::Mul(b, dx), d, t.x_mixed + i);
      hn::Store(hn::Mul(hn::Mul(c, dy), dy), d, t.y_square + i);
      hn::Store(dy, d, t.y_offset + i);
    }
    CholeskyTerms rows;
    return PrepareRows(shape, first_centre, log2_alpha_min, rows);
  }

  HWY_INLINE bool Alpha(std::size_t k, std::size_t row, std::size_t column, Mask& kept, Vec& alpha) const {
    const F32 d;
    const Terms& HWY_RESTRICT t = terms_[k];
    const Vec squares = hn::Add(hn::Load(d, t.x_square + column), hn::Set(d, t.y_square[row]));
    const Vec s = hn::MulAdd(hn::Load(d, t.x_mixed + column), hn::Set(d, t.y_offset[row]), squares);
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
  struct alignas(64) Terms {
    float x_square[tile_side], x_mixed[tile_side], y_square[tile_side], y_offset[tile_side];
    float opacity, reach;
  };
  float alpha_min_;
  Terms terms_[batch_size];
};

void FloatSplitTiles(const RasterJob& job, bool threshold, std::size_t begin, std::size_t end) {
  threshold ? RenderTilesOf<FloatSplitForm<true>>(job, begin, end)
            : RenderTilesOf<FloatSplitForm<false>>(job, begin, end);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(FloatSplitTiles);

void run(Cpu& cpu, const RasterJob& job, bool threshold) {
  cpu.for_parts(job.grid.size(), 4, [&](std::size_t begin, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(FloatSplitTiles)(job, threshold, begin, end);
  });
}
}  // namespace

void rasterize(Cpu& cpu, AxisShared<FloatSplit>, const RasterJob& job) { run(cpu, job, false); }
void rasterize(Cpu& cpu, AxisSharedThreshold<FloatSplit>, const RasterJob& job) { run(cpu, job, true); }

}  // namespace swiftgs
#endif
