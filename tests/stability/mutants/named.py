# SPDX-License-Identifier: Apache-2.0
"""Defects that one program of the tests must notice: the stability tests draw nothing that has them.

Paths in `test` begin at the folder `tests` of a build.
"""
from mutant import Mutant

I = "include/swiftgs/"
EDIT = "edit/edit_test"
CHUNKS = "policies/chunk_borders_test"
CPU = "policies/cpu_test"
PICKER = "policies/pixel_picker_test"
PLANES = "policies/plane_arithmetic_test"
FRAMES = "policies/contract_planes_test --test-case=*Serial*"
CPU_FRAMES = "policies/contract_planes_test --test-case=*Cpu*"
HIDDEN = "policies/contract_test --test-case=hidden*Serial*"
CONVERSION = "policies/contract_test --test-case=conversion*Serial*"
BANDS = "mpi/mpi_strips_test"

NAMED = [
    # Chunks.
    Mutant("chunks: half the box 2e-4 too small", I + "chunks.hpp", "half[k] = 0.5 *", "half[k] = 0.4999 *",
           test=CHUNKS, quick=True),
    Mutant("chunks: the near plane 1e-4 too far", I + "chunks.hpp", "most(0, 0, 1) <= v.near_plane ",
           "most(0, 0, 1) <= 1.0001f * v.near_plane ", test=CHUNKS, quick=True),
    Mutant("chunks: the slack of projection left out", I + "chunks.hpp", "wide_ = 1.001 * of_x + 3e-4 * of_y",
           "wide_ = of_x", test=CHUNKS),
    Mutant("chunks: the farther limit of the Jacobian alone", I + "chunks.hpp", "at_low > at_high ? at_low : at_high",
           "at_high", test=CHUNKS),
    Mutant("chunks: quaternions lengthen by their square alone", I + "chunks.hpp",
           "return squares + std::fabs(1 - squares);", "return squares;", test=CHUNKS),
    Mutant("chunks: half a lens's box 1e-2 too small", I + "chunks.hpp", "1.001 * v.fx * seen.half_u",
           "0.99 * v.fx * seen.half_u", test=CHUNKS),
    Mutant("chunks: splats through a lens are half as high", I + "chunks.hpp", "high = size * v.fy * seen.dv",
           "high = 0.5 * size * v.fy * seen.dv", test=CHUNKS),
    Mutant("chunks: a fisheye stretches nothing", I + "lens/box.hpp", "1.001 : furthest / std::sin(furthest)",
           "1.001 : 1.0", test=CHUNKS),
    Mutant("chunks: the distortion grows nowhere in a box", I + "lens/box.hpp",
           "return {a.least() * a.least(), a.most() * a.most()};", "return {a.least() * a.least(), a.least() * a.most()};",
           test=CHUNKS),
    Mutant("chunks: a panorama has one copy", I + "chunks.hpp", "const double x = v.nearest_copy(v.fx * seen.u + v.cx);",
           "const double x = v.fx * seen.u + v.cx;", test=CHUNKS),
    # Picking.
    Mutant("pick: of equal weights the farthest Gaussian", I + "pick.hpp", "if (weight > picked_.weight)",
           "if (weight >= picked_.weight)", test=PICKER),
    Mutant("pick: the median takes the transmittance to one half", I + "pick.hpp",
           "before >= median_below && next < median_below", "before > median_below && next <= median_below", test=PICKER),
    Mutant("pick: nothing is looked at behind the median", I + "pick.hpp",
           "next >= median_below || next > picked_.weight", "next >= median_below", test=PICKER),
    # Planes.
    Mutant("planes: of equal weights the farthest Gaussian", I + "plane/picks.hpp", "if (splat_weight > weight)",
           "if (splat_weight >= weight)", test=PLANES),
    Mutant("planes: the median takes the transmittance to one half", I + "plane/picks.hpp",
           "transmittance < median_below", "transmittance <= median_below", test=PLANES),
    Mutant("planes: the first depth is of the last splat", I + "plane/picks.hpp",
           "first == none && transmittance < first_below", "transmittance < first_below", test=PLANES),
    Mutant("planes: of equally short axes the last is the normal", I + "plane/normal.hpp",
           "scale.z < scale[first]", "scale.z <= scale[first]", test=PLANES),
    Mutant("planes: normals of an orthographic lens face its centre", I + "plane/normal.hpp",
           "if (v.lens.model != LensModel::orthographic) {", "{", test=PLANES),
    Mutant("planes: squared depths are not divided by alpha", I + "plane/attributes.hpp",
           "alpha > 0 ? sum / alpha : 0.0f", "sum", test=PLANES),
    Mutant("planes: features that are not finite are drawn", I + "attribute_stage.hpp",
           "!finite ? 0.0f : ", "", test=PLANES),
    Mutant("planes: attributes beyond those of one rasterization are left out", I + "attribute_stage.hpp",
           "first < count; first += most", "first < 1; first += most", test=FRAMES),
    Mutant("planes: five attributes are summed in one row", I + "plane/attributes.hpp",
           "attributes <= int(AttributeRow::channels)", "attributes <= int(AttributeRow::channels) + 1", test=FRAMES),
    Mutant("planes: a pixel remembers the largest alpha", I + "raster/raster.hpp",
           "offer(id, weight, next,", "offer(id, alpha, next,", test=FRAMES),
    Mutant("planes: the first alpha is 0.05 whatever is asked", I + "view.hpp", "1 - c.first_alpha", "0.95f",
           test=FRAMES),
    Mutant("ray depth: squares have half of a mixed term", I + "plane/ray_depth.hpp", "2 * x, 2 * y, x, 2 * y, y",
           "2 * x, 2 * y, x, y, y", test=PLANES),
    Mutant("ray depth: blur does not lessen slopes", I + "plane/ray_depth.hpp", " + blur * (uu + ww + blur)", "",
           test=PLANES),
    Mutant("ray depth: slopes are not limited", I + "plane/ray_depth.hpp", "if (!is_summed(", "if (false && !is_summed(",
           test=PLANES),
    Mutant("ray depth: an occluder before a centre ends the pixel", I + "raster/raster.hpp",
           "(!along_ray && occluded(", "(occluded(", test=FRAMES),
    Mutant("ray depth: later attributes take the place of depths", I + "attribute_stage.hpp",
           "(first == 0 ? 0 : job.splats.size())", "0", test=FRAMES),
    Mutant("ray depth: picked splats have the depth of their centres", I + "raster/raster.hpp",
           "if (!view.camera.depth_along_ray) return;", "return;", test=FRAMES),
    # Vectors of the Cpu.
    Mutant("cpu ray depth: an occluder hides by the depth in the middle of the image", "backends/cpu/ray-inl.hpp",
           "hn::Add(hn::Set(d, depth.middle), across)", "hn::Set(d, depth.middle)", test=CPU_FRAMES),
    Mutant("cpu project: needles through lenses in float", "backends/cpu/project.cpp",
           "hn::Le(length, MostLengthInFloat(mean_x, mean_y))", "hn::Eq(length, length)", test=CPU),
    Mutant("cpu project: angles of 1e-7", "backends/cpu/doubles-inl.hpp", "return hn::CopySign(turn.v, y.v);",
           "return hn::CopySign((turn * (1 + 1e-7)).v, y.v);", test=CPU),
    Mutant("cpu pick: of equal weights the farthest Gaussian", "backends/cpu/pick-inl.hpp",
           "for (std::size_t i = of.size; i-- > 0;)", "for (std::size_t i = 0; i < of.size; ++i)", test=CPU),
    Mutant("cpu pick: of equal weights that of the later batch", "backends/cpu/pick-inl.hpp",
           "found = hn::Gt(most, weight)", "found = hn::Ge(most, weight)", test=CPU),
    Mutant("cpu planes: attributes of the first splat", "backends/cpu/sum-inl.hpp",
           "state.values[of.list[i]]", "state.values[of.list[0]]", test=CPU),
    Mutant("cpu pick: one half is below the limit", "backends/cpu/pick-inl.hpp",
           "hn::Ge(through, half)", "hn::Gt(through, half)", test=CPU),
    Mutant("cpu pick: a pixel that stopped crosses all limits", "backends/cpu/pick-inl.hpp",
           "after = hn::Abs(", "after = (", test=CPU),
    # Edits.
    Mutant("edit: the last bit of a cell is lost", I + "edit/order.hpp", "0x1249249249249249", "0x1249249249249248",
           test=EDIT),
    Mutant("edit: a box is open at its lower border along y", I + "edit/select.hpp", "p.y >= low.y", "p.y > low.y",
           test=EDIT),
    Mutant("edit: a sphere measures y from z of its centre", I + "edit/select.hpp", "p.y - centre.y", "p.y - centre.z",
           test=EDIT, quick=True),
    Mutant("edit: harmonics up to 2e38 are rotated", I + "edit/transform.hpp", "coefficient < 1e38f",
           "coefficient < 2e38f", test=EDIT),
    Mutant("edit: regions are relative to the origin", I + "edit/select.hpp",
           "region.contains(scene.origin + dvec3(", "region.contains(dvec3(", test=EDIT),
    Mutant("edit: a scene is appended with the means of its own origin", I + "edit/select.hpp",
           "scene.origin != more.origin)", "false)", test=EDIT),
    Mutant("edit: an origin is the last position", I + "edit/origin.hpp",
           "values.begin() + std::ptrdiff_t(values.size() / 2)", "values.end() - 1", test=EDIT),
    # Bands and the exchange of splats.
    Mutant("strips: cuts move from a fifth on", "backends/mpi/strips.cpp", "20 * slowest > 21 *",
           "10 * slowest > 12 *", test=BANDS),
    Mutant("strips: the row in which the sum passes goes to the later rank", "backends/mpi/strips.cpp",
           "before + costs[row] / 2 < wanted", "before + costs[row] < wanted", test=BANDS),
    Mutant("exchange: splats of later ranks are not noted as hidden",
           "backends/mpi/include/swiftgs/mpi/exchange_loops.hpp", "if (!is_hidden(joined[i])) return;",
           "if (i >= at || !is_hidden(joined[i])) return;", test="mpi/launch -n 3 mpi/mpi_frames_test"),
    Mutant("exchange: a rank's own splats count as sent", "backends/mpi/include/swiftgs/mpi/renderer.hpp",
           "mine.sent = shares_.begins.back() - shares_.count_for(own);", "mine.sent = shares_.begins.back();",
           test="mpi/launch -n 3 mpi/mpi_frames_test"),
    # Frames.
    Mutant("hidden: a splat at the occluder's depth is not counted", I + "hidden_stage.hpp",
           "job.splats.depths[job.lists.ids[middle]] >= depth", "job.splats.depths[job.lists.ids[middle]] > depth",
           test=HIDDEN),
    Mutant("conversion: the image below is taken as it is", I + "store_pixel.hpp",
           "frame.over ? load_below(frame, x, y) : vec4(background, 0)",
           "frame.over ? load_colour(frame, x, y) : vec4(background, 0)", test=CONVERSION),
    Mutant("conversion: premultiplied colours go through the curve", I + "store_pixel.hpp",
           "const float straight = channel / alpha;", "const float straight = channel;", test=CONVERSION),
    # Files.
    Mutant("spz: bytes that are rounded to the ends count as clamped", "backends/io/spz_encode.cpp",
           "!(value > -0.5f && value < 255.5f);\n    *to_++", "!(value > 0 && value < 255);\n    *to_++",
           test="io/io_scene_test"),
    # The interface of C.
    Mutant("c: the limits of the Jacobian are gsplat's", "backends/c/view.cpp",
           "  to.clamp = Conventions::JacobianClamp(from.clamp);\n", "", test="c/c_test each_convention"),
]
