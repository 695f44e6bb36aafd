// SPDX-License-Identifier: Apache-2.0
// Compiled once a vector target: no #pragma once, but a guard that toggles.
#if defined(SWIFTGS_CPU_PROJECT_GROUP_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SWIFTGS_CPU_PROJECT_GROUP_INL
#undef SWIFTGS_CPU_PROJECT_GROUP_INL
#else
#define SWIFTGS_CPU_PROJECT_GROUP_INL
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include <swiftgs/frame/placing.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/view_constants.hpp>

#include "factors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Where a view sees the means of a group, and how it linearises there.
struct Seen {
  Vec x, y;              ///< of the mean
  Vec lacks_x, lacks_y;  ///< what these floats lack
  Vec low;               ///< bits, as in `SplatShape`
  Vec depth;
  Rows rows[2];  ///< of the lower half, and of the upper
  Mask shown;

  /// Vector version of `SplatShape::set_mean`.
  HWY_INLINE void project_mean(const Wide& wide_x, const Wide& wide_y) {
    const F32 d;
    const auto round_down = [&](const Wide& wide, Vec& mean, Vec& lacks) HWY_ATTR {
      const hn::RebindToSigned<F32> di;
      const Vec near = Demote(wide);
      const Vec above = Demote(Minus(wide, Promote(near)));
      const auto too_large = hn::RebindMask(di, hn::Lt(above, hn::Zero(d)));
      const auto step =
          hn::IfThenElse(hn::RebindMask(di, hn::Gt(near, hn::Zero(d))), hn::Set(di, -1), hn::Set(di, 1));
      mean = hn::BitCast(d, hn::Add(hn::BitCast(di, near), hn::IfThenElseZero(too_large, step)));
      lacks = hn::Add(above, hn::Sub(near, mean));
      const Vec units = hn::Mul(lacks, hn::Set(d, 1 / SplatShape::low_unit));
      return hn::NearestInt(hn::Min(units, hn::Set(d, float(0xffff))));
    };
    const auto of_x = round_down(wide_x, x, lacks_x), of_y = round_down(wide_y, y, lacks_y);
    low = hn::BitCast(d, hn::Or(of_x, hn::ShiftLeft<16>(of_y)));
  }
};

/// Sees the lanes of `visible`; false if none is shown.
HWY_INLINE bool SeeThroughPinhole(const ViewConstants& v, const Group& group, Mask visible, Seen& out) {
  const F32 d;
  // Move to camera space in double, and cull by depth before anything else is read.
  const auto [dx, dy, dz] = FromCentre(v, group.means);
  const Wide wide_z = Dot(dx, dy, dz, v.rotation[2]);
  const Vec z = out.depth = Demote(Times(wide_z, v.depth_scale));
  out.shown =
      hn::And(visible, hn::And(hn::Gt(z, hn::Set(d, v.near_plane)), hn::Le(z, hn::Set(d, v.far_plane))));
  if (hn::AllFalse(d, out.shown)) return false;
  const Wide inverse_z = Inverse(wide_z);
  const Wide x_over_z = Times(Dot(dx, dy, dz, v.rotation[0]), inverse_z);
  const Wide y_over_z = Times(Dot(dx, dy, dz, v.rotation[1]), inverse_z);

  out.project_mean(ScaleAdd(x_over_z, v.fx, v.cx), ScaleAdd(y_over_z, v.fy, v.cy));

  // Linearise within the limits of the conventions.
  const auto row = [&](int k, Doubles tangent, Doubles pixels) HWY_ATTR {
    const auto component = [&](int c) HWY_ATTR {
      return neg_mul_add(tangent, Doubles(v.rotation[2][c]), Doubles(v.rotation[k][c]));
    };
    return Row{{component(0), component(1), component(2)}, pixels};
  };
  const auto rows = [&](Doubles tangent_x, Doubles tangent_y, Doubles over_z) HWY_ATTR {
    return Rows{row(0, clamped(tangent_x, Doubles(v.limits.least_u), Doubles(v.limits.most_u)),
                    Doubles(v.fx) * over_z),
                row(1, clamped(tangent_y, Doubles(v.limits.least_v), Doubles(v.limits.most_v)),
                    Doubles(v.fy) * over_z)};
  };
  out.rows[0] = rows(x_over_z.low, y_over_z.low, inverse_z.low);
  out.rows[1] = rows(x_over_z.high, y_over_z.high, inverse_z.high);
  return true;
}

/// Turns derivatives by camera space into derivatives by the world.
HWY_INLINE Row ByWorld(const ViewConstants& v, const Doubles* by, double pixels) {
  const auto component = [&](int k) HWY_ATTR {
    return mul_add(by[0], Doubles(v.rotation[0][k]),
                   mul_add(by[1], Doubles(v.rotation[1][k]), by[2] * Doubles(v.rotation[2][k])));
  };
  return {{component(0), component(1), component(2)}, pixels};
}

/// Half a group of points seen through a lens, as numbers: x and y in pixels, the slopes of `LensPoint`, and
/// above 0 where it is shown.
constexpr std::size_t x_of_seen = 0, y_of_seen = 1, du_of_seen = 2, dv_of_seen = 5, shown_of_seen = 8;
using SeenNumbers = Doubles[9];

/// Not inlined: compilers take minutes for it twice.
HWY_NOINLINE void LookThroughLens(const ViewConstants& v, const TripleOf<Doubles>& p, SeenNumbers& out) {
  const SeenOf<Doubles> seen = seen_through(v.lens, v.limits, p);
  Doubles x = mul_add(Doubles(v.fx), seen.u, Doubles(v.cx));
  if (v.turn != 0)
    x = x - v.turn * rounded((x - v.panorama_middle) / v.turn);  // `ViewConstants::nearest_copy`
  out[x_of_seen] = x, out[y_of_seen] = mul_add(Doubles(v.fy), seen.v, Doubles(v.cy));
  out[du_of_seen] = seen.du.x, out[du_of_seen + 1] = seen.du.y, out[du_of_seen + 2] = seen.du.z;
  out[dv_of_seen] = seen.dv.x, out[dv_of_seen + 1] = seen.dv.y, out[dv_of_seen + 2] = seen.dv.z;
  out[shown_of_seen] = choose(seen.inside, Doubles(1.0), Doubles(0.0));
}

/// As `SeeThroughPinhole`.
HWY_INLINE bool SeeThroughLens(const ViewConstants& v, const Group& group, Mask visible, Seen& out) {
  const F32 d;
  const auto [dx, dy, dz] = FromCentre(v, group.means);
  const Wide x = Dot(dx, dy, dz, v.rotation[0]), y = Dot(dx, dy, dz, v.rotation[1]);
  const Wide z = Dot(dx, dy, dz, v.rotation[2]);
  const TripleOf<Doubles> low{x.low, y.low, z.low}, high{x.high, y.high, z.high};
  const auto distance = [](const TripleOf<Doubles>& p)
                            HWY_ATTR { return square_root(p.x * p.x + p.y * p.y + p.z * p.z).v; };
  out.depth = Demote(Times(v.depth_is_distance ? Wide{distance(low), distance(high)} : z, v.depth_scale));
  out.shown = hn::And(visible, hn::And(hn::Gt(out.depth, hn::Set(d, v.near_plane)),
                                       hn::Le(out.depth, hn::Set(d, v.far_plane))));
  if (hn::AllFalse(d, out.shown)) return false;
  if (v.order_is_distance) out.depth = Demote(Times(Wide{distance(low), distance(high)}, v.depth_scale));

  SeenNumbers lower, upper;
  LookThroughLens(v, low, lower), LookThroughLens(v, high, upper);
  const auto wide = [&](std::size_t i) HWY_ATTR { return Wide{lower[i].v, upper[i].v}; };
  const auto number = [&](std::size_t i) HWY_ATTR { return Demote(wide(i)); };
  out.project_mean(wide(x_of_seen), wide(y_of_seen));
  out.rows[0] = {ByWorld(v, lower + du_of_seen, v.fx), ByWorld(v, lower + dv_of_seen, v.fy)};
  out.rows[1] = {ByWorld(v, upper + du_of_seen, v.fx), ByWorld(v, upper + dv_of_seen, v.fy)};
  out.shown = hn::And(out.shown, hn::Gt(number(shown_of_seen), hn::Zero(d)));
  return !hn::AllFalse(d, out.shown);
}

/// Visible splats of a task, in the order of their Gaussians.
struct VisibleSplats {
  SplatShape* shapes;
  float* depths;
  std::uint32_t* ids;
  std::size_t count = 0;
};

/// Vector version of `project_shape`, and of the compaction after it.
template <bool through_lens>
HWY_INLINE void ProjectGroup(const ViewConstants& v, const Clip& clip, const Group& group,
                             std::uint32_t first_id, VisibleSplats& out) {
  const F32 d;
  Vec opacity = hn::Mul(hn::LoadU(d, group.opacities), hn::Set(d, v.opacity));
  const Vec alpha_min = hn::Set(d, v.alpha_min);
  const Vec most = hn::Set(d, 3.4028234663852886e38f);
  Mask visible = hn::And(hn::Ge(opacity, alpha_min), hn::Le(opacity, most));
  if (!clip.shows_all()) visible = hn::And(visible, group.Shown(clip));
  Seen seen;
  if (!(through_lens ? SeeThroughLens(v, group, visible, seen) : SeeThroughPinhole(v, group, visible, seen)))
    return;
  visible = seen.shown;

  const Factors factors(v, group, seen.rows);
  const Vec l0 = factors(&Factor::l0), l1 = factors(&Factor::l1), l2 = factors(&Factor::l2);
  visible = hn::And(visible, hn::Gt(factors(&Factor::valid), hn::Zero(d)));
  visible = hn::And(visible, hn::And(hn::Le(l0, most), hn::And(hn::Le(hn::Abs(l1), most), hn::Le(l2, most))));

  if (v.antialiased) {
    const Vec ratio = hn::Max(factors(&Factor::sharpness), hn::Set(d, v.min_compensation));
    opacity = hn::Mul(opacity, hn::Sqrt(ratio));
    visible = hn::And(visible, hn::Ge(opacity, alpha_min));
  }

  const Vec cutoff = hn::Max(hn::CallLog2(d, hn::Div(opacity, alpha_min)), hn::Zero(d));
  const Vec extent = hn::Mul(hn::Sqrt(cutoff), hn::Set(d, float(1 / to_base_2)));
  const Vec half_width = hn::Mul(extent, hn::Sqrt(factors(&Factor::var_x)));
  const Vec half_height = hn::Mul(extent, hn::Sqrt(factors(&Factor::var_y)));
  const auto reaches = [&](Vec x, Vec y, float left, float top, float right, float bottom) HWY_ATTR {
    return hn::And(hn::And(hn::Ge(hn::Add(seen.x, x), hn::Set(d, left + 0.5f)),
                           hn::Ge(hn::Add(seen.y, y), hn::Set(d, top + 0.5f))),
                   hn::And(hn::Le(hn::Sub(seen.x, x), hn::Set(d, right - 0.5f)),
                           hn::Le(hn::Sub(seen.y, y), hn::Set(d, bottom - 0.5f))));
  };
  const auto spans = [&](Vec mean, Vec lacks, Vec half, float pixels) HWY_ATTR {
    const Vec to_first = hn::Sub(hn::Sub(hn::Set(d, 0.5f), mean), lacks);
    const Vec to_last = hn::Sub(hn::Sub(hn::Set(d, pixels - 0.5f), mean), lacks);
    return hn::And(hn::Le(to_first, half), hn::Le(hn::Neg(to_last), half));
  };
  visible = hn::And(visible, hn::And(spans(seen.x, seen.lacks_x, half_width, v.width),
                                     spans(seen.y, seen.lacks_y, half_height, v.height)));
  const Vec slack =  // `part_slack`
      hn::Add(hn::Set(d, 2e-2f), hn::Mul(hn::Set(d, 2e-4f), hn::Add(half_width, half_height)));
  visible = hn::And(visible, reaches(hn::Add(half_width, slack), hn::Add(half_height, slack), v.left, v.top,
                                     v.right, v.bottom));
  if (hn::AllFalse(d, visible)) return;

  // Move visible lanes to the front, and from arrays of members to an array of structures.
  alignas(64) float front[lanes * 4], back[lanes * 4];
  const auto pack = [&](Vec value) HWY_ATTR { return hn::Compress(value, visible); };
  hn::StoreInterleaved4(pack(seen.x), pack(seen.y), pack(l0), pack(l1), d, front);
  hn::StoreInterleaved4(pack(l2), pack(opacity), pack(cutoff), pack(seen.low), d, back);
  const hn::RebindToUnsigned<F32> du;
  hn::StoreU(pack(seen.depth), d, out.depths + out.count);
  hn::StoreU(hn::Compress(hn::Iota(du, first_id), hn::RebindMask(du, visible)), du, out.ids + out.count);
  const std::size_t count = hn::CountTrue(d, visible);
  for (std::size_t i = 0; i < count; ++i) {
    float* shape = reinterpret_cast<float*>(out.shapes + out.count + i);
    std::memcpy(shape, front + 4 * i, 4 * sizeof(float));
    std::memcpy(shape + 4, back + 4 * i, 4 * sizeof(float));
  }
  out.count += count;
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
