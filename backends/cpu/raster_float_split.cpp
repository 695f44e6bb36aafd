// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu.hpp>

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

/// Terms as they are computed.
struct FloatStorage {
  using Cell = float;
  static HWY_INLINE void Store(Vec v, Cell* HWY_RESTRICT to) { hn::Store(v, F32(), to); }
  static HWY_INLINE Vec Row(const Cell* HWY_RESTRICT terms) { return hn::Load(F32(), terms); }
  static HWY_INLINE Vec All(const Cell& term) { return hn::Set(F32(), term); }
};

void FloatSplitTiles(const RasterJob& job, bool threshold, std::size_t begin, std::size_t end) {
  threshold ? RenderTilesOf<SplitForm<FloatStorage, true>>(job, begin, end)
            : RenderTilesOf<SplitForm<FloatStorage, false>>(job, begin, end);
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
