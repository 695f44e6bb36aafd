// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <swiftgs/cpu/stages.hpp>

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shade.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/cache_control.h>
#include "vec3-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// Bands 1 to `degree` in directions `d`: element k is the basis function with index k + 1.
HWY_INLINE void ShBasis(int degree, const Vec3& v, float (*HWY_RESTRICT basis)[lanes]) {
  const F32 d;
  const auto put = [&](int k, double constant, Vec value)
                       HWY_ATTR { hn::StoreU(hn::Mul(hn::Set(d, float(constant)), value), d, basis[k]); };
  put(0, -sh::c1, v.y), put(1, sh::c1, v.z), put(2, -sh::c1, v.x);
  if (degree < 2) return;
  const Vec xx = hn::Mul(v.x, v.x), yy = hn::Mul(v.y, v.y), zz = hn::Mul(v.z, v.z), xy = hn::Mul(v.x, v.y);
  const Vec two = hn::Set(d, 2.0f), three = hn::Set(d, 3.0f), four = hn::Set(d, 4.0f);
  const Vec xx_plus_yy = hn::Add(xx, yy), xx_minus_yy = hn::Sub(xx, yy);
  put(3, sh::c20, xy);
  put(4, sh::c21, hn::Mul(v.y, v.z));
  put(5, sh::c22, hn::MulSub(two, zz, xx_plus_yy));
  put(6, sh::c23, hn::Mul(v.x, v.z));
  put(7, sh::c24, xx_minus_yy);
  if (degree < 3) return;
  const Vec four_zz_rest = hn::MulSub(four, zz, xx_plus_yy);
  put(8, sh::c30, hn::Mul(v.y, hn::MulSub(three, xx, yy)));
  put(9, sh::c31, hn::Mul(xy, v.z));
  put(10, sh::c32, hn::Mul(v.y, four_zz_rest));
  put(11, sh::c33, hn::Mul(v.z, hn::NegMulAdd(three, xx_plus_yy, hn::Add(zz, zz))));
  put(12, sh::c34, hn::Mul(v.x, four_zz_rest));
  put(13, sh::c35, hn::Mul(v.z, xx_minus_yy));
  put(14, sh::c36, hn::Mul(v.x, hn::NegMulAdd(three, yy, xx)));
}

using F32x4 = hn::CappedTag<float, 4>;

/// Four coefficients of a row.
HWY_INLINE hn::Vec<F32x4> LoadFour(const float* HWY_RESTRICT from, float) { return hn::LoadU(F32x4(), from); }
HWY_INLINE hn::Vec<F32x4> LoadFour(const hwy::float16_t* HWY_RESTRICT from, float) {
  return hn::PromoteTo(F32x4(), hn::LoadU(hn::Rebind<hwy::float16_t, F32x4>(), from));
}
HWY_INLINE hn::Vec<F32x4> LoadFour(const std::int8_t* HWY_RESTRICT from, float scale) {
  const hn::Rebind<std::int32_t, F32x4> integers;
  const auto bytes = hn::LoadU(hn::Rebind<std::int8_t, F32x4>(), from);
  return hn::Mul(hn::ConvertTo(F32x4(), hn::PromoteTo(integers, bytes)), hn::Set(F32x4(), scale));
}

/// Sum of the coefficients of one Gaussian, RGB in the first three lanes, weighted with lane k of the basis.
template <class Value>
HWY_INLINE hn::Vec<F32x4> SumBands(const HarmonicRow& row, const float (*HWY_RESTRICT basis)[lanes],
                                   std::size_t k, int coefficients) {
  const F32x4 d;
  const Value* const HWY_RESTRICT rest = static_cast<const Value*>(row.values);
  auto even = hn::Zero(d), odd = hn::Zero(d);
  // A load takes four numbers: a coefficient's three and the next one's first. The last coefficient has no
  // next one, so its load begins a number earlier.
  int j = 0;
  for (; j + 2 < coefficients; j += 2) {
    even = hn::MulAdd(hn::Set(d, basis[j][k]), LoadFour(rest + 3 * j, row.scale), even);
    odd = hn::MulAdd(hn::Set(d, basis[j + 1][k]), LoadFour(rest + 3 * j + 3, row.scale), odd);
  }
  if (j + 1 < coefficients) {
    odd = hn::MulAdd(hn::Set(d, basis[j][k]), LoadFour(rest + 3 * j, row.scale), odd);
    ++j;
  }
  if (j < coefficients)
    even = hn::MulAdd(hn::Set(d, basis[j][k]), hn::Shuffle0321(LoadFour(rest + 3 * j - 1, row.scale)), even);
  return hn::Add(even, odd);
}

HWY_INLINE hn::Vec<F32x4> SumBands(const HarmonicRow& row, const float (*HWY_RESTRICT basis)[lanes],
                                   std::size_t k, int coefficients) {
  switch (row.format) {
    case HarmonicFormat::halves:
      return SumBands<hwy::float16_t>(row, basis, k, coefficients);
    case HarmonicFormat::bytes:
      return SumBands<std::int8_t>(row, basis, k, coefficients);
    default:
      return SumBands<float>(row, basis, k, coefficients);
  }
}

/// Colours of `count` Gaussians of a scene, whose ids less `first_id` are their places in it. The basis is
/// evaluated for one Gaussian per lane. The sum over coefficients takes one Gaussian at a time, because only
/// its own coefficients lie together. Returns whether any splat is colourless.
bool ShadeRange(const ViewConstants& v, const SceneView& scene, const Tint& tint, std::uint32_t first_id,
                const std::uint32_t* HWY_RESTRICT ids, const float* HWY_RESTRICT depths, std::size_t count,
                SplatColour* HWY_RESTRICT colours) {
  const F32 d;
  bool some_colourless = false;
  const int degree = scene.sh_degree, coefficients = sh_rest_count(degree);
  const std::size_t row_bytes = 3 * std::size_t(coefficients) * size_of(scene.sh_rest.format);
  // 64 and 128 take as long: memory has no more to give.
  constexpr std::size_t ahead = 24;  // splats between asking for harmonics and using them
  alignas(64) float basis[sh_rest_count(max_sh_degree)][lanes];
  for (std::size_t first = 0; first < count; first += lanes) {
    const std::size_t here = std::min(lanes, count - first);
    if (degree > 0) {
      alignas(64) float x[lanes] = {}, y[lanes] = {}, z[lanes] = {};
      for (std::size_t k = 0; k < here; ++k) {
        const vec3 mean = scene.means[ids[first + k] - first_id];
        x[k] = float(mean.x - v.centre[0]), y[k] = float(mean.y - v.centre[1]),
        z[k] = float(mean.z - v.centre[2]);
      }
      // The largest component is scaled to 1, so that no square leaves the range of float.
      Vec3 direction{hn::Load(d, x), hn::Load(d, y), hn::Load(d, z)};
      const Vec largest = hn::Max(hn::Max(hn::Abs(direction.x), hn::Abs(direction.y)), hn::Abs(direction.z));
      direction = {hn::Div(direction.x, largest), hn::Div(direction.y, largest),
                   hn::Div(direction.z, largest)};
      const Vec squared = Dot(direction, direction);
      ShBasis(degree, Scale(direction, hn::Div(hn::Set(d, 1.0f), hn::Sqrt(squared))), basis);
    }
    for (std::size_t k = 0; k < here; ++k) {
      const std::size_t id = ids[first + k] - first_id;
      if (first + k + ahead < count) {
        const std::size_t next = ids[first + k + ahead] - first_id;
        hwy::Prefetch(&scene.sh0[next]);
        const unsigned char* const next_row = scene.sh_rest.row(scene.sh_rest.row_of(next));
        for (std::size_t i = 0; i < row_bytes; i += 64) hwy::Prefetch(next_row + i);
        if (row_bytes > 0) hwy::Prefetch(next_row + row_bytes - 1);
      }
      const vec3 sh0 = sh0_of(scene, id);
      float rgb[4];
      hn::StoreU(SumBands(scene.sh_rest[id], basis, k, coefficients), F32x4(), rgb);
      const auto channel = [&](int c) { return 0.5f + float(sh::c0) * sh0[c] + rgb[c]; };
      const vec3 colour(channel(0), channel(1), channel(2));
      const float depth = drawn_depth(v, scene, id, depths[first + k]);
      SplatColour splat = splat_colour(colour, depth);
      if (is_colourless(splat)) {
        splat = large_splat_colour(v, scene, id, depth);
        some_colourless = some_colourless || is_colourless(splat);
      }
      colours[first + k] = tinted(splat, tint);
    }
  }
  return some_colourless;
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(ShadeRange);
}

Shading<Cpu> shade(Cpu& cpu, const FramePlan& plan, const Splats<Cpu>& splats, Colours<Cpu>& colours) {
  constexpr std::size_t grain = 1024;
  colours.each.reset(splats.count), colours.colourless.reset(1);
  std::uint32_t* const colourless = colours.colourless.data();
  *colourless = 0;
  const SeveralScenes scenes{plan.scenes.reachable(), std::uint32_t(plan.scenes.size())};
  const std::uint32_t* const ids = splats.gaussians.data();
  for_parts_of_views(cpu, splats.view(), grain, [&](std::size_t view, std::size_t begin, std::size_t end) {
    // Splats of a view follow the order of the placed scenes.
    for (std::size_t until; begin < end; begin = until) {
      const StoredScene& placed = scenes.of_gaussian(ids[begin]);
      const std::uint32_t first = placed.first_gaussian;
      const std::size_t behind = std::size_t(first) + placed.size();
      until = std::size_t(std::lower_bound(ids + begin, ids + end, behind) - ids);
      if (HWY_DYNAMIC_DISPATCH(ShadeRange)(eye(plan.views[view].camera, placed), placed.scene, placed.tint,
                                           first, ids + begin, splats.depths.data() + begin, until - begin,
                                           colours.each.data() + begin))
        std::atomic_ref(*colourless).store(1, std::memory_order_relaxed);
    }
  });
  return Shading<Cpu>({{colours.each.data(), splats.count}, colourless});
}

}  // namespace swiftgs
#endif
