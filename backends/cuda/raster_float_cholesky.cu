// SPDX-License-Identifier: Apache-2.0
#include "raster_warps.cuh"

namespace swiftgs {
namespace kernels {

/// `FloatCholesky` in registers: u = l0 x + l1 y + c and v = l2 y + d at pixel (x, y) of the part, s = u^2 + v^2. Two
/// rows further down u and v grow by what depends on the row alone.
struct CholeskyForm {
  __device__ static void prepare(const SplatShape& s, vec2 mean, float log2_alpha_min, float4& terms,
                                 float2& offsets) {
    terms = make_float4(s.l0, s.l1, s.l2, s.reach + log2_alpha_min);
    offsets = make_float2(-fmaf(s.l0, mean.x, s.l1 * mean.y), -s.l2 * mean.y);
  }

  __device__ static void evaluate(const float4& terms, const float2& offsets, float x, float y,
                                  float (&exponents)[2], bool (&valid)[2]) {
    const float u = fmaf(terms.x, x, fmaf(terms.y, y, offsets.x)), v = fmaf(terms.z, y, offsets.y);
    const float lower_u = fmaf(terms.y, rows_between, u);
    const float lower_v = fmaf(terms.z, rows_between, v);
    exponents[0] = fmaf(-u, u, fmaf(-v, v, terms.w));
    exponents[1] = fmaf(-lower_u, lower_u, fmaf(-lower_v, lower_v, terms.w));
    valid[0] = valid[1] = true;  // a sum of squares is never negative
  }
};

}  // namespace kernels

void rasterize(Cuda& cuda, AxisShared<FloatCholesky>, const RasterJob& job) {
  rasterize_warps<kernels::CholeskyForm, false>(cuda, "rasterize axis-shared-float-cholesky", job);
}
void rasterize(Cuda& cuda, AxisSharedThreshold<FloatCholesky>, const RasterJob& job) {
  rasterize_warps<kernels::CholeskyForm, true>(cuda, "rasterize axis-shared-threshold-float-cholesky", job);
}

}  // namespace swiftgs
