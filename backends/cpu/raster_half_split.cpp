// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu.hpp>

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

/// Terms as IEEE half; one that is too large is infinite.
struct HalfStorage {
  using Cell = hwy::float16_t;

  /// Rounds to the nearest half, as `to_half` does.
  static HWY_INLINE void Store(Vec v, Cell* HWY_RESTRICT to) {
    hn::Store(hn::BitCast(F16(), ToHalf(v)), F16(), to);
  }
  static HWY_INLINE Vec Row(const Cell* HWY_RESTRICT terms) {
    return hn::PromoteTo(F32(), hn::Load(F16(), terms));
  }
  static HWY_INLINE Vec All(const Cell& term) {
    return hn::PromoteTo(F32(), hn::BitCast(F16(), hn::Set(U16(), term.bits)));
  }
};

void HalfSplitTiles(const RasterJob& job, bool threshold, std::size_t begin, std::size_t end) {
  threshold ? RenderTilesOf<SplitForm<HalfStorage, true>>(job, begin, end)
            : RenderTilesOf<SplitForm<HalfStorage, false>>(job, begin, end);
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
