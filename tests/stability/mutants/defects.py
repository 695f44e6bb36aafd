# SPDX-License-Identifier: Apache-2.0
"""Defects of projection and blending that the stability tests must notice, as run.py injects them.

A change is written as git shows a word that differs: the text `a [-old-]{+new+} b`, without `{+new+}`, stands in the
file once; what replaces it is without `[-old-]`.
"""
import re
from dataclasses import dataclass

I = "include/swiftgs/"
CPU = "backends/cpu/"
CHOLESKY = ("raster_float_cholesky.cpp",)
SPLIT = ("raster_float_split.cpp",)
PER_PIXEL = ("raster_per_pixel.cpp",)
PROJECT = ("project.cpp",)
RASTERS = CHOLESKY + SPLIT + PER_PIXEL + ("raster_half_split.cpp",)  # share functions, of which the linker takes one


@dataclass(frozen=True)
class Defect:
    name: str
    file: str  # of the cpu backend where it lies in backends/cpu, else of the serial one
    sources: tuple  # of the cpu backend that are compiled with the defect
    changes: tuple  # pairs of an old text and a new one
    equivalent: str = ""  # why nothing can show the defect: the tests must then pass


def old_and_new(change):
    old, new = r"\[-(.*?)-\]", r"\{\+(.*?)\+\}"
    return tuple(re.sub(kept, r"\1", re.sub(left_out, "", change, flags=re.DOTALL), flags=re.DOTALL)
                 for kept, left_out in ((old, new), (new, old)))


def defects(subject, where, *rows):
    """Defects of a subject in a file, or in a header and the sources that include it. Each row has what is wrong, its
    change or several, and possibly why nothing can show it."""
    file, sources = (where, (where.split("/")[-1],)) if isinstance(where, str) else where
    for wrong, changes, *equivalent in rows:
        changes = (changes,) if isinstance(changes, str) else changes
        yield Defect(f"{subject}: {wrong}", file, sources, tuple(map(old_and_new, changes)), *equivalent)


def means(parts):
    """Means of splats on a grid of `parts` a pixel."""
    x, y = (f"std::round(s.mean.{axis} * {parts}) / {parts}" for axis in "xy")
    return f"means on 1/{parts} pixel", f"s.{{+mean = vec2({x}, {y}), s.low = 0;\n  s.+}}l0 = f.l0,"


def cpu_means(parts):
    def grid(of, focal, point):
        return (f"Promote(hn::Mul(hn::Round(hn::Mul(Demote(ScaleAdd({of}, v.{focal}, v.{point})), "
                f"hn::Set(d, {parts}.0f))), hn::Set(d, 1.0f / {parts})))")

    return (f"means on 1/{parts} pixel",
            "out.project_mean([-ScaleAdd(x_over_z, v.fx, v.cx), ScaleAdd(y_over_z, v.fy, v.cy)-]"
            f"{{+{grid('x_over_z', 'fx', 'cx')}, {grid('y_over_z', 'fy', 'cy')}+}});")


DEFECTS = [
    # Projection.
    *defects("project", I + "frame/splats.hpp",
        ("means without their remainder",
         "low = [-round_down(x, mean.x), low |= round_down(y, mean.y) << 16-]"
         "{+(round_down(x, mean.x), round_down(y, mean.y), 0)+};")),
    *defects("project", I + "project/project.hpp",
        ("camera space in float",
         "p[row] = [-multiply_add(v.rotation(row, 0), d[0],\n"
         "                            multiply_add(v.rotation(row, 1), d[1], v.rotation(row, 2) * d[2]))-]"
         "{+float(std::fma(float(v.rotation(row, 0)), float(d[0]), std::fma(float(v.rotation(row, 1)), float(d[1]), "
         "float(v.rotation(row, 2)) * float(d[2]))))+};"),
        ("camera space rounded to float after the rotation",
         "inverse([-p[2]), x_over_z = p[0] * inverse_z, y_over_z = p[1]-]{+float(p[2])), x_over_z = float(p[0]) * "
         "inverse_z, y_over_z = float(p[1])+} * inverse_z;"),
        ("camera's centre in float", "{mean.x - [-v.centre(0)-]{+float(v.centre(0))+},"),
        ("depth by a float sum",
         "const [-float z = float(constants.depth_scale() * p[2])-]{+vec3 from_camera(float(g.mean.x - v.centre[0]), "
         "float(g.mean.y - v.centre[1]),\n"
         "                       float(g.mean.z - v.centre[2]));\n"
         "  const float z = dot(vec3(v.axes[2][0], v.axes[2][1], v.axes[2][2]), from_camera)+};"),
        means(4096), means(1024),
        ("projection rounded to float",
         "Linearisation<double> at{v.clamped_x([-x_over_z-]{+double(float(x_over_z))+})"),
        ("needles by the camera's axes in float", "if constexpr ([-std::is_same_v<Real, float>-]{+true+})"),
        ("determinant as a difference",
         "const Real sharp = [-dot(narrow, narrow)-]{+xx * yy * inv_var_y - xy * xy * inv_var_y+};"),
        ("to_base_2 off by 1e-6", "to_base_2 = 0.84932180028801904272{+ + 1e-6+}"),
        ("cutoff by natural logarithm times log2_e",
         "std::[-log2(opacity / v.alpha_min)-]{+log(opacity / v.alpha_min) * float(log2_e)+}",
         "two roundings in place of one: as good as float can be"),
        ("cutoff by natural logarithm and a rounded log2_e",
         "std::[-log2(opacity / v.alpha_min)-]{+log(opacity / v.alpha_min) * 1.4427f+}"),
        ("cutoff off by 1e-6 of log2_e",
         "std::[-log2(opacity / v.alpha_min)-]{+log(opacity / v.alpha_min) * 1.442696f+}"),
        ("cutoff by natural logarithm", "std::[-log2-]{+log+}(opacity / v.alpha_min)"),
        ("min_compensation ignored",
         "std::sqrt(f.sharpness[- > v.min_compensation ? f.sharpness : v.min_compensation-])"),
        ("compensation without the root",
         "[-std::sqrt-](f.sharpness > v.min_compensation ? f.sharpness : v.min_compensation)"),
        ("opacities that are not finite are drawn",
         "opacity >= v.alpha_min[- && opacity < INFINITY-]"),
        ("a NaN of opacity is drawn",
         "[-opacity >= v.alpha_min && opacity < INFINITY-]{+!(opacity < v.alpha_min || opacity == INFINITY)+}",
         "half the width is not a number then, and the splat not visible"),
        ("an opacity of alpha_min is left out", "opacity >[-=-] v.alpha_min && opacity < INFINITY"),
        ("visible by its mean alone", "to_first.x <= [-half_width-]{+0+} &&"),
        ("far plane left out", "z > v.near_plane[- && z <= v.far_plane-]"),
        ("z on the far plane left out", "z <[-=-] v.far_plane"),
        ("planes compare in double",
         "if (!([-z > v.near_plane && z <= v.far_plane-]{+p[2] > double(v.near_plane) && p[2] <= "
         "double(v.far_plane)+})) return {};")),
    *defects("project", I + "project/colour.hpp",
        ("view_direction without scaling", "[-for (int k = 0; k < 3; ++k) d[k] /= largest;-]")),
    # Blending.
    *defects("raster", I + "frame/raster.hpp",
        ("row_touched compares with <", "nearest * nearest + v * v <[-=-] shape.cutoff"),
        ("T (1 - alpha)", "transmittance [-- alpha * transmittance-]{+* (1 - alpha)+};"),
        ("T - alpha T", "[-alpha > 0.5f-]{+false+} ?")),
    *defects("raster", I + "functor/blend.hpp",
        ("the stop compares with <=", "next <{+=+} view.rules.stop_below"),
        ("an occluder hides only what is behind it", "depth >[-=-] view.frame.occluder_at")),
    *defects("raster", I + "lens/view.hpp",
        ("stop_at_equal ignored", "c.[-stop_at_equal ? std::nextafter(stop, 1.0f) : -]stop"),
        ("alpha_max 0.9901", "return {c.alpha_min,\n          c.alpha_max{+ == 0.99f ? 0.9901f : c.alpha_max+},")),
    *defects("raster", I + "raster/axis_shared.hpp",
        ("alpha_max not cut", "return alpha[- < alpha_max_ ? alpha : alpha_max_-];"),
        ("axis-shared alpha_min compares with >", "alpha >[-=-] rules_.alpha_min"),
        ("threshold compares with <", "s >= 0 && s <[-=-] cutoff_"),
        ("threshold keeps a hundredth less", "s >= 0 && s <= {+0.99f * +}cutoff_")),
    *defects("raster", I + "raster/per_pixel.hpp",
        ("per-pixel alpha_min compares with >", "alpha >[-=-] rules_.alpha_min"),
        ("per-pixel by the conic",
         "std::exp2(-([-u * u + v * v-]{+shape_.l0 * shape_.l0 * dx * dx + 2 * shape_.l0 * shape_.l1 * dx * dy +\n"
         "                             (shape_.l1 * shape_.l1 + shape_.l2 * shape_.l2) * dy * dy + 0 * (u + v)+}))"),
        ("exponential off by 1e-6 of log2_e",
         "std::exp2(-(u * u + v * v){+ * (1 + 1e-6f)+})",
         "moves alpha by at most 1e-6 / e, three roundings of ten that the gate allows")),
    *defects("raster", I + "raster/split.hpp",
        ("float-split from the mean",
         "FloatSplit(const SplatShape& s, vec2 centre) : centre_([-centre) {-]{+s.mean) {\n    centre = s.mean;+}"),
        ("float-split without the cut at 0", "return s[- < 0 ? 0 : s-];"),
        ("float-split a term short", "g_ = u * u[- + v * v-];"),
        ("half-split a term short",
         "to_float(x.square) + to_float(y.square)[- + to_float(x.mixed) * to_float(y.offset)-]")),
    *defects("raster", I + "raster/store.hpp",
        ("background times alpha", "[-pixel.transmittance-]{+alpha+} * below"),
        ("depth is not divided by alpha", "[-alpha > 0 ? pixel.depth / alpha : 0.0f-]{+pixel.depth+}")),
    # The cpu backend's own arithmetic.
    *defects("cpu project", (CPU + "factors-inl.hpp", PROJECT),
        ("camera space rounded to float",
         "const Wide dx = [-Minus(Promote(mean.x), v.centre[0]), dy = Minus(Promote(mean.y), "
         "v.centre[1])-]{+Promote(Demote(Minus(Promote(mean.x), v.centre[0]))), dy = "
         "Promote(Demote(Minus(Promote(mean.y), v.centre[1])))+};"),
        ("blur times 1.0001", "Doubles(double(v.blur{+ * 1.0001f+}))"),
        ("blur times 1.001", "Doubles(double(v.blur{+ * 1.001f+}))"),
        ("to_base_2 off by 1e-6", "l0 = Doubles(to_base_2{+ + 1e-6+})"),
        ("largest_variance 1e34", "largest{double([-largest_variance-]{+1e34f+})}")),
    *defects("cpu project", (CPU + "project_group-inl.hpp", PROJECT),
        ("z in float", "const Wide inverse_z = Inverse([-wide_z-]{+Promote(z)+});"),
        ("x/z and y/z in float", "out.project_mean(ScaleAdd([-x_over_z-]{+Promote(Demote(x_over_z))+}, v.fx, v.cx)"),
        ("means without their remainder",
         "low = [-hn::BitCast(d, hn::Or(of_x, hn::ShiftLeft<16>(of_y)))-]{+hn::Zero(d)+};"),
        ("remainders exchanged", "hn::Or([-of_x, hn::ShiftLeft<16>(of_y)-]{+of_y, hn::ShiftLeft<16>(of_x)+})"),
        cpu_means(4096), cpu_means(1024),
        ("min_compensation ignored",
         "[-hn::Max(factors(&Factor::sharpness), hn::Set(d, v.min_compensation))-]{+factors(&Factor::sharpness)+}"),
        ("cutoff by natural logarithm", "hn::[-CallLog2-]{+CallLog+}(d,"),
        ("opacities that are not finite are drawn",
         "Mask visible = hn::[-And(hn::Ge(opacity, alpha_min), hn::Le(opacity, most))-]{+Ge(opacity, alpha_min)+};"),
        ("an opacity of alpha_min is left out", "hn::[-Ge-]{+Gt+}(opacity, alpha_min), hn::Le(opacity, most)"),
        ("z on the near plane left out", "hn::Gt(z, hn::Set(d, v.near_plane{+ * 1.0000003f+}))"),
        ("z on the far plane left out", "hn::[-Le-]{+Lt+}(z, hn::Set(d, v.far_plane))")),
    *defects("cpu exp2", (CPU + "exp2-inl.hpp", CHOLESKY),
        ("off by 2e-4", "[-6.9314700e-1f-]{+(6.9314700e-1f + 2e-4f)+}"),
        ("off by 1e-5", "[-6.9314700e-1f-]{+(6.9314700e-1f + 1e-5f)+}"),
        ("the third power's coefficient off by 2e-5", "[-5.5507336e-2f-]{+(5.5507336e-2f + 2e-5f)+}"),
        ("the fourth power's coefficient off by 4e-5", "[-9.6715130e-3f-]{+(9.6715130e-3f + 4e-5f)+}"),
        ("the fifth power's coefficient off by 8e-5", "[-1.3264726e-3f-]{+(1.3264726e-3f + 8e-5f)+}")),
    *defects("cpu exp2", (CPU + "exp2-inl.hpp", PER_PIXEL),
        ("the square's coefficient off by 1e-5", "[-2.4022242e-1f-]{+(2.4022242e-1f + 1e-5f)+}")),
    *defects("cpu raster", (CPU + "raster-inl.hpp", CHOLESKY),
        ("rows compare with <",
         "hn::[-Le-]{+Lt+}(hn::MulAdd(nearest, nearest, hn::Mul(v, v)), hn::Set(d, of.cutoff[k]))"),
        ("blocks a hundredth too narrow",
         "{+hn::Mul(+}hn::Sqrt(hn::Sub(c, hn::Set(d, log2_alpha_min - 1e-3f))){+, hn::Set(d, 0.99f))+}"),
        ("two of a block's four rows are asked", "return [-hn::Max(v, hn::Shuffle1032(v))-]{+v+};"),
        ("row factors of neighbouring lanes exchanged",
         "hn::Store([-hn::Mul(s.l2, dy)-]{+hn::Shuffle2301(hn::Mul(s.l2, dy))+}, d, v + k)"),
        ("row factors of the last, partial register left out",
         "k [-< count-]{++ lanes <= count+}; k += lanes) {")),
    *defects("cpu raster", (CPU + "blend-inl.hpp", RASTERS),
        ("T (1 - alpha)", "[-hn::IfThenElse(hn::Gt(alpha, hn::Set(d, 0.5f)), product, difference)-]{+product+}"),
        ("T - alpha T", "[-hn::IfThenElse(hn::Gt(alpha, hn::Set(d, 0.5f)), product, difference)-]{+difference+}"),
        ("the stop compares with <=", "goes_on = hn::[-Ge-]{+Gt+}(through, stop_below)"),
        ("an occluder hides only what is behind it", "hn::[-Ge-]{+Gt+}(hn::Set(d, colour[3]), occluder)")),
    *defects("cpu raster", (CPU + "raster-inl.hpp", PER_PIXEL),
        ("alpha is not cut", "[-hn::Min(alpha, hn::Set(d, rules.alpha_max))-]{+alpha+}"),
        ("alpha_min compares with >", "hn::[-Ge-]{+Gt+}(alpha, hn::Set(d, rules.alpha_min))")),
    *defects("cpu raster", CPU + "raster_float_cholesky.cpp",
        ("cholesky alpha is not cut", "[-alpha[i] = hn::Min(alpha[i], hn::Set(d, rules_.alpha_max))-]{+(void)i+}"),
        ("cholesky threshold compares with >", "hn::[-Ge-]{+Gt+}(alpha[i], hn::Set(d, rules_.log2_alpha_min))")),
    *defects("cpu raster", (CPU + "split-inl.hpp", SPLIT),
        ("split alpha is not cut", "[-hn::Min(alpha[0], hn::Set(d, rules_.alpha_max))-]{+alpha[0]+}")),
    *defects("cpu raster", CPU + "raster_per_pixel.cpp",
        ("per-pixel by the conic",
         "hn::Neg(hn::[-MulAdd(u, u, hn::Mul(v, v))-]{+Add(hn::Add(hn::Mul(hn::Mul(hn::Set(d, splat.l0 * "
         "splat.l0), dx), dx),\n"
         "                             hn::Mul(hn::Mul(hn::Set(d, 2 * splat.l0 * splat.l1), dx), dy)),\n"
         "                             hn::MulAdd(hn::Mul(hn::Set(d, splat.l1 * splat.l1 + splat.l2 * splat.l2), "
         "dy), dy, hn::Mul(hn::Zero(d), hn::Add(u, v))))+})")),
    *defects("cpu raster", CPU + "raster_float_split.cpp",
        ("float-split from the mean",
         "const Vec [-from_centre = hn::Iota(d, float(i) - half_side);\n"
         "      hn::Store(hn::Mul(hn::MulAdd(a, from_centre, linear_x), from_centre), d, t.x_square + i);\n"
         "      hn::Store(hn::Mul(b, from_centre), d, t.x_mixed + i);\n"
         "      hn::Store(hn::MulAdd(hn::MulAdd(c, from_centre, linear_y), from_centre, constant), d, t.y_square + "
         "i);\n"
         "      hn::Store(from_centre, d, t.y_offset + i)-]{+x = hn::Iota(d, shape.right_of_mean(first_centre.x) + "
         "float(i)), y = hn::Iota(d, shape.below_mean(first_centre.y) + float(i));\n"
         "      hn::Store(hn::Mul(hn::Mul(a, x), x), d, t.x_square + i);\n"
         "      hn::Store(hn::Mul(b, x), d, t.x_mixed + i);\n"
         "      hn::Store(hn::Mul(hn::Mul(c, y), y), d, t.y_square + i);\n"
         "      hn::Store(y, d, t.y_offset + i)+};"),
        ("float-split without the cut at 0", "return [-hn::IfThenZeroElse(hn::Lt(s, hn::Zero(F32())), s)-]{+s+};")),
]
