// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_FACTORS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_FACTORS_INL
#undef SWIFTGS_CPU_FACTORS_INL
#else
#define SWIFTGS_CPU_FACTORS_INL
#endif

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include <swiftgs/frame/placing.hpp>
#include <swiftgs/frame/view_constants.hpp>
#include <swiftgs/project/project.hpp>

#include "doubles-inl.hpp"
#include "vec3-inl.hpp"

HWY_BEFORE_NAMESPACE();
// The formulas of lenses are compiled again, for vectors.
#undef SWIFTGS_LENS_NAMESPACE
#define SWIFTGS_LENS_NAMESPACE HWY_NAMESPACE
#include <swiftgs/lens/formulas.inc>

namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Half32 = hn::Half<F32>;
using Mask = hn::Mask<F32>;

/// A group of lanes in double: the lower half, then the upper.
struct Wide {
  Vec64 low, high;
};

HWY_INLINE Wide Promote(Vec v) {
  return {hn::PromoteTo(F64(), hn::LowerHalf(Half32(), v)), hn::PromoteTo(F64(), hn::UpperHalf(Half32(), v))};
}
HWY_INLINE Vec Demote(const Wide& v) {
  return hn::Combine(F32(), hn::DemoteTo(Half32(), v.high), hn::DemoteTo(Half32(), v.low));
}
HWY_INLINE Wide Minus(const Wide& a, const Wide& b) {
  return {hn::Sub(a.low, b.low), hn::Sub(a.high, b.high)};
}
HWY_INLINE Wide Minus(const Wide& a, double b) {
  const Vec64 all = hn::Set(F64(), b);
  return {hn::Sub(a.low, all), hn::Sub(a.high, all)};
}
HWY_INLINE Wide Dot(const Wide& x, const Wide& y, const Wide& z, const double* row) {
  const Vec64 rx = hn::Set(F64(), row[0]), ry = hn::Set(F64(), row[1]), rz = hn::Set(F64(), row[2]);
  return {hn::MulAdd(rx, x.low, hn::MulAdd(ry, y.low, hn::Mul(rz, z.low))),
          hn::MulAdd(rx, x.high, hn::MulAdd(ry, y.high, hn::Mul(rz, z.high)))};
}
HWY_INLINE Wide Times(const Wide& a, const Wide& b) {
  return {hn::Mul(a.low, b.low), hn::Mul(a.high, b.high)};
}
HWY_INLINE Wide Times(const Wide& a, double b) {
  const Vec64 all = hn::Set(F64(), b);
  return Times(a, Wide{all, all});
}
HWY_INLINE Wide Inverse(const Wide& a) {
  const Vec64 one = hn::Set(F64(), 1.0);
  return {hn::Div(one, a.low), hn::Div(one, a.high)};
}
HWY_INLINE Wide ScaleAdd(const Wide& a, double scale, double offset) {
  const Vec64 s = hn::Set(F64(), scale), o = hn::Set(F64(), offset);
  return {hn::MulAdd(a.low, s, o), hn::MulAdd(a.high, s, o)};
}

HWY_INLINE Vec3 LoadVec3(const vec3* HWY_RESTRICT v) {
  Vec3 out;
  hn::LoadInterleaved3(F32(), &v->x, out.x, out.y, out.z);
  return out;
}

/// Means from the camera's centre.
struct Wide3 {
  Wide x, y, z;
};
HWY_INLINE Wide3 FromCentre(const ViewConstants& v, const vec3* HWY_RESTRICT means) {
  const Vec3 mean = LoadVec3(means);
  const Wide dx = Minus(Promote(mean.x), v.centre[0]), dy = Minus(Promote(mean.y), v.centre[1]);
  return {dx, dy, Minus(Promote(mean.z), v.centre[2])};
}

// Half a group in double, as `LocalAxes`, `ImageAxes` and `factor` of project/project.hpp are of one
// Gaussian.
using Triple = TripleOf<Doubles>;

HWY_INLINE Doubles Dot(const Triple& a, const Triple& b) {
  return mul_add(a.x, b.x, mul_add(a.y, b.y, a.z * b.z));
}
HWY_INLINE Triple Cross(const Triple& a, const Triple& b) {
  return {mul_sub(a.y, b.z, a.z * b.y), mul_sub(a.z, b.x, a.x * b.z), mul_sub(a.x, b.y, a.y * b.x)};
}

struct Axes {
  Triple column[3];

  HWY_INLINE Axes(Doubles w, Doubles x, Doubles y, Doubles z) {
    const Doubles one(1.0), x2 = x + x, y2 = y + y, z2 = z + z, wx = w * x2, wy = w * y2, wz = w * z2;
    const Doubles without_y = neg_mul_add(y2, y, one), without_z = neg_mul_add(z2, z, one);
    column[0] = {neg_mul_add(y2, y, without_z), mul_add(x2, y, wz), mul_sub(x2, z, wy)};
    column[1] = {mul_sub(x2, y, wz), neg_mul_add(x2, x, without_z), mul_add(y2, z, wx)};
    column[2] = {mul_add(x2, z, wy), mul_sub(y2, z, wx), neg_mul_add(x2, x, without_y)};
  }
};

/// A row of J W: how a coordinate of a pixel grows with the world.
struct Row {
  Triple direction;
  Doubles pixels;  ///< times this

  /// The row times R S.
  HWY_INLINE Triple Along(const Triple& scale, const Axes& axes) const {
    return {pixels * scale.x * Dot(direction, axes.column[0]),
            pixels * scale.y * Dot(direction, axes.column[1]),
            pixels * scale.z * Dot(direction, axes.column[2])};
  }
};
/// Rows x and y of J W for half a group.
struct Rows {
  Row x, y;
};

struct Factor {
  Doubles l0, l1, l2, var_x, var_y;
  Doubles sharpness;  ///< if `sharpens`; otherwise only its numerator
  Doubles valid;      ///< 1 or 0

  Factor() = default;
  HWY_INLINE Factor(const Triple& x, const Triple& y, Doubles blur, bool sharpens) {
    const Doubles xx = Dot(x, x), yy = Dot(y, y), xy = Dot(x, y);
    var_x = xx + blur, var_y = yy + blur;
    const Doubles inv_sigma_y = inverse_sqrt(var_y), inv_var_y = inv_sigma_y * inv_sigma_y;
    const Triple c = Cross(x, y), narrow{c.x * inv_sigma_y, c.y * inv_sigma_y, c.z * inv_sigma_y};
    const Doubles sharp = Dot(narrow, narrow);
    const Doubles var_x_given_y = mul_add(blur, (xx + var_y) * inv_var_y, sharp);
    l0 = Doubles(to_base_2) * inverse_sqrt(var_x_given_y);
    l1 = -(l0 * (xy * inv_var_y)), l2 = Doubles(to_base_2) * inv_sigma_y;
    sharpness = sharpens ? sharp / var_x_given_y : sharp;
    const Doubles zero(0.0), largest{double(largest_variance)};
    valid = choose((var_x_given_y > zero) & (var_y > zero) & (var_x_given_y < Doubles(double(INFINITY))), 1.0,
                   zero);
    valid = choose(var_x > largest, zero, choose(var_y > largest, zero, valid));
  }
};

/// Consecutive Gaussians of a scene. `lanes` elements of each array may be read.
struct Group {
  const vec3* means;
  const vec3* scales;
  const Quaternion* rotations;
  const float* opacities;

  /// Lanes that `clip` shows.
  HWY_INLINE Mask Shown(const Clip& clip) const {
    const hn::RebindToUnsigned<F32> d;
    alignas(64) std::uint32_t shown[lanes];
    for (std::size_t k = 0; k < lanes; ++k) shown[k] = clip.shows(means[k]) ? ~0u : 0;
    return hn::RebindMask(F32(), hn::MaskFromVec(hn::Load(d, shown)));
  }
};

/// Factors of a group of Gaussians.
struct Factors {
  HWY_INLINE Factors(const ViewConstants& v, const Group& group, const Rows (&rows)[2]) {
    Vec w, x, y, z;
    hn::LoadInterleaved4(F32(), &group.rotations->w, w, x, y, z);
    const Wide ws = Promote(w), xs = Promote(x), ys = Promote(y), zs = Promote(z);
    const Vec3 scales = LoadVec3(group.scales);
    const Wide scale_x = Promote(scales.x), scale_y = Promote(scales.y), scale_z = Promote(scales.z);
    const auto factor = [&](const Rows& of, const Axes& axes, const Triple& scale) HWY_ATTR {
      return Factor(of.x.Along(scale, axes), of.y.Along(scale, axes), Doubles(double(v.blur)), v.antialiased);
    };
    lower_ = factor(rows[0], Axes(ws.low, xs.low, ys.low, zs.low), {scale_x.low, scale_y.low, scale_z.low});
    upper_ =
        factor(rows[1], Axes(ws.high, xs.high, ys.high, zs.high), {scale_x.high, scale_y.high, scale_z.high});
  }

  HWY_INLINE Vec operator()(Doubles Factor::*of) const { return Demote({(lower_.*of).v, (upper_.*of).v}); }

 private:
  Factor lower_, upper_;
};

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
