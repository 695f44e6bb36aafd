// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <utility>

#include <swiftgs/cpu/stages.hpp>
#include <swiftgs/placed_scene.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/project/project.hpp>

// Compile the rest of this file for every target; the order of these lines matters. The formulas of lenses
// are compiled again, for vectors.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "project.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
#include "doubles-inl.hpp"
#include "vec3-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
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

/// Consecutive Gaussians of a scene, `lanes` of which may be read.
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

/// Where a view sees the means of a group, and how it linearises there.
struct Seen {
  Vec x, y;              ///< of the mean
  Vec lacks_x, lacks_y;  ///< what these floats lack
  Vec low;               ///< bits, as in `SplatShape`
  Vec depth;
  Rows rows[2];  ///< of the lower half, and of the upper
  Mask shown;

  /// Vector version of `SplatShape::set_mean`.
  HWY_INLINE void place_mean(const Wide& wide_x, const Wide& wide_y) {
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

  out.place_mean(ScaleAdd(x_over_z, v.fx, v.cx), ScaleAdd(y_over_z, v.fy, v.cy));

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
  out.place_mean(wide(x_of_seen), wide(y_of_seen));
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

/// Projects Gaussians [begin, end) of a placed scene, at most a chunk of them, for its eye `v`.
template <bool through_lens>
void ProjectChunk(const ViewConstants& v, const StoredScene& placed, std::size_t begin, std::size_t end,
                  VisibleSplats& out) {
  const SceneView& scene = placed.scene;
  const std::uint32_t first = placed.first_gaussian;
  const bool as_they_lie = scene.means.is_dense() && scene.scales.is_dense() && scene.rotations.is_dense() &&
                           scene.opacities.is_dense() && !scene.any_rotations;
  std::size_t i = begin;
  for (; as_they_lie && i + lanes <= end; i += lanes)
    ProjectGroup<through_lens>(v, placed.clip,
                               {&scene.means[i], &scene.scales[i], &scene.rotations[i], &scene.opacities[i]},
                               first + std::uint32_t(i), out);

  // The scene's arrays end with it, and others have gaps: copy these to where a whole group can be read.
  // Lanes beyond the end are transparent.
  for (; i < end; i += lanes) {
    vec3 means[lanes], scales[lanes];
    Quaternion rotations[lanes];
    float opacities[lanes] = {};
    for (std::size_t k = 0; k < lanes; ++k) means[k] = scales[k] = vec3(0);
    for (std::size_t k = 0; k < std::min(lanes, end - i); ++k) {
      const Gaussian g = gaussian(scene, i + k);
      means[k] = g.mean, scales[k] = g.scale, rotations[k] = g.rotation, opacities[k] = g.opacity;
    }
    ProjectGroup<through_lens>(v, placed.clip, {means, scales, rotations, opacities},
                               first + std::uint32_t(i), out);
  }
}

/// Projects the Gaussians of chunks [begin, end) of the frame, and returns how many are visible.
std::size_t ProjectTask(const ViewConstants& camera, const SeveralScenes& scenes, std::size_t begin,
                        std::size_t end, SplatShape* shapes, float* depths, std::uint32_t* ids) {
  VisibleSplats out{shapes, depths, ids};
  const auto project_chunk = camera.through_lens ? ProjectChunk<true> : ProjectChunk<false>;
  while (begin < end) {
    const StoredScene& placed = scenes.of_chunk(std::uint32_t(begin));
    const SceneView& scene = placed.scene;
    const ViewConstants v = eye(camera, placed);
    const ChunkCuller culler(v);
    const std::size_t until = std::min(end, std::size_t(placed.first_chunk) + placed.chunks());
    for (; begin < until; ++begin) {
      const std::size_t chunk = begin - placed.first_chunk, i = chunk * chunk_size;
      if (scene.chunks.empty() || !culler.hides(scene.chunks[chunk]))
        project_chunk(v, placed, i, std::min(i + chunk_size, scene.size()), out);
    }
  }
  return out.count;
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {

HWY_EXPORT(ProjectTask);

/// Chunks that one task projects; fixed, so that the order of the splats does not depend on the threads.
constexpr std::size_t task_chunks = 32;

constexpr std::size_t task_count(std::size_t chunks) { return (chunks + task_chunks - 1) / task_chunks; }

/// Appends the splats of one view, if they fit.
void project_view(Cpu& cpu, const FramePlan& plan, std::size_t view, ProjectScratch<Cpu>& scratch,
                  Splats<Cpu>& splats) {
  const Views& views = plan.views;
  const std::size_t capacity = plan.limits.capacity.splats;
  const ViewConstants& camera = views.each[view].camera;
  const SeveralScenes scenes{plan.scenes.reachable(), std::uint32_t(plan.scenes.size())};
  const ChunkRange chunks = plan.scenes.chunks_of(views[view]);
  // Each task projects to a place of its own.
  const std::size_t n = chunks.size() * chunk_size, tasks = task_count(chunks.size());
  scratch.shapes.reset(n), scratch.depths.reset(n), scratch.gaussians.reset(n), scratch.counts.reset(tasks);
  cpu.for_parts(tasks, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t task = first; task < last; ++task) {
      const std::size_t begin = chunks.begin + task * task_chunks, at = task * task_chunks * chunk_size;
      scratch.counts.data()[task] = HWY_DYNAMIC_DISPATCH(ProjectTask)(
          camera, scenes, begin, std::min(begin + task_chunks, chunks.end), scratch.shapes.data() + at,
          scratch.depths.data() + at, scratch.gaussians.data() + at);
    }
  });

  // Move their splats together.
  std::size_t* offsets = scratch.counts.data();
  std::size_t end_of_view = splats.count;
  for (std::size_t task = 0; task < tasks; ++task) end_of_view += std::exchange(offsets[task], end_of_view);
  splats.visible += end_of_view - splats.count;
  if (capacity != 0 && splats.visible > capacity) return;
  splats.resize(end_of_view, views.size());
  cpu.for_parts(tasks, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t task = first; task < last; ++task) {
      const std::size_t begin = task * task_chunks * chunk_size, to = offsets[task];
      const std::size_t count = (task + 1 < tasks ? offsets[task + 1] : end_of_view) - to;
      std::copy_n(scratch.shapes.data() + begin, count, splats.shapes.data() + to);
      std::copy_n(scratch.depths.data() + begin, count, splats.depths.data() + to);
      std::copy_n(scratch.gaussians.data() + begin, count, splats.gaussians.data() + to);
      if (views.size() > 1) std::fill_n(splats.of_view.data() + to, count, std::uint16_t(view));
    }
  });
  splats.count = end_of_view;
}

}  // namespace

void ProjectScratch<Cpu>::reserve(Cpu&, const Reservation& reserved) {
  const std::size_t n = reserved.chunks * chunk_size;
  shapes.reset_exactly(n), depths.reset_exactly(n), gaussians.reset_exactly(n);
  counts.reset_exactly(task_count(reserved.chunks));
}

void project(Cpu& cpu, const FramePlan& plan, ProjectScratch<Cpu>& scratch, Splats<Cpu>& splats) {
  splats.count = splats.visible = 0;
  for (std::size_t view = 0; view < plan.views.size(); ++view) project_view(cpu, plan, view, scratch, splats);
}

}  // namespace swiftgs
#endif
