# SPDX-License-Identifier: Apache-2.0
"""Defects that the stability tests must notice."""
from mutant import Mutant

I = "include/swiftgs/"
CPU = "backends/cpu/"
CUDA = "backends/cuda/"
CHOLESKY = ("raster_float_cholesky.cpp",)
SPLIT = ("raster_float_split.cpp",)
PER_PIXEL = ("raster_per_pixel.cpp",)
# Of the cuda backend: all bounds, so that frames of one backend are wrong alike.
STAGES = ("stages.cu",)
WARPS = ("raster_float_cholesky.cu",)


def harmonics():
    """Each constant of the harmonics, larger by 2e-4."""
    text = {"c0": "0.28209479177387814", "c1": "0.4886025119029199", "c20": "1.0925484305920792",
            "c21": "-1.0925484305920792", "c22": "0.31539156525252005", "c23": "-1.0925484305920792",
            "c24": "0.5462742152960396", "c30": "-0.5900435899266435", "c31": "2.890611442640554",
            "c32": "-0.4570457994644658", "c33": "0.3731763325901154", "c34": "-0.4570457994644658",
            "c35": "1.445305721320277", "c36": "-0.5900435899266435"}
    for name, value in text.items():
        line = f"inline constexpr double {name} = {value};"
        off = f"inline constexpr double {name} = {value} + 2e-4;"
        yield Mutant(f"harmonics: {name} off by 2e-4", I + "sh.hpp", line, off)
        if name in ("c0", "c1", "c22", "c33"):
            yield Mutant(f"cpu harmonics: {name} off by 2e-4", I + "sh.hpp", line, off, "cpu", ("shade.cpp",))


def presets():
    """Limits of the Jacobian."""
    limits = {"left": "camera.cx / camera.fx + 0.3 *", "right": "(camera.width - camera.cx) / camera.fx + 0.3 *",
              "top": "camera.cy / camera.fy + 0.3 *", "bottom": "(camera.height - camera.cy) / camera.fy + 0.3 *"}
    for side, old in limits.items():
        new = old.replace("0.3 ", "0.31 ")
        yield Mutant(f"view: gsplat's limit at the {side} 0.31", I + "view_constants.hpp", old, new)
    for axis in "xy":
        yield Mutant(f"view: inria's limit of {axis} 1.31", I + "view_constants.hpp",
                     f"v.tan_{axis}_max = float(1.3 *", f"v.tan_{axis}_max = float(1.31 *")


def cpu_means(parts):
    """Means of splats on a grid of `parts` a pixel."""
    grid = lambda of, focal, point: (f"hn::Mul(hn::Round(hn::Mul(Demote(ScaleAdd({of}, v.{focal}, v.{point})), "
                                     f"hn::Set(d, {parts}.0f))), hn::Set(d, 1.0f / {parts}))")
    yield Mutant(f"cpu project: means on 1/{parts} pixel", CPU + "project.cpp",
                 "const Vec mean_x = Demote(ScaleAdd(x_over_z, v.fx, v.cx)), "
                 "mean_y = Demote(ScaleAdd(y_over_z, v.fy, v.cy));",
                 f"const Vec mean_x = {grid('x_over_z', 'fx', 'cx')}, mean_y = {grid('y_over_z', 'fy', 'cy')};")


MUTANTS = [
    # Projection.
    Mutant("project: camera space in float", I + "project.hpp",
           "p[row] =\n          std::fma(v.rotation[row][0], d[0], std::fma(v.rotation[row][1], d[1], v.rotation[row][2] * d[2]));",
           "p[row] = float(std::fma(float(v.rotation[row][0]), float(d[0]), std::fma(float(v.rotation[row][1]), "
           "float(d[1]), float(v.rotation[row][2]) * float(d[2]))));",
           quick=True),
    Mutant("project: camera space rounded to float after the rotation", I + "project.hpp",
           "inverse(p[2]), x_over_z = p[0] * inverse_z, y_over_z = p[1] * inverse_z;",
           "inverse(float(p[2])), x_over_z = float(p[0]) * inverse_z, y_over_z = float(p[1]) * inverse_z;"),
    Mutant("project: camera's centre in float", I + "project.hpp",
           "{mean.x - v.centre[0],", "{mean.x - float(v.centre[0]),"),
    Mutant("project: depth by a float sum", I + "project.hpp", "const float z = float(p[2]);",
           "const float z = float(v.rotation[2][0]) * float(d[0]) + float(v.rotation[2][1]) * float(d[1]) +"
           " float(v.rotation[2][2]) * float(d[2]);"),
    Mutant("project: means on 1/4096 pixel", I + "project.hpp", "s.l0 = f.l0,",
           "s.mean = vec2(std::round(s.mean.x * 4096) / 4096, std::round(s.mean.y * 4096) / 4096);\n"
           "  s.l0 = f.l0,"),
    Mutant("project: means on 1/1024 pixel", I + "project.hpp", "s.l0 = f.l0,",
           "s.mean = vec2(std::round(s.mean.x * 1024) / 1024, std::round(s.mean.y * 1024) / 1024);\n"
           "  s.l0 = f.l0,"),
    Mutant("view: blur times 1.0001", I + "view_constants.hpp", "v.blur = conventions.blur;",
           "v.blur = conventions.blur * 1.0001f;", quick=True),
    Mutant("view: blur times 1.001", I + "view_constants.hpp", "v.blur = conventions.blur;",
           "v.blur = conventions.blur * 1.001f;"),
    Mutant("project: needles in float", I + "project.hpp", "float_length_squared = 512;",
           "float_length_squared = INFINITY;"),
    Mutant("project: needles beside the first pixels in float", I + "project.hpp",
           "float_length_squared = 512;", "float_length_squared = 5e5f;"),
    Mutant("project: nearly parallel rows in float", I + "project.hpp", "float_tangent_squared = 16;", "float_tangent_squared = INFINITY;"),
    Mutant("project: needles by the camera's axes in float", I + "project.hpp",
           "if constexpr (std::is_same_v<Real, float>)", "if constexpr (true)"),
    Mutant("project: determinant as a difference", I + "project.hpp", "const Real sharp = dot(narrow, narrow);",
           "const Real sharp = xx * yy * inv_var_y - xy * xy * inv_var_y;"),
    Mutant("project: to_base_2 off by 1e-6", I + "project.hpp", "to_base_2 = 0.84932180028801904272",
           "to_base_2 = 0.84932180028801904272 + 1e-6"),
    Mutant("project: cutoff by natural logarithm times log2_e", I + "project.hpp", "std::log2(opacity / v.alpha_min)",
           "std::log(opacity / v.alpha_min) * float(log2_e)",
           equivalent="two roundings in place of one: as good as float can be"),
    Mutant("project: cutoff by natural logarithm and a rounded log2_e", I + "project.hpp",
           "std::log2(opacity / v.alpha_min)", "std::log(opacity / v.alpha_min) * 1.4427f"),
    Mutant("project: cutoff off by 1e-6 of log2_e", I + "project.hpp", "std::log2(opacity / v.alpha_min)",
           "std::log(opacity / v.alpha_min) * 1.442696f"),
    Mutant("project: cutoff by natural logarithm", I + "project.hpp", "std::log2(opacity / v.alpha_min)",
           "std::log(opacity / v.alpha_min)"),
    Mutant("project: min_compensation ignored", I + "project.hpp",
           "std::sqrt(f.sharpness > v.min_compensation ? f.sharpness : v.min_compensation)", "std::sqrt(f.sharpness)"),
    Mutant("project: compensation without the root", I + "project.hpp",
           "std::sqrt(f.sharpness > v.min_compensation ? f.sharpness : v.min_compensation)",
           "(f.sharpness > v.min_compensation ? f.sharpness : v.min_compensation)"),
    Mutant("project: opacities that are not finite are drawn", I + "project.hpp",
           "if (!(g.opacity >= v.alpha_min && g.opacity < INFINITY)) return {};",
           "if (!(g.opacity >= v.alpha_min)) return {};",
           quick=True),
    Mutant("project: a NaN of opacity is drawn", I + "project.hpp",
           "if (!(g.opacity >= v.alpha_min && g.opacity < INFINITY)) return {};",
           "if (g.opacity < v.alpha_min || g.opacity == INFINITY) return {};",
           equivalent="half the width is not a number then, and the splat not visible"),
    Mutant("project: an opacity of alpha_min is left out", I + "project.hpp",
           "g.opacity >= v.alpha_min && g.opacity < INFINITY",
           "g.opacity > v.alpha_min && g.opacity < INFINITY"),
    Mutant("project: visible by its mean alone", I + "project.hpp", "s.mean.x + s.half_width >= 0.5f",
           "s.mean.x >= 0.5f"),
    Mutant("project: view_direction without scaling", I + "project.hpp", "for (int k = 0; k < 3; ++k) d[k] /= largest;",
           ""),
    Mutant("project: far plane left out", I + "project.hpp", "z > v.near_plane && z <= v.far_plane",
           "z > v.near_plane"),
    Mutant("project: z on the far plane left out", I + "project.hpp", "z <= v.far_plane", "z < v.far_plane"),
    Mutant("project: planes compare in double", I + "project.hpp",
           "if (!(z > v.near_plane && z <= v.far_plane)) return {};",
           "if (!(p[2] > double(v.near_plane) && p[2] <= double(v.far_plane))) return {};"),
    Mutant("view: near plane of gsplat as inria's", I + "view_constants.hpp",
           "conventions.cull_at_near ? near_plane : std::nextafter(near_plane, 0.0f)",
           "near_plane"),
    Mutant("splats: largest_variance 1e34", I + "splats.hpp", "largest_variance = 1e36f", "largest_variance = 1e34f"),
    Mutant("splats: largest_variance 1e37", I + "splats.hpp", "largest_variance = 1e36f", "largest_variance = 1e37f"),
    Mutant("colours: colours are not cut at 0", I + "colours.hpp", "rgb[c] > 0 ? rgb[c] : 0.0f", "rgb[c]"),
    Mutant("colours: colours that are not finite are drawn", I + "colours.hpp",
           "if (!(rgb[c] >= -most && rgb[c] <= most)) return {};", "(void)most;"),
    *harmonics(),
    *presets(),
    # Order.
    Mutant("splats: depth key of one bit less", I + "splats.hpp", "return __builtin_bit_cast(std::uint32_t, depth);",
           "return __builtin_bit_cast(std::uint32_t, depth) & ~1u;", quick=True),
    Mutant("splats: keys of 30 bits", I + "splats.hpp", "depth_key_bits = 31", "depth_key_bits = 30"),
    Mutant("sort: ties in descending order", I + "sort/early.hpp",
           "b.sort_pairs(pairs, count, depth_key_bits);",
           "std::reverse(pairs.keys.data(), pairs.keys.data() + count.get());\n"
           "  std::reverse(pairs.values.data(), pairs.values.data() + count.get());\n"
           "  b.sort_pairs(pairs, count, depth_key_bits);"),
    Mutant("sort: ties in another order where the sort is standard", I + "sort/standard.hpp",
           "b.sort_pairs(scratch.intersections,",
           "std::reverse(scratch.intersections.keys.data(), scratch.intersections.keys.data() + count);\n"
           "    std::reverse(scratch.intersections.values.data(), scratch.intersections.values.data() + count);\n"
           "    b.sort_pairs(scratch.intersections,"),
    # Bounds.
    Mutant("bounds: no slack", I + "bounds/bounds.hpp", "return 1e-2f + 1e-4f * (half_width + half_height);",
           "return 0 * (half_width + half_height);"),
    Mutant("bounds: tiles_between a tile short", I + "bounds/bounds.hpp",
           "clamped_floor(last * inverse_side + 1, among.begin, among.end)}",
           "clamped_floor(last * inverse_side, among.begin, among.end)}"),
    Mutant("bounds: tiles_between a pixel short", I + "bounds/bounds.hpp", "last = std::floor(high - 0.5f);\n  if",
           "last = std::floor(high - 1.5f);\n  if"),
    Mutant("bounds: tiles_meeting a tile short", I + "bounds/bounds.hpp",
           "clamped_floor(last + 1, among.begin, among.end)}", "clamped_floor(last, among.begin, among.end)}"),
    Mutant("bounds: ellipse without the other border of a row", I + "bounds/ellipse.hpp",
           "clamp(-steepest_, top, bottom)", "clamp(-steepest_, top, top)"),
    Mutant("bounds: square that ends where a tile begins", I + "bounds/three_sigma_square.hpp", "float(grid.side - 1)", "float(grid.side)"),
    Mutant("bounds: square of 2.9 sigmas", I + "bounds/three_sigma_square.hpp", "std::ceil(3 *", "std::ceil(2.9f *"),
    Mutant("bounds: square half a pixel off", I + "bounds/three_sigma_square.hpp", "shape.mean.x - 0.5f", "shape.mean.x"),
    # Rasterization.
    Mutant("raster: row_touched compares with <", I + "raster/raster.hpp", "nearest * nearest + v * v <= shape.cutoff",
           "nearest * nearest + v * v < shape.cutoff"),
    Mutant("raster: T (1 - alpha)", I + "raster/raster.hpp", "transmittance - alpha * transmittance;",
           "transmittance * (1 - alpha);"),
    Mutant("raster: T - alpha T", I + "raster/raster.hpp", "alpha > 0.5f ?", "false ?"),
    Mutant("raster: the stop compares with <=", I + "raster/raster.hpp", "next < view.rules.stop_below",
           "next <= view.rules.stop_below"),
    Mutant("raster: stop_at_equal ignored", I + "view.hpp",
           "c.stop_at_equal ? std::nextafter(stop, 1.0f) : stop", "c.stop", quick=True),
    Mutant("raster: alpha_max 0.9901", I + "view.hpp", "return {c.alpha_min, c.alpha_max,",
           "return {c.alpha_min, c.alpha_max == 0.99f ? 0.9901f : c.alpha_max,"),
    Mutant("raster: alpha_max not cut", I + "raster/axis_shared.hpp", "return alpha < alpha_max_ ? alpha : alpha_max_;",
           "return alpha;"),
    Mutant("raster: an occluder hides only what is behind it", I + "raster/raster.hpp", "depth >= occluder.row",
           "depth > occluder.row"),
    Mutant("raster: per-pixel alpha_min compares with >", I + "raster/per_pixel.hpp", "alpha >= rules_.alpha_min",
           "alpha > rules_.alpha_min"),
    Mutant("raster: axis-shared alpha_min compares with >", I + "raster/axis_shared.hpp", "alpha >= rules_.alpha_min",
           "alpha > rules_.alpha_min"),
    Mutant("raster: threshold compares with <", I + "raster/axis_shared.hpp", "s >= 0 && s <= cutoff_",
           "s >= 0 && s < cutoff_"),
    Mutant("raster: threshold keeps a hundredth less", I + "raster/axis_shared.hpp", "s >= 0 && s <= cutoff_",
           "s >= 0 && s <= 0.99f * cutoff_"),
    Mutant("raster: per-pixel by the conic", I + "raster/per_pixel.hpp", "std::exp2(-(u * u + v * v))",
           "std::exp2(-(shape_.l0 * shape_.l0 * dx * dx + 2 * shape_.l0 * shape_.l1 * dx * dy +\n"
           "                             (shape_.l1 * shape_.l1 + shape_.l2 * shape_.l2) * dy * dy + 0 * (u + v)))"),
    Mutant("raster: exponential off by 1e-6 of log2_e", I + "raster/per_pixel.hpp", "std::exp2(-(u * u + v * v))",
           "std::exp2(-(u * u + v * v) * (1 + 1e-6f))",
           equivalent="moves alpha by at most 1e-6 / e, three roundings of ten that the gate allows"),
    Mutant("raster: float-split from the mean", I + "raster/exponents.hpp",
           "FloatSplit(const SplatShape& s, vec2 centre) : centre_(centre) {",
           "FloatSplit(const SplatShape& s, vec2 centre) : centre_(s.mean) {\n    centre = s.mean;"),
    Mutant("raster: float-split without the cut at 0", I + "raster/exponents.hpp", "return s < 0 ? 0 : s;", "return s;"),
    Mutant("raster: float-split a term short", I + "raster/exponents.hpp", "g_ = u * u + v * v;", "g_ = u * u;"),
    Mutant("raster: half-split a term short", I + "raster/exponents.hpp",
           "to_float(x.square) + to_float(y.square) + to_float(x.mixed) * to_float(y.offset)",
           "to_float(x.square) + to_float(y.square)"),
    Mutant("raster: background times alpha", I + "store_pixel.hpp", "pixel.transmittance * below", "alpha * below"),
    Mutant("raster: depth is not divided by alpha", I + "store_pixel.hpp", "alpha > 0 ? pixel.depth / alpha : 0.0f",
           "pixel.depth"),
    # The cpu backend's own arithmetic.
    Mutant("cpu project: camera space rounded to float", CPU + "project.cpp",
           "const Wide dx = Minus(Promote(mean.x), v.centre[0]), dy = Minus(Promote(mean.y), v.centre[1]);",
           "const Wide dx = Promote(Demote(Minus(Promote(mean.x), v.centre[0]))), "
           "dy = Promote(Demote(Minus(Promote(mean.y), v.centre[1])));"),
    Mutant("cpu project: z in float", CPU + "project.cpp", "const Wide inverse_z = Inverse(wide_z);",
           "const Wide inverse_z = Inverse(Promote(z));"),
    Mutant("cpu project: x/z and y/z in float", CPU + "project.cpp",
           "const Vec mean_x = Demote(ScaleAdd(x_over_z, v.fx, v.cx))",
           "const Vec mean_x = Demote(ScaleAdd(Promote(Demote(x_over_z)), v.fx, v.cx))"),
    Mutant("cpu project: needles in float", CPU + "project.cpp",
           "const bool any_in_double = !hn::AllFalse(d, in_double);", "const bool any_in_double = false;"),
    Mutant("cpu project: nearly parallel rows in float", CPU + "project.cpp",
           "hn::Le(hn::Add(xx, yy), hn::Set(d, float_tangent_squared))", "hn::Ge(xx, hn::Zero(d))"),
    Mutant("cpu project: a splat in double takes its neighbour's place", CPU + "project.cpp",
           "if (chosen_[k] != 0) *shapes = shapes_[k];\n      ++shapes;",
           "++shapes;\n      if (chosen_[k] != 0) *shapes = shapes_[k];"),
    Mutant("cpu project: blur times 1.0001", CPU + "project.cpp", "blur = hn::Set(d, v.blur);",
           "blur = hn::Set(d, v.blur * 1.0001f);"),
    Mutant("cpu project: blur times 1.001", CPU + "project.cpp", "blur = hn::Set(d, v.blur);",
           "blur = hn::Set(d, v.blur * 1.001f);"),
    *cpu_means(4096), *cpu_means(1024),
    Mutant("cpu project: to_base_2 off by 1e-6", CPU + "project.cpp", "hn::Set(d, float(to_base_2))",
           "hn::Set(d, float(to_base_2) + 1e-6f)"),
    Mutant("cpu project: min_compensation ignored", CPU + "project.cpp",
           "hn::Max(hn::Div(sharp, var_x_given_y), hn::Set(d, v.min_compensation))", "hn::Div(sharp, var_x_given_y)"),
    Mutant("cpu project: cutoff by natural logarithm", CPU + "project.cpp", "hn::CallLog2(d,", "hn::CallLog(d,"),
    Mutant("cpu project: opacities that are not finite are drawn", CPU + "project.cpp",
           "Mask visible = hn::And(hn::Ge(opacity, alpha_min), hn::Le(opacity, most));",
           "Mask visible = hn::Ge(opacity, alpha_min);"),
    Mutant("cpu project: an opacity of alpha_min is left out", CPU + "project.cpp",
           "hn::Ge(opacity, alpha_min), hn::Le(opacity, most)",
           "hn::Gt(opacity, alpha_min), hn::Le(opacity, most)"),
    Mutant("cpu project: z on the near plane left out", CPU + "project.cpp", "hn::Gt(z, hn::Set(d, v.near_plane))",
           "hn::Gt(z, hn::Set(d, v.near_plane * 1.0000003f))"),
    Mutant("cpu project: z on the far plane left out", CPU + "project.cpp", "hn::Le(z, hn::Set(d, v.far_plane))",
           "hn::Lt(z, hn::Set(d, v.far_plane))"),
    Mutant("cpu project: largest_variance 1e34", CPU + "project.cpp", "hn::Set(d, largest_variance)",
           "hn::Set(d, 1e34f)"),
    Mutant("cpu project: largest_variance 1e37", CPU + "project.cpp", "hn::Set(d, largest_variance)",
           "hn::Set(d, 1e37f)"),
    Mutant("cpu shade: direction without scaling", CPU + "shade.cpp",
           "direction = {hn::Div(direction.x, largest), hn::Div(direction.y, largest),\n                   "
           "hn::Div(direction.z, largest)};",
           "(void)largest;"),
    Mutant("cpu shade: colours that are not finite are drawn", I + "colours.hpp",
           "if (!(rgb[c] >= -most && rgb[c] <= most)) return {};", "(void)most;",
           "cpu", ("shade.cpp",)),
    Mutant("cpu shade: colours are not cut at 0", I + "colours.hpp", "rgb[c] > 0 ? rgb[c] : 0.0f", "rgb[c]", "cpu",
           ("shade.cpp",)),
    Mutant("cpu shade: the last coefficient is left out", CPU + "shade.cpp", "if (j < coefficients) {",
           "if (j + 1 < coefficients) {"),
    Mutant("cpu exp2: off by 2e-4", CPU + "exp2-inl.hpp", "6.9314700e-1f", "(6.9314700e-1f + 2e-4f)", sources=CHOLESKY),
    Mutant("cpu exp2: off by 1e-5", CPU + "exp2-inl.hpp", "6.9314700e-1f", "(6.9314700e-1f + 1e-5f)", sources=CHOLESKY),
    Mutant("cpu exp2: the third power's coefficient off by 2e-5", CPU + "exp2-inl.hpp", "5.5507336e-2f",
           "(5.5507336e-2f + 2e-5f)", sources=CHOLESKY),
    Mutant("cpu exp2: the fourth power's coefficient off by 4e-5", CPU + "exp2-inl.hpp", "9.6715130e-3f",
           "(9.6715130e-3f + 4e-5f)", sources=CHOLESKY),
    Mutant("cpu exp2: the fifth power's coefficient off by 8e-5", CPU + "exp2-inl.hpp", "1.3264726e-3f",
           "(1.3264726e-3f + 8e-5f)", sources=CHOLESKY),
    Mutant("cpu exp2: the square's coefficient off by 1e-5", CPU + "exp2-inl.hpp", "2.4022242e-1f",
           "(2.4022242e-1f + 1e-5f)",
           sources=PER_PIXEL),
    Mutant("cpu sort: keys of 30 bits", I + "splats.hpp", "depth_key_bits = 31", "depth_key_bits = 30", "cpu",
           ("sort.cpp", "intersections.cpp")),
    Mutant("cpu raster: rows compare with <", CPU + "raster-inl.hpp",
           "hn::Le(hn::MulAdd(nearest, nearest, hn::Mul(v, v)), hn::Set(d, shape.cutoff))",
           "hn::Lt(hn::MulAdd(nearest, nearest, hn::Mul(v, v)), hn::Set(d, shape.cutoff))", sources=CHOLESKY),
    Mutant("cpu raster: blocks a hundredth too narrow", CPU + "raster-inl.hpp",
           "hn::Sqrt(hn::Sub(c, hn::Set(d, log2_alpha_min - 1e-3f)))",
           "hn::Mul(hn::Sqrt(hn::Sub(c, hn::Set(d, log2_alpha_min - 1e-3f))), hn::Set(d, 0.99f))", sources=CHOLESKY),
    Mutant("cpu raster: two of a block's four rows are asked", CPU + "raster-inl.hpp",
           "return hn::Max(v, hn::Shuffle1032(v));", "return v;", sources=CHOLESKY),
    Mutant("cpu raster: T (1 - alpha)", CPU + "raster-inl.hpp", "hn::IfThenElse(hn::Gt(alpha, hn::Set(d, 0.5f)), product, difference)",
           "product", sources=CHOLESKY),
    Mutant("cpu raster: T - alpha T", CPU + "raster-inl.hpp", "hn::IfThenElse(hn::Gt(alpha, hn::Set(d, 0.5f)), product, difference)",
           "difference", sources=CHOLESKY),
    Mutant("cpu raster: the stop compares with <=", CPU + "raster-inl.hpp", "goes_on = hn::Ge(through, stop_below)",
           "goes_on = hn::Gt(through, stop_below)", sources=PER_PIXEL),
    Mutant("cpu raster: alpha is not cut", CPU + "raster-inl.hpp", "hn::Min(alpha, hn::Set(d, rules.alpha_max))", "alpha",
           sources=PER_PIXEL),
    Mutant("cpu raster: an occluder hides only what is behind it", CPU + "raster-inl.hpp",
           "hn::Ge(hn::Set(d, colour[3]), occluder)",
           "hn::Gt(hn::Set(d, colour[3]), occluder)", sources=PER_PIXEL),
    Mutant("cpu raster: alpha_min compares with >", CPU + "raster-inl.hpp",
           "hn::Ge(alpha, hn::Set(d, rules.alpha_min))",
           "hn::Gt(alpha, hn::Set(d, rules.alpha_min))", sources=PER_PIXEL),
    Mutant("cpu raster: cholesky alpha is not cut", CPU + "raster_float_cholesky.cpp",
           "alpha[i] = hn::Min(alpha[i], hn::Set(d, rules_.alpha_max))", "(void)i"),
    Mutant("cpu raster: split alpha is not cut", CPU + "split-inl.hpp",
           "hn::Min(alpha[0], hn::Set(d, rules_.alpha_max))", "alpha[0]", sources=SPLIT),
    Mutant("cpu raster: cholesky threshold compares with >", CPU + "raster_float_cholesky.cpp",
           "hn::Ge(alpha[i], hn::Set(d, rules_.log2_alpha_min))", "hn::Gt(alpha[i], hn::Set(d, rules_.log2_alpha_min))"),
    Mutant("cpu raster: per-pixel by the conic", CPU + "raster_per_pixel.cpp",
           "hn::Neg(hn::MulAdd(u, u, hn::Mul(v, v)))",
           "hn::Neg(hn::Add(hn::Add(hn::Mul(hn::Mul(hn::Set(d, splat.l0 * splat.l0), dx), dx),\n"
           "                             hn::Mul(hn::Mul(hn::Set(d, 2 * splat.l0 * splat.l1), dx), dy)),\n"
           "                             hn::MulAdd(hn::Mul(hn::Set(d, splat.l1 * splat.l1 + splat.l2 * splat.l2), "
           "dy), dy, hn::Mul(hn::Zero(d), hn::Add(u, v)))))"),
    Mutant("cpu raster: float-split from the mean", CPU + "raster_float_split.cpp",
           "const Vec from_centre = hn::Iota(d, float(i) - half_side);\n"
           "      hn::Store(hn::Mul(hn::MulAdd(a, from_centre, linear_x), from_centre), d, t.x_square + i);\n"
           "      hn::Store(hn::Mul(b, from_centre), d, t.x_mixed + i);\n"
           "      hn::Store(hn::MulAdd(hn::MulAdd(c, from_centre, linear_y), from_centre, constant), d, t.y_square + "
           "i);\n"
           "      hn::Store(from_centre, d, t.y_offset + i);",
           "const Vec x = hn::Iota(d, first_centre.x - shape.mean.x + float(i)), y = hn::Iota(d, first_centre.y - "
           "shape.mean.y + float(i));\n"
           "      hn::Store(hn::Mul(hn::Mul(a, x), x), d, t.x_square + i);\n"
           "      hn::Store(hn::Mul(b, x), d, t.x_mixed + i);\n"
           "      hn::Store(hn::Mul(hn::Mul(c, y), y), d, t.y_square + i);\n"
           "      hn::Store(y, d, t.y_offset + i);"),
    Mutant("cpu raster: float-split without the cut at 0", CPU + "raster_float_split.cpp",
           "return hn::IfThenZeroElse(hn::Lt(s, hn::Zero(F32())), s);", "return s;"),
    Mutant("cpu bounds: no slack", CPU + "footprints.cpp",
           "hn::Add(All(1e-2f), hn::Mul(All(1e-4f), hn::Add(half_width, half_height)))",
           "hn::Mul(All(0.0f), hn::Add(half_width, half_height))"),
    Mutant("cpu bounds: tiles_between a tile short", CPU + "footprints.cpp",
           "ClampedFloor(hn::Add(hn::Mul(last, inverse_side), All(1.0f)), among)",
           "ClampedFloor(hn::Mul(last, inverse_side), among)"),
    Mutant("cpu bounds: tiles_meeting a tile short", CPU + "footprints.cpp",
           "ClampedFloor(hn::Add(last, All(1.0f)), among)",
           "ClampedFloor(last, among)"),
    # The cuda backend.
    Mutant("cuda project: camera space in float", I + "project.hpp",
           "p[row] =\n          std::fma(v.rotation[row][0], d[0], std::fma(v.rotation[row][1], d[1], v.rotation[row][2] * d[2]));",
           "p[row] = float(std::fma(float(v.rotation[row][0]), float(d[0]), std::fma(float(v.rotation[row][1]), "
           "float(d[1]), float(v.rotation[row][2]) * float(d[2]))));",
           "cuda", STAGES),
    Mutant("cuda project: means on 1/4096 pixel", I + "project.hpp", "s.l0 = f.l0,",
           "s.mean = vec2(std::round(s.mean.x * 4096) / 4096, std::round(s.mean.y * 4096) / 4096);\n  s.l0 = f.l0,",
           "cuda", STAGES),
    Mutant("cuda project: means on 1/1024 pixel", I + "project.hpp", "s.l0 = f.l0,",
           "s.mean = vec2(std::round(s.mean.x * 1024) / 1024, std::round(s.mean.y * 1024) / 1024);\n  s.l0 = f.l0,",
           "cuda", STAGES),
    Mutant("cuda project: blur times 1.001", CUDA + "include/swiftgs/cuda/project.cuh",
           "splat = project_shape(views[0].camera, load_gaussian(scene, i));",
           "{\n    ViewConstants blurred = views[0].camera;\n    blurred.blur *= 1.001f;\n"
           "    splat = project_shape(blurred, load_gaussian(scene, i));\n  }", sources=STAGES),
    Mutant("cuda project: blur times 1.0001", CUDA + "include/swiftgs/cuda/project.cuh",
           "splat = project_shape(views[0].camera, load_gaussian(scene, i));",
           "{\n    ViewConstants blurred = views[0].camera;\n    blurred.blur *= 1.0001f;\n"
           "    splat = project_shape(blurred, load_gaussian(scene, i));\n  }", sources=STAGES),
    Mutant("cuda shade: c0 off by 2e-4", I + "sh.hpp", "inline constexpr double c0 = 0.28209479177387814;",
           "inline constexpr double c0 = 0.28209479177387814 + 2e-4;", "cuda", ("shade.cu",)),
    Mutant("cuda sort: depth key of one bit less", I + "splats.hpp",
           "return __builtin_bit_cast(std::uint32_t, depth);", "return __builtin_bit_cast(std::uint32_t, depth) & ~1u;",
           "cuda", STAGES + ("cuda.cu",)),
    Mutant("cuda exp2: off by 1e-5", CUDA + "arithmetic.hpp", "  return result;", "  return result * (1 + 1e-5f);",
           sources=WARPS),
    Mutant("cuda exp2: off by 2e-4", CUDA + "arithmetic.hpp", "  return result;", "  return result * (1 + 2e-4f);",
           sources=WARPS),
    Mutant("cuda raster: alpha_min compares with >", CUDA + "blending.hpp", "alpha >= exp2_approx(least)",
           "alpha > exp2_approx(least)", sources=WARPS),
    Mutant("cuda raster: threshold compares with >", CUDA + "blending.hpp", "exponent >= least", "exponent > least",
           sources=WARPS),
    Mutant("cuda raster: alpha is not cut", CUDA + "blending.hpp", "saturate(alpha * (kept ? 1.0f : 0.0f))",
           "alpha * (kept ? 1.0f : 0.0f)", sources=WARPS),
    Mutant("cuda raster: T (1 - alpha)", CUDA + "blending.hpp",
           "Pixel::dimmed_relative(left[p][k], weights[p][k], alpha_max)",
           "left[p][k] * (1 - alpha_max * alphas[p][k])", sources=WARPS),
    Mutant("cuda raster: colours stay in units of alpha_max", CUDA + "lane_blender.cuh",
           "multiply_rounded(pixel.colour[c], alpha_max)", "pixel.colour[c]", sources=WARPS),
    Mutant("cuda raster: depths stay in units of alpha_max", CUDA + "lane_blender.cuh",
           "multiply_rounded(pixel.depth, alpha_max)", "pixel.depth", sources=WARPS),
    Mutant("cuda segments: the transmittance before a segment is forgotten", CUDA + "blending.hpp",
           "total.w = before * segment.transmittance;", "total.w = segment.transmittance;", sources=WARPS),
    Mutant("cuda segments: pixels stop at the limit itself", CUDA + "blending.hpp",
           "scaled > 0 ? stop_below / scaled : 0.0f", "scaled > 0 ? stop_below : 0.0f", sources=WARPS),
    Mutant("cuda segments: all begin with the same transmittance", CUDA + "blending.hpp", "(k * 0x9e3779b9u) >> 9",
           "(k * 0u) >> 9", sources=WARPS),
    Mutant("cuda raster: an occluder hides only what is behind it", CUDA + "blending.hpp", "colour.w >= occluder",
           "colour.w > occluder", sources=WARPS),
    Mutant("cuda raster: warp blocks are left out a thousandth early", CUDA + "box_touched.hpp", "s.cutoff * 1.0001f",
           "s.cutoff * 0.999f", sources=WARPS),
    Mutant("cuda raster: per-pixel by the conic", CUDA + "exponents.hpp", "exp2_approx(-fmaf(u, u, v * v))",
           "exp2_approx(-(factor.x * factor.x * dx * dx + 2 * factor.x * factor.y * dx * dy +\n"
           "                                     (factor.y * factor.y + factor.z * factor.z) * dy * dy + 0 * (u + v)))",
           sources=("raster_per_pixel.cu",)),
    Mutant("cuda raster: float-split from the mean", CUDA + "exponents.hpp",
           "const float u = -fmaf(s.l0, mean.x, s.l1 * mean.y), v = -s.l2 * mean.y;", "const float u = 0, v = 0;",
           sources=("raster_float_split.cu",),
           also=(("make_float4(2 * s.l0 * u, 2 * fmaf(s.l1, u, s.l2 * v), h, 0)",
                  "make_float4(mean.x, mean.y, h, 0)"),
                 ("mixed = fmaf(terms.y, y, rest.x), row = fmaf(-y, fmaf(terms.z, y, rest.y), terms.w);",
                  "dy = y - rest.y, mixed = terms.y * dy, row = fmaf(-dy, terms.z * dy, terms.w);"),
                 ("const float at = x + right;", "const float at = x + right - rest.x;"))),
    # The reference.
    Mutant("reference: trials leave the factor as it is", I + "reference/variation.hpp",
           "nudge(factor.l0), nudge(factor.l1), nudge(factor.l2);", "", "reference"),
    Mutant("reference: trials keep pixels in double", I + "reference/conditioning.hpp",
           "std::array<PixelState<float>, trials> moved;", "std::array<PixelState<double>, trials> moved;", "reference"),
    Mutant("reference: planes compare in double", I + "reference/variation.hpp",
           "out.drawn = between_planes(float(splat->depth));",
           "out.drawn = splat->depth >= double(k.near_plane) && splat->depth <= double(k.far_plane);", "reference"),
    Mutant("reference: order by depth in double", I + "reference/conditioning.hpp",
           "return float(a.splat.depth) < float(b.splat.depth);", "return a.splat.depth < b.splat.depth;", "reference"),
    Mutant("reference: no blur of the determinant", I + "reference/projection.hpp",
           "det_sharp + blur * (xx + yy) + blur * blur", "det_sharp + blur * (xx + yy)", "reference"),
    Mutant("reference: inria's limit 1.31", I + "reference/lens.hpp", "limits_.most_u = 1.3 * half_x",
           "limits_.most_u = 1.31 * half_x", "reference"),
]
