# SPDX-License-Identifier: Apache-2.0
"""Defects that the stability tests must notice."""
from mutant import In, defects

I = "include/swiftgs/"
FORMULAS = I + "lens/formulas.inc"
CPU = "backends/cpu/"
CUDA = "backends/cuda/"
CHOLESKY = ("raster_float_cholesky.cpp",)
SPLIT = ("raster_float_split.cpp",)
PER_PIXEL = ("raster_per_pixel.cpp",)
RASTERS = CHOLESKY + SPLIT + PER_PIXEL + ("raster_half_split.cpp",)  # share functions, of which the linker takes one
# Of the cuda backend: all bounds, so that frames of one backend are wrong alike.
STAGES = ("stages.cu",)
WARPS = ("raster_float_cholesky.cu",)

# Of `project.hpp`, which backends share.
FLOAT_CAMERA_SPACE = (
    "p[row] = [-multiply_add(v.rotation(row, 0), d[0],\n"
    "                            multiply_add(v.rotation(row, 1), d[1], v.rotation(row, 2) * d[2]))-]"
    "{+float(std::fma(float(v.rotation(row, 0)), float(d[0]), std::fma(float(v.rotation(row, 1)), float(d[1]), "
    "float(v.rotation(row, 2)) * float(d[2]))))+};")


def means(parts):
    """Means of splats on a grid of `parts` a pixel."""
    x, y = (f"std::round(s.mean.{axis} * {parts}) / {parts}" for axis in "xy")
    return f"means on 1/{parts} pixel", f"s.{{+mean = vec2({x}, {y});\n  s.+}}l0 = f.l0,"


def cpu_means(parts):
    def grid(of, focal, point):
        return (f"hn::Mul(hn::Round(hn::Mul(Demote(ScaleAdd({of}, v.{focal}, v.{point})), hn::Set(d, {parts}.0f))), "
                f"hn::Set(d, 1.0f / {parts}))")

    return (f"means on 1/{parts} pixel",
            "out.x = [-Demote(ScaleAdd(x_over_z, v.fx, v.cx)), out.y = Demote(ScaleAdd(y_over_z, v.fy, v.cy))-]"
            f"{{+{grid('x_over_z', 'fx', 'cx')}, out.y = {grid('y_over_z', 'fy', 'cy')}+}};")


def cuda_blur(factor):
    return (f"blur times {factor}",
            "[-splat = shape(views[0].camera, load_gaussian(scene, i));-]{+{\n"
            "    ViewConstants blurred = views[0].camera;\n"
            f"    blurred.blur *= {factor}f;\n"
            "    splat = shape(blurred, load_gaussian(scene, i));\n"
            "  }+}")


def constant(name):
    """A constant of the harmonics, larger by 2e-4."""
    return f"{name} off by 2e-4", f"inline constexpr double {name} = {{+2e-4 + +}}"


CONSTANTS = ("c0", "c1", "c20", "c21", "c22", "c23", "c24", "c30", "c31", "c32", "c33", "c34", "c35", "c36")
GSPLAT_LIMITS = {
    "left": "camera.cx / camera.fx", "right": "(camera.width - camera.cx) / camera.fx",
    "top": "camera.cy / camera.fy", "bottom": "(camera.height - camera.cy) / camera.fy"}

MUTANTS = [
    # Lenses.
    *defects("lens", FORMULAS,
        ("the rational term does not move the derivatives",
         "[-mul_add(-ratio, below.slope, above.slope)-]{+above.slope+} * inverse_below"),
        ("k4 is left out", "R slope = {+terms == 4 ? 0.0 : +}c[terms - 1],"),
        ("p0 moves u by 0.1 % more", "mul_add(u, ratio, mul_add({+R(1.001) * +}p0, uv,"),
        ("the prism moves v by u alone", "s1 * [-s-]{+u * u+}))),"),
        ("tangential terms do not turn splats",
         "cross = [-mul_add(by_s, uv, two * mul_add(p0, u, p1 * v))-]{+by_s * uv+};"),
        ("derivatives beyond the limits of tangents", "inverse_z_u = -inverse_z * [-at_u-]{+u+}"),
        ("a perspective lens shows what is turned over",
         "(mul_add(u, u, v * v) < fold_squared)[- & keeps_sides(place)-]"),
        ("a perspective lens folds late", "(mul_add(u, u, v * v) < {+R(1.001) * +}fold_squared)"),
        ("a fisheye is stretched as a pinhole about its axis",
         "around = [-choose(on_axis, along, polar * inverse_across)-]{+inverse(p.z)+}"),
        ("a fisheye is stretched by 1e-4 more along its radii", "along = {+R(1.0001) * +}p.z * inverse_squared;"),
        ("a fisheye folds late", "polar * polar < R({+1.001 * +}limits.fold_squared)"),
        ("an orthographic lens is 1e-4 higher for splats", "{none, [-one-]{+R(1.0001)+}, none}, none < one"),
        ("a panorama takes derivatives at its poles", "[-choose(over_level < most, over_level, most)-]{+over_level+}"),
        ("a panorama's elevations do not lean", "{[-down * x-]{+none+},")),
    *defects("lens", I + "view_constants.hpp",
        ("a panorama shows the copy to the left", "std::[-round-]{+floor+}((x - panorama_middle) / turn)")),
    *defects("reference", In("backends/reference/lens.hpp"),
        ("a panorama takes derivatives at its poles", "level / [-std::max(level, least)-]{+level+}")),
    *defects("cpu project", CPU + "project.cpp",
        ("a panorama shows the copy to the left", "rounded((x - v.panorama_middle) / v.turn{+ - 0.4+})")),
    # Projection.
    *defects("project", I + "project.hpp",
        ("camera space in float", FLOAT_CAMERA_SPACE, dict(quick=True)),
        ("camera space rounded to float after the rotation",
         "inverse([-p[2]), x_over_z = p[0] * inverse_z, y_over_z = p[1]-]{+float(p[2])), x_over_z = float(p[0]) * "
         "inverse_z, y_over_z = float(p[1])+} * inverse_z;"),
        ("camera's centre in float", "{mean.x - [-v.centre(0)-]{+float(v.centre(0))+},"),
        ("depth by a float sum",
         "const [-float z = float(placing.depth_scale() * p[2])-]{+vec3 from_camera(float(g.mean.x - v.centre[0]), "
         "float(g.mean.y - v.centre[1]),\n"
         "                       float(g.mean.z - v.centre[2]));\n"
         "  const float z = dot(vec3(v.axes[2][0], v.axes[2][1], v.axes[2][2]), from_camera)+};"),
        means(4096), means(1024),
        ("needles in float", "float_length_squared = [-512-]{+INFINITY+};"),
        ("needles beside the first pixels in float", "float_length_squared = [-512-]{+5e5f+};"),
        ("nearly parallel rows in float", "float_tangent_squared = [-16-]{+INFINITY+};"),
        ("needles by the camera's axes in float", "if constexpr ([-std::is_same_v<Real, float>-]{+true+})"),
        ("determinant as a difference",
         "const Real sharp = [-dot(narrow, narrow)-]{+xx * yy * inv_var_y - xy * xy * inv_var_y+};"),
        ("to_base_2 off by 1e-6", "to_base_2 = 0.84932180028801904272{+ + 1e-6+}"),
        ("cutoff by natural logarithm times log2_e",
         "std::[-log2(opacity / v.alpha_min)-]{+log(opacity / v.alpha_min) * float(log2_e)+}",
         dict(equivalent="two roundings in place of one: as good as float can be")),
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
         dict(equivalent="half the width is not a number then, and the splat not visible")),
        ("an opacity of alpha_min is left out", "opacity >[-=-] v.alpha_min && opacity < INFINITY"),
        ("visible by its mean alone", "s.mean.x [-+ s.half_width -]>= 0.5f"),
        ("view_direction without scaling", "[-for (int k = 0; k < 3; ++k) d[k] /= largest;-]"),
        ("far plane left out", "z > v.near_plane[- && z <= v.far_plane-]"),
        ("z on the far plane left out", "z <[-=-] v.far_plane"),
        ("planes compare in double",
         "if (!([-z > v.near_plane && z <= v.far_plane-]{+p[2] > double(v.near_plane) && p[2] <= "
         "double(v.far_plane)+})) return {};")),
    *defects("placed", I + "placed_scene.hpp",
        ("the camera's place beside a scene's in float",
         "x = [-camera.centre[0] - to.x-]{+float(camera.centre[0]) - float(to.x)+},")),
    *defects("clips", I + "clip.hpp",
        ("half-spaces without their border", "h.w))) >[-=-] 0;"),
        ("a sphere without its border", "<[-=-] radius * radius"),
        ("half-spaces that end 1e-5 before their border", "h.w))) >= [-0-]{+1e-5f+};")),
    *defects("view", I + "view_constants.hpp",
        ("blur times 1.0001", "v.blur = *whole.blur{+ * 1.0001f+}, v.antialiased"),
        ("blur times 1.001", "v.blur = *whole.blur{+ * 1.001f+}, v.antialiased"),
        ("near plane of gsplat as inria's",
         "[-conventions.cull_at_near ? near_plane : std::nextafter(near_plane, 0.0f)-]{+near_plane+}")),
    *defects("splats", I + "splats.hpp",
        ("largest_variance 1e34", "largest_variance = [-1e36f-]{+1e34f+}"),
        ("largest_variance 1e37", "largest_variance = [-1e36f-]{+1e37f+}")),
    *defects("colours", I + "colours.hpp",
        ("colours are not cut at 0", "rgb[c][- > 0 ? rgb[c] : 0.0f-]"),
        ("colours that are not finite are drawn",
         "[-if (!(rgb[c] >= -most && rgb[c] <= most)) return {}-]{+(void)most+};")),
    *defects("harmonics", I + "sh.hpp", *map(constant, CONSTANTS)),
    *defects("cpu harmonics", In(I + "sh.hpp", suite="cpu", sources=("shade.cpp",)),
        constant("c0"), constant("c1"), constant("c22"), constant("c33")),
    *defects("view", I + "view_constants.hpp",
        *((f"gsplat's limit at the {side} 0.31", f"{least} + 0.3{{+1+}} *") for side, least in GSPLAT_LIMITS.items()),
        *((f"inria's limit of {axis} 1.31", f"tangents.most_{tangent} = 1.3{{+1+}} *")
          for axis, tangent in zip("xy", "uv"))),
    # Order.
    *defects("splats", I + "splats.hpp",
        ("depth key of one bit less", "return __builtin_bit_cast(std::uint32_t, depth){+ & ~1u+};"),
        ("keys of 30 bits", "depth_key_bits = [-31-]{+30+}")),
    *defects("sort", I + "sort/early.hpp",
        ("ties in descending order",
         "{+std::reverse(pairs.keys.data(), pairs.keys.data() + count.get());\n"
         "  std::reverse(pairs.values.data(), pairs.values.data() + count.get());\n"
         "  +}b.sort_pairs(pairs, count, depth_key_bits);")),
    *defects("sort", I + "sort/standard.hpp",
        ("ties in another order where the sort is standard",
         "{+std::reverse(scratch.intersections.keys.data(), scratch.intersections.keys.data() + count.get());\n"
         "    std::reverse(scratch.intersections.values.data(), scratch.intersections.values.data() + "
         "count.get());\n"
         "    +}b.sort_pairs(scratch.intersections,")),
    # Bounds.
    *defects("bounds", I + "bounds/bounds.hpp",
        ("no slack", "return [-1e-2f + 1e-4f-]{+0+} * (half_width + half_height);"),
        ("tiles_between a tile short", "clamped_floor(last * inverse_side[- + 1-], among.begin, among.end)}"),
        ("tiles_between a pixel short", "last = std::floor(high - [-0-]{+1+}.5f);\n  if"),
        ("tiles_meeting a tile short", "clamped_floor(last[- + 1-], among.begin, among.end)}")),
    *defects("bounds", I + "bounds/ellipse.hpp",
        ("ellipse without the other border of a row", "clamp(-steepest_, top, [-bottom-]{+top+})")),
    *defects("bounds", I + "bounds/three_sigma_square.hpp",
        ("square that ends where a tile begins", "float(grid.side[- - 1-])"),
        ("square of 2.9 sigmas", "std::ceil([-3-]{+2.9f+} *"),
        ("square half a pixel off", "shape.mean.x[- - 0.5f-]")),
    # Rasterization.
    *defects("raster", I + "raster/raster.hpp",
        ("row_touched compares with <", "nearest * nearest + v * v <[-=-] shape.cutoff"),
        ("T (1 - alpha)", "transmittance [-- alpha * transmittance-]{+* (1 - alpha)+};"),
        ("T - alpha T", "[-alpha > 0.5f-]{+false+} ?"),
        ("the stop compares with <=", "next <{+=+} view.rules.stop_below"),
        ("an occluder hides only what is behind it", "depth >[-=-] view.frame.occluder_at")),
    *defects("raster", I + "view.hpp",
        ("stop_at_equal ignored", "c.[-stop_at_equal ? std::nextafter(stop, 1.0f) : -]stop"),
        ("alpha_max 0.9901", "return {c.alpha_min,\n            c.alpha_max{+ == 0.99f ? 0.9901f : c.alpha_max+},")),
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
         dict(equivalent="moves alpha by at most 1e-6 / e, three roundings of ten that the gate allows"))),
    *defects("raster", I + "raster/exponents.hpp",
        ("float-split from the mean",
         "FloatSplit(const SplatShape& s, vec2 centre) : centre_([-centre) {-]{+s.mean) {\n    centre = s.mean;+}"),
        ("float-split without the cut at 0", "return s[- < 0 ? 0 : s-];"),
        ("float-split a term short", "g_ = u * u[- + v * v-];"),
        ("half-split a term short",
         "to_float(x.square) + to_float(y.square)[- + to_float(x.mixed) * to_float(y.offset)-]")),
    *defects("raster", I + "store_pixel.hpp",
        ("background times alpha", "[-pixel.transmittance-]{+alpha+} * below"),
        ("depth is not divided by alpha", "[-alpha > 0 ? pixel.depth / alpha : 0.0f-]{+pixel.depth+}")),
    # The cpu backend's own arithmetic.
    *defects("cpu project", CPU + "project.cpp",
        ("camera space rounded to float",
         "const Wide dx = [-Minus(Promote(mean.x), v.centre[0]), dy = Minus(Promote(mean.y), "
         "v.centre[1])-]{+Promote(Demote(Minus(Promote(mean.x), v.centre[0]))), dy = "
         "Promote(Demote(Minus(Promote(mean.y), v.centre[1])))+};"),
        ("z in float", "const Wide inverse_z = Inverse([-wide_z-]{+Promote(z)+});"),
        ("x/z and y/z in float", "out.x = Demote(ScaleAdd([-x_over_z-]{+Promote(Demote(x_over_z))+}, v.fx, v.cx))"),
        ("needles in float", "const bool any_in_double = [-!hn::AllFalse(d, seen.in_double)-]{+false+};"),
        ("nearly parallel rows in float",
         "hn::[-Le(hn::Add(xx, yy), hn::Set(d, float_tangent_squared))-]{+Ge(xx, hn::Zero(d))+}"),
        ("a splat in double takes its neighbour's place",
         "{+++shapes;\n      +}if (chosen_[k] != 0) *shapes = shapes_[k];[-\n      ++shapes;-]"),
        ("blur times 1.0001", "blur = hn::Set(d, v.blur{+ * 1.0001f+});"),
        ("blur times 1.001", "blur = hn::Set(d, v.blur{+ * 1.001f+});"),
        cpu_means(4096), cpu_means(1024),
        ("to_base_2 off by 1e-6", "hn::Set(d, float(to_base_2){+ + 1e-6f+})"),
        ("min_compensation ignored",
         "hn::[-Max(hn::Div(sharp, var_x_given_y), hn::Set(d, v.min_compensation))-]{+Div(sharp, var_x_given_y)+}"),
        ("cutoff by natural logarithm", "hn::[-CallLog2-]{+CallLog+}(d,"),
        ("opacities that are not finite are drawn",
         "Mask visible = hn::[-And(hn::Ge(opacity, alpha_min), hn::Le(opacity, most))-]{+Ge(opacity, alpha_min)+};"),
        ("an opacity of alpha_min is left out", "hn::[-Ge-]{+Gt+}(opacity, alpha_min), hn::Le(opacity, most)"),
        ("z on the near plane left out", "hn::Gt(z, hn::Set(d, v.near_plane{+ * 1.0000003f+}))"),
        ("z on the far plane left out", "hn::[-Le-]{+Lt+}(z, hn::Set(d, v.far_plane))"),
        ("largest_variance 1e34",
         "hn::Set(d, [-largest_variance-]{+1e34f+})",
         dict(equivalent="such splats are projected in double, but where both coordinates of the mean are beyond "
                         "1e8"))),
    *defects("cpu shade", CPU + "shade.cpp",
        ("direction without scaling",
         "[-direction = {hn::Div(direction.x, largest), hn::Div(direction.y, largest),\n"
         "                   hn::Div(direction.z, largest)}-]{+(void)largest+};"),
        ("the last coefficient is left out", "if (j {++ 1 +}< coefficients) {")),
    *defects("cpu shade", In(I + "colours.hpp", suite="cpu", sources=("shade.cpp",)),
        ("colours that are not finite are drawn",
         "[-if (!(rgb[c] >= -most && rgb[c] <= most)) return {}-]{+(void)most+};"),
        ("colours are not cut at 0", "rgb[c][- > 0 ? rgb[c] : 0.0f-]")),
    *defects("cpu exp2", In(CPU + "exp2-inl.hpp", sources=CHOLESKY),
        ("off by 2e-4", "[-6.9314700e-1f-]{+(6.9314700e-1f + 2e-4f)+}"),
        ("off by 1e-5", "[-6.9314700e-1f-]{+(6.9314700e-1f + 1e-5f)+}"),
        ("the third power's coefficient off by 2e-5", "[-5.5507336e-2f-]{+(5.5507336e-2f + 2e-5f)+}"),
        ("the fourth power's coefficient off by 4e-5", "[-9.6715130e-3f-]{+(9.6715130e-3f + 4e-5f)+}"),
        ("the fifth power's coefficient off by 8e-5", "[-1.3264726e-3f-]{+(1.3264726e-3f + 8e-5f)+}")),
    *defects("cpu exp2", In(CPU + "exp2-inl.hpp", sources=PER_PIXEL),
        ("the square's coefficient off by 1e-5", "[-2.4022242e-1f-]{+(2.4022242e-1f + 1e-5f)+}")),
    *defects("cpu sort", In(I + "splats.hpp", suite="cpu", sources=("sort.cpp", "intersections.cpp")),
        ("keys of 30 bits", "depth_key_bits = [-31-]{+30+}")),
    *defects("cpu raster", In(CPU + "raster-inl.hpp", sources=CHOLESKY),
        ("rows compare with <",
         "hn::[-Le-]{+Lt+}(hn::MulAdd(nearest, nearest, hn::Mul(v, v)), hn::Set(d, shape.cutoff))"),
        ("blocks a hundredth too narrow",
         "{+hn::Mul(+}hn::Sqrt(hn::Sub(c, hn::Set(d, log2_alpha_min - 1e-3f))){+, hn::Set(d, 0.99f))+}"),
        ("two of a block's four rows are asked", "return [-hn::Max(v, hn::Shuffle1032(v))-]{+v+};")),
    *defects("cpu raster", In(CPU + "blend-inl.hpp", sources=RASTERS),
        ("T (1 - alpha)", "[-hn::IfThenElse(hn::Gt(alpha, hn::Set(d, 0.5f)), product, difference)-]{+product+}"),
        ("T - alpha T", "[-hn::IfThenElse(hn::Gt(alpha, hn::Set(d, 0.5f)), product, difference)-]{+difference+}"),
        ("the stop compares with <=", "goes_on = hn::[-Ge-]{+Gt+}(through, stop_below)"),
        ("an occluder hides only what is behind it", "hn::[-Ge-]{+Gt+}(hn::Set(d, colour[3]), occluder)")),
    *defects("cpu raster", In(CPU + "raster-inl.hpp", sources=PER_PIXEL),
        ("alpha is not cut", "[-hn::Min(alpha, hn::Set(d, rules.alpha_max))-]{+alpha+}"),
        ("alpha_min compares with >", "hn::[-Ge-]{+Gt+}(alpha, hn::Set(d, rules.alpha_min))")),
    *defects("cpu raster", CPU + "raster_float_cholesky.cpp",
        ("cholesky alpha is not cut", "[-alpha[i] = hn::Min(alpha[i], hn::Set(d, rules_.alpha_max))-]{+(void)i+}"),
        ("cholesky threshold compares with >", "hn::[-Ge-]{+Gt+}(alpha[i], hn::Set(d, rules_.log2_alpha_min))")),
    *defects("cpu raster", In(CPU + "split-inl.hpp", sources=SPLIT),
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
         "      hn::Store(from_centre, d, t.y_offset + i)-]{+x = hn::Iota(d, first_centre.x - shape.mean.x + "
         "float(i)), y = hn::Iota(d, first_centre.y - shape.mean.y + float(i));\n"
         "      hn::Store(hn::Mul(hn::Mul(a, x), x), d, t.x_square + i);\n"
         "      hn::Store(hn::Mul(b, x), d, t.x_mixed + i);\n"
         "      hn::Store(hn::Mul(hn::Mul(c, y), y), d, t.y_square + i);\n"
         "      hn::Store(y, d, t.y_offset + i)+};"),
        ("float-split without the cut at 0", "return [-hn::IfThenZeroElse(hn::Lt(s, hn::Zero(F32())), s)-]{+s+};")),
    *defects("cpu bounds", CPU + "footprints.cpp",
        ("no slack",
         "hn::[-Add(All(1e-2f), hn::Mul(All(1e-4f), hn::Add(half_width, half_height)))-]{+Mul(All(0.0f), "
         "hn::Add(half_width, half_height))+}"),
        ("tiles_between a tile short",
         "ClampedFloor(hn::[-Add(hn::Mul(last, inverse_side), All(1.0f))-]{+Mul(last, inverse_side)+}, among)"),
        ("tiles_meeting a tile short", "ClampedFloor([-hn::Add(last, All(1.0f))-]{+last+}, among)")),
    # The cuda backend.
    *defects("cuda project", In(I + "project.hpp", suite="cuda", sources=STAGES),
        ("camera space in float", FLOAT_CAMERA_SPACE),
        means(4096), means(1024)),
    *defects("cuda project", In(CUDA + "include/swiftgs/cuda/project.cuh", sources=STAGES),
        cuda_blur(1.001), cuda_blur(1.0001)),
    *defects("cuda shade", In(I + "sh.hpp", suite="cuda", sources=("shade.cu",)),
        constant("c0")),
    *defects("cuda sort", In(I + "splats.hpp", suite="cuda", sources=STAGES + ("cuda.cu",)),
        ("depth key of one bit less", "return __builtin_bit_cast(std::uint32_t, depth){+ & ~1u+};")),
    *defects("cuda exp2", In(CUDA + "arithmetic.hpp", sources=WARPS),
        ("off by 1e-5", "  return result{+ * (1 + 1e-5f)+};"),
        ("off by 2e-4", "  return result{+ * (1 + 2e-4f)+};")),
    *defects("cuda raster", In(CUDA + "blending.hpp", sources=WARPS),
        ("alpha_min compares with >", "alpha >[-=-] exp2_approx(least)"),
        ("threshold compares with >", "exponent >[-=-] least"),
        ("alpha is not cut", "[-saturate(-]alpha * (kept ? 1.0f : 0.0f)[-)-]"),
        ("T (1 - alpha)",
         "[-Pixel::dimmed_relative(left[p][k], weights[p][k], alpha_max)-]{+left[p][k] * (1 - alpha_max * "
         "alphas[p][k])+}"),
        ("an occluder hides only what is behind it", "colour.w >[-=-] occluder")),
    *defects("cuda raster", In(CUDA + "lane_planes.cuh", sources=WARPS),
        ("colours stay in units of alpha_max",
         "[-multiply_rounded(pixel.colour[c], rules.alpha_max)-]{+pixel.colour[c]+}"),
        ("depths stay in units of alpha_max", "[-multiply_rounded(pixel.depth, rules.alpha_max)-]{+pixel.depth+}")),
    *defects("cuda segments", In(CUDA + "blending.hpp", sources=WARPS),
        ("the transmittance before a segment is forgotten", "total.w = [-before * -]segment.transmittance;"),
        ("pixels stop at the limit itself", "scaled > 0 ? stop_below [-/ scaled -]: 0.0f"),
        ("all begin with the same transmittance", "(k * [-0x9e3779b9u-]{+0u+}) >> 9")),
    *defects("cuda raster", In(CUDA + "lane_blender.cuh", sources=WARPS),
        ("an occluder hides only what is behind it, in groups", "colours[k].w >[-=-] occluders[p]"),
        ("an occluder ends no pixel in groups", "[-if (alphas[p][k] > 0) hidden |= 1u << p;-]"),
        ("an occluder ends a pixel in groups at what shows nothing", "[-if (alphas[p][k] > 0) -]hidden |= 1u << p;"),
        ("groups have depths by the first weight", "fmaf(weights[p][[-k-]{+0+}], colour.w,")),
    *defects("cuda raster", In(CUDA + "box_touched.hpp", sources=WARPS),
        ("warp blocks are left out a thousandth early", "s.cutoff * [-1.0001f-]{+0.999f+}")),
    # Its planes.
    *defects("cuda planes", In(CUDA + "lane_planes.cuh", sources=WARPS),
        ("attributes are summed by the weights of the next splat",
         "const float4 row = queue.attributes[r][[-k-]{+(k + 1) % queue_size+}];"),
        ("sums stay in units of alpha_max", "[-multiply_rounded(of_row[c], view.rules.alpha_max)-]{+of_row[c]+}"),
        ("the last row of attributes is the first", "&job.attributes.row(r{+ == 3 ? 0 : r+}, id), sizeof"),
        ("sums of a segment are not scaled", "add_scaled(this->sums[r][i], [-unit-]{+1+}, lane.sums[p * rows + r])"),
        ("of equal weights the farthest Gaussian", "weights[p][k] >{+=+} weight[p]"),
        ("the median takes the transmittance to one half", "left[p][k] >[-=-] limits[p].median"),
        ("the first depth is of the next splat", "if (left[p][k{+ + 1+}] >= limits[p].first) first[p] = ids[k];"),
        ("a segment ends with its limits", "[-if (!(left < limits[p].median)) median[p] = SplatPicks::none;-]"),
        ("an occluder hides by the depths of means", "RayDepth{row.x, [-row.y, row.z-]{+0, 0+}}"),
        ("depths of the rows' first splat", "depths + [-std::size_t(id) * stride-]{+id+}")),
    *defects("cuda planes", In(CUDA + "segment_picks.hpp", sources=WARPS),
        ("a later segment picks the median again",
         ("[-picks.median == SplatPicks::none ? median : passed-]{+median+}",
          "if ([-median =-]{+segment.median !+}= SplatPicks::none) median = segment.median;")),
        ("weights of segments compare unscaled", "const float of_segment = [-unit * -]segment.weight;")),
    *defects("cuda raster", In(CUDA + "exponents.hpp", sources=("raster_per_pixel.cu",)),
        ("per-pixel by the conic",
         "exp2_approx(-[-fmaf(u, u, v * v)-]{+(factor.x * factor.x * dx * dx + 2 * factor.x * factor.y * dx * dy "
         "+\n"
         "                                     (factor.y * factor.y + factor.z * factor.z) * dy * dy + 0 * (u + "
         "v))+})")),
    *defects("cuda raster", In(CUDA + "exponents.hpp", sources=("raster_float_split.cu",)),
        ("float-split from the mean",
         ("const float u = [--fmaf(s.l0, mean.x, s.l1 * mean.y), v = -s.l2 * mean.y-]{+0, v = 0+};",
          "make_float4([-2 * s.l0 * u, 2 * fmaf(s.l1, u, s.l2 * v)-]{+mean.x, mean.y+}, h, 0)",
          "[-mixed = fmaf(terms.y, y, rest.x), row = fmaf(-y, fmaf(terms.z, y, rest.y), terms.w)-]"
          "{+dy = y - rest.y, mixed = terms.y * dy, row = fmaf(-dy, terms.z * dy, terms.w)+};",
          "const float at = x + right{+ - rest.x+};"))),
    # The reference.
    *defects("reference", In("backends/reference/variation.hpp"),
        ("trials leave the factor as it is",
         "[-nudge(factor.l0), nudge(factor.l1), nudge(factor.l2);-]",
         dict(equivalent="the rounding of a mean moves pixels as much as that of l0 times a distance within the "
                         "image"))),
    *defects("reference", In("backends/reference/varied_splats.hpp"),
        ("planes compare in double",
         "out.drawn = [-between_planes(float(splat->depth))-]{+splat->depth >= double(k.near_plane) && "
         "splat->depth <= double(k.far_plane)+};"),
        ("order by depth in double",
         "return [-float(a.splat.depth) < float(b.splat.depth)-]{+a.splat.depth < b.splat.depth+};")),
    *defects("reference", In("backends/reference/conditioning.cpp"),
        ("trials keep pixels in double", "std::array<PixelState<[-float-]{+double+}>, trials> moved;")),
    *defects("reference", In("backends/reference/projection.hpp"),
        ("no blur of the determinant", "det_sharp + blur * (xx + yy)[- + blur * blur-]")),
    *defects("reference", In("backends/reference/lens.hpp"),
        ("inria's limit 1.31", "limits_.most_u = 1.[-3-]{+31+} * half_x")),
]
