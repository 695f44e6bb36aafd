// SPDX-License-Identifier: Apache-2.0
#include "raster_warps.cuh"

namespace swiftgs {
namespace kernels {

/// `FloatSplit` in registers: a dx^2 and b dx once for both pixels of a lane, c dy^2 for each.
struct SplitForm {
  __device__ static void prepare(const SplatShape& s, vec2 mean, float log2_alpha_min, float4& terms,
                                 float2& offsets) {
    terms = make_float4(s.l0 * s.l0, 2 * s.l0 * s.l1, fmaf(s.l1, s.l1, s.l2 * s.l2), s.reach + log2_alpha_min);
    offsets = make_float2(mean.x, mean.y);
  }

  __device__ static void evaluate(const float4& terms, const float2& offsets, float x, float y,
                                  float (&exponents)[2], bool (&valid)[2]) {
    const float dx = x - offsets.x, mixed = terms.y * dx;
    const float rest = fmaf(-terms.x * dx, dx, terms.w);
#pragma unroll
    for (int p = 0; p < 2; ++p) {
      const float dy = y + float(p) * rows_between - offsets.y;
      exponents[p] = fmaf(-dy, fmaf(terms.z, dy, mixed), rest);
      valid[p] = exponents[p] <= terms.w;  // rounding may make s negative where it is nearly zero
    }
  }
};

}  // namespace kernels

void rasterize(Cuda& cuda, AxisShared<FloatSplit>, const RasterJob& job) {
  rasterize_warps<kernels::SplitForm, false>(cuda, "rasterize axis-shared-float-split", job);
}
void rasterize(Cuda& cuda, AxisSharedThreshold<FloatSplit>, const RasterJob& job) {
  rasterize_warps<kernels::SplitForm, true>(cuda, "rasterize axis-shared-threshold-float-split", job);
}

}  // namespace swiftgs
