# SPDX-License-Identifier: Apache-2.0
"""Defects that one program of the tests must notice: the stability tests draw nothing that has them.

Paths in `test` begin at the folder `tests` of a build.
"""
from mutant import In, defects

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
EXCHANGE = "mpi/launch -n 3 mpi/mpi_frames_test"
PLACED = "policies/contract_placed_test --test-case=*reference*Serial*"
CPU_PLACED = "policies/contract_placed_test --test-case=*reference*Cpu*"
TINT = "policies/contract_placed_test --test-case=tint*Serial*"
CPU_TINT = "policies/contract_placed_test --test-case=tint*Cpu*"
HARMONICS = "policies/contract_harmonics_test --test-case=*Serial*"
CPU_HARMONICS = "policies/contract_harmonics_test --test-case=*Cpu*"
PACKING = "policies/contract_harmonics_test"
REFERENCE = "reference/reference_test --test-case=*placed*"
CAMERAS = "cameras/cameras_test"

NAMED = [
    # Harmonics in fewer bytes.
    *defects("harmonics", In(I + "harmonics.hpp", test=HARMONICS),
        ("bytes have no sign", "static_cast<const [-signed-]{+unsigned+} char*>(values)[k]"),
        ("Gaussians of a palette have rows of their own", "return [-labels ? labels[i] : -]std::uint32_t(i);"),
        ("a range of a palette begins with its first label", "some.labels += [-first-]{+0+};")),
    *defects("harmonics", In(I + "harmonic_packing.hpp", test=PACKING),
        ("bytes go up to 128", "most <= [-127-]{+128+} * scale()"),
        ("halves have twelve digits", "return digits <= [-11-]{+12+} && lowest >= -24"),
        ("subnormal halves reach 2^-25", "digits <= 11 && lowest >= -[-24-]{+25+}"),
        ("palettes have 65,537 rows", "/ row, [-1 << 16-]{+(1 << 16) + 1+})")),
    *defects("cpu harmonics", In("backends/cpu/shade.cpp", test=CPU_HARMONICS),
        ("bytes have no scale", "hn::PromoteTo(integers, bytes)), hn::Set(F32x4(), [-scale-]{+0.5f+}))")),
    # Chunks.
    *defects("chunks", In(I + "chunks.hpp", test=CHUNKS),
        ("half the box 2e-4 too small", "half[k] = 0.[-5-]{+4999+} *"),
        ("the near plane 1e-4 too far", "most(0, 0, 1) <= {+1.0001f * +}v.near_plane "),
        ("the slack of projection left out", "wide_ = [-1.001 * of_x + 3e-4 * of_y-]{+of_x+}"),
        ("the farther limit of the Jacobian alone", "[-at_low > at_high ? at_low : -]at_high"),
        ("quaternions lengthen by their square alone", "return squares[- + std::fabs(1 - squares)-];"),
        ("half a lens's box 1e-2 too small", "[-1.001-]{+0.99+} * v.fx * seen.half_u"),
        ("splats through a lens are half as high", "high = {+0.5 * +}size * v.fy * seen.dv"),
        ("a panorama has one copy",
         "const double x = v.[-nearest_copy(v.fx * seen.u + v.cx)-]{+fx * seen.u + v.cx+};")),
    *defects("chunks", In(I + "lens/box.hpp", test=CHUNKS),
        ("a fisheye stretches nothing", "1.001 : [-furthest / std::sin(furthest)-]{+1.0+}"),
        ("the distortion grows nowhere in a box", "return {a.least() * a.least(), a.[-most-]{+least+}() * a.most()};")),
    # Picking.
    *defects("pick", In(I + "pick.hpp", test=PICKER),
        ("of equal weights the farthest Gaussian", "if (weight >{+=+} picked_.weight)", dict(quick=True)),
        ("the median takes the transmittance to one half",
         "before >[-= median_below && next <-]{+ median_below && next <=+} median_below"),
        ("nothing is looked at behind the median", "next >= median_below[- || next > picked_.weight-]")),
    # Planes.
    *defects("planes", In(I + "plane/picks.hpp", test=PLANES),
        ("of equal weights the farthest Gaussian", "if (splat_weight >{+=+} weight)"),
        ("the median takes the transmittance to one half", "transmittance <{+=+} median_below"),
        ("the first depth is of the last splat", "[-first == none && -]transmittance < first_below")),
    *defects("planes", In(I + "plane/normal.hpp", test=PLANES),
        ("of equally short axes the last is the normal", "scale.z <{+=+} scale[first]"),
        ("normals of an orthographic lens face its centre", "[-if (v.lens.model != LensModel::orthographic) -]{")),
    *defects("planes", In(I + "plane/attributes.hpp", test=PLANES),
        ("squared depths are not divided by alpha", "[-alpha > 0 ? sum / alpha : 0.0f-]{+sum+}")),
    *defects("planes", In(I + "attribute_stage.hpp", test=PLANES),
        ("features that are not finite are drawn", "[-!finite ? 0.0f : -]")),
    *defects("planes", In(I + "attribute_stage.hpp", test=FRAMES),
        ("attributes beyond those of one rasterization are left out", "first < [-count-]{+1+}; first += most")),
    *defects("planes", In(I + "plane/attributes.hpp", test=FRAMES),
        ("five attributes are summed in one row", "AttributeRow::channels - [-1-]{+2+}) / ")),
    *defects("planes", In(I + "raster/raster.hpp", test=FRAMES),
        ("a pixel remembers the largest alpha", "offer(id, [-weight-]{+alpha+}, next,")),
    *defects("planes", In(I + "view.hpp", test=FRAMES),
        ("the first alpha is 0.05 whatever is asked", "[-1 - c.first_alpha-]{+0.95f+}")),
    *defects("ray depth", In(I + "plane/ray_depth.hpp", test=PLANES),
        ("squares have half of a mixed term", "2 * x, 2 * y, x, [-2 * -]y, y"),
        ("blur does not lessen slopes", "[- + blur * (uu + ww + blur)-]"),
        ("slopes are not limited", "if ({+false && +}!is_summed(")),
    *defects("ray depth", In(I + "raster/raster.hpp", test=FRAMES),
        ("an occluder before a centre ends the pixel", "([-!along_ray && -]occluded("),
        ("picked splats have the depth of their centres", "[-if (!view.camera.depth_along_ray) -]return;")),
    *defects("ray depth", In(I + "attribute_stage.hpp", test=FRAMES),
        ("later attributes take the place of depths", "if (count > {+2 * +}most) {")),
    # Placed scenes.
    *defects("placed", In(I + "placed_scene.hpp", test=PLACED),
        ("the eye's centre is not divided by the scale",
         "along / [-(world_from_scene.scale * dot(across, axis))-]{+dot(across, axis)+}"),
        ("a rotation's inverse is its transpose",
         ("const dvec3 across = [-cross(a, b)-]{+axis+};",
          "[-(world_from_scene.scale * dot(across, axis))-]{+world_from_scene.scale+}")),
        ("depths are the scene's own", "[-out.depth_scale = pose.scale;-]"),
        ("the opacity counts for nothing", "[-out.opacity = placed.opacity, -]out.follow"),
        ("parallel rays lie as far apart in every scene", "? of_camera [-* world_from_scene.scale -]: of_camera"),
        ("the axes that splats are projected by are the world's",
         "[-out.axes[row][column] = float(out.rotation[row][column]);-]"),
        ("each scene numbers its Gaussians from 0", "placed.first_gaussian = [-std::uint32_t(gaussians)-]{+0+}"),
        ("Gaussians are those of the scene behind an empty one", "(each[middle].*first <[-=-] number ? low : high)"),
        ("a view shows the frame's first scenes", "return {each().data[- + first-],")),
    *defects("placed", In(I + "project_stage.hpp", test=PLACED),
        ("clips count for nothing", "[-clip.shows(scene.means[i])-]{+true+} ?")),
    *defects("placed", In(I + "tint.hpp", test=TINT),
        ("a tint adds its colour", "fma(amount, colour[c], [-(1 - amount) * -]from[c])"),
        ("a tint has one channel's colour", "colour[[-c-]{+0+}]")),
    *defects("placed", In(I + "shade_stage.hpp", test=TINT),
        ("a tint shows hidden splats", "SplatColour{tint.mixed_into(colour.rgb), [-colour.depth-]{+1.0f+}}"),
        ("tints count for nothing", "colours[i] = [-tinted(colour, seen.tint)-]{+colour+};")),
    *defects("placed", In(I + "clip.hpp", test=PLACED),
        ("a sphere shows what touches twice its radius", "<= {+4 * +}radius * radius"),
        ("of half-spaces the last is left out", "i < half_space_count{+ - 1+}; ++i) {\n      const vec4")),
    *defects("placed", In(I + "plane/ray_depth.hpp", test=PLACED),
        ("depth along the ray slopes as in the scene", "dvec3(0.0, 0.0, [-v.depth_scale-]{+1.0+})"),
        ("distances along the ray slope as in the scene", "p * ([-v.depth_scale-]{+1+} / std::sqrt(dot(p, p)))")),
    *defects("placed", In(I + "chunks.hpp", test=CPU_PLACED),
        ("chunks lie before the near plane of the scene", "[-v.depth_scale * -]most(0, 0, 1) <= v.near_plane"),
        ("chunks lie behind the far distance of the scene", "0.998 * [-scale * -]std::sqrt(nearest)")),
    *defects("cpu placed", In("backends/cpu/project.cpp", test=CPU_PLACED),
        ("clips count for nothing", "[-if (!clip.shows_all()) visible = hn::And(visible, group.Shown(clip));-]"),
        ("depths are the scene's own", "Demote([-Times(wide_z, v.depth_scale)-]{+wide_z+})"),
        ("depths through lenses are the scene's own",
         "Demote[-(Times-](v.depth_is_distance ? Wide{distance(low), distance(high)} : z[-, v.depth_scale-])[-)-]"),
        ("the opacity counts for nothing",
         "hn::[-Mul(hn::LoadU(d, group.opacities), hn::Set(d, v.opacity))-]{+LoadU(d, group.opacities)+}")),
    *defects("cpu placed", In("backends/cpu/shade.cpp", test=CPU_PLACED),
        ("harmonics are seen from the camera in the world",
         "([-eye(plan.views[view].camera, placed)-]{+plan.views[view].camera+}, placed.scene,")),
    *defects("cpu placed", In("backends/cpu/shade.cpp", test=CPU_TINT),
        ("tints count for nothing", "[-tinted(splat, tint)-]{+splat+}")),
    *defects("reference", In("backends/reference/projection.hpp", test=TINT),
        ("a tint is mixed into colours before they are cut",
         "splat.colour[c] = [-(1 - amount) * std::max(sum[c], 0.0) + amount * double(tint.colour[c])-]"
         "{+std::max((1 - amount) * sum[c] + amount * double(tint.colour[c]), 0.0)+};")),
    *defects("reference", In("backends/reference/projection.hpp", test=REFERENCE),
        ("the camera's centre in a placed scene is not divided by its scale", "translation[- / scale-];"),
        ("placed Gaussians are as large as in their scenes", "return view.[-scale * view.-]rotation * axes")),
    # Vectors of the Cpu.
    *defects("cpu ray depth", In("backends/cpu/ray-inl.hpp", test=CPU_FRAMES),
        ("an occluder hides by the depth in the middle of the image",
         "hn::[-Add(hn::Set(d, depth.middle), across)-]{+Set(d, depth.middle)+}")),
    *defects("cpu project", In("backends/cpu/project.cpp", test=CPU),
        ("needles through lenses in float",
         "hn::[-Le(length, MostLengthInFloat(mean_x, mean_y))-]{+Eq(length, length)+}")),
    *defects("cpu project", In("backends/cpu/doubles-inl.hpp", test=CPU),
        ("angles of 1e-7", "return hn::CopySign([-turn-]{+(turn * (1 + 1e-7))+}.v, y.v);")),
    *defects("cpu pick", In("backends/cpu/pick-inl.hpp", test=CPU),
        ("of equal weights the farthest Gaussian",
         "for (std::size_t i = [-of.size; i-- > 0;-]{+0; i < of.size; ++i+})"),
        ("of equal weights that of the later batch", "found = hn::[-Gt-]{+Ge+}(most, weight)"),
        ("one half is below the limit", "hn::[-Ge-]{+Gt+}(through, half)"),
        ("a pixel that stopped crosses all limits", "after = [-hn::Abs-](")),
    *defects("cpu planes", In("backends/cpu/sum-inl.hpp", test=CPU),
        ("attributes of the first splat", "state.values[of.list[[-i-]{+0+}]]")),
    *defects("cpu planes", In("backends/cpu/blend-inl.hpp", test=CPU),
        ("a row alone has attributes of the first splat", "attributes->values[list[[-i-]{+0+}]]")),
    *defects("cpu planes", In("backends/cpu/sum-inl.hpp", test=CPU_FRAMES),
        ("features of a row are those of the one before",
         "hn::Load(d4, rows[[-(i + k) / of_row-]{+k / of_row / 2+}][pixel])")),
    *defects("cpu pick", In("backends/cpu/pick-inl.hpp", test=CPU_FRAMES),
        ("pixels without a splat show the first",
         "[-hn::IfThenElse(hn::RebindMask(d, some), gathered, values)-]{+gathered+}")),
    # Edits.
    *defects("edit", In(I + "edit/order.hpp", test=EDIT),
        ("the last bit of a cell is lost", "[-0x1249249249249249-]{+0x1249249249249248+}")),
    *defects("edit", In(I + "edit/select.hpp", test=EDIT),
        ("a box is open at its lower border along y", "p.y >[-=-] low.y"),
        ("a sphere measures y from z of its centre", "p.y - centre.[-y-]{+z+}"),
        ("regions are relative to the origin", "region.contains([-scene.origin + -]dvec3("),
        ("a scene is appended with the means of its own origin", "[-scene.origin != more.origin-]{+false+})")),
    *defects("edit", In(I + "edit/transform.hpp", test=EDIT),
        ("harmonics up to 2e38 are rotated", "coefficient < [-1e38f-]{+2e38f+}"),
        ("a stretch leaves harmonics where they were", "origin, [-rotation-]{+dmat3(1.0)+}, detail::upright")),
    *defects("edit", In(I + "edit/origin.hpp", test=EDIT),
        ("an origin is the last position", "values.[-begin() + std::ptrdiff_t(count / 2)-]{+end() - 1+}")),
    # Bands and the exchange of splats.
    *defects("strips", In("backends/mpi/strips.cpp", test=BANDS),
        ("cuts move from a fifth on", "[-20 * slowest > 21-]{+10 * slowest > 12+} *"),
        ("the row in which the sum passes goes to the later rank", "before + costs[row] [-/ 2 -]< wanted")),
    *defects("exchange", In("backends/mpi/include/swiftgs/mpi/exchange_loops.hpp", test=EXCHANGE),
        ("splats of later ranks are not noted as hidden", "if ({+i >= at || +}!is_hidden(joined[i])) return;")),
    *defects("exchange", In("backends/mpi/include/swiftgs/mpi/renderer.hpp", test=EXCHANGE),
        ("a rank's own splats count as sent", "mine.sent = shares_.begins.back()[- - shares_.count_for(own)-];")),
    # Frames.
    *defects("hidden", In(I + "hidden_intersections.hpp", test=HIDDEN),
        ("a splat at the occluder's depth is not counted", "job.splats.depths[id] <{+=+} depth")),
    *defects("conversion", In(I + "store_pixel.hpp", test=CONVERSION),
        ("the image below is taken as it is",
         "frame.over ? [-load_below-]{+load_colour+}(frame, x, y) : vec4(background, 0)"),
        ("premultiplied colours go through the curve", "const float straight = channel[- / alpha-];")),
    # Cameras of other renderers, and where to look.
    *defects("camera matrices", In(I + "camera_matrices.hpp", test=CAMERAS),
        ("jitter moves the image the other way", "0.5 * width * (1 [-+-]{+-+} forward * m[0][2])"),
        ("a flipped y turns no axis", "std::copysign(1, down[- * m[1][1]-])"),
        ("OpenGL has the depth of Vulkan", "[-if (clip == ClipSpace::opengl) a = 0.5 * (a + 1), b = 0.5 * b;-]"),
        ("images of OpenGL begin with the top row", "[-host.bottom_row_first = clip == ClipSpace::opengl;-]"),
        ("depths of a frame lie from the bottom row down", "down.from(0, camera.height - 1).data, [---]down.pitch")),
    *defects("orbit", In(I + "orbit.hpp", test=CAMERAS),
        ("the camera rises about an axis that did not turn",
         "turned(turned(axis, [-right, -rise), up, turn-]{+up, turn), right, -rise+})")),
    *defects("bounds", In(I + "scene_bounds.hpp", test=CAMERAS),
        ("strays count", "constexpr double outside = 0[-.02-];")),
    *defects("half size", In(I + "half_size_occluder.hpp", test=CAMERAS),
        ("the nearest of four pixels hides", "std::[-max-]{+min+}(farthest, depth)")),
    # Files.
    *defects("spz", In("backends/io/spz_encode.cpp", test="io/io_scene_test"),
        ("bytes that are rounded to the ends count as clamped",
         "!(value > [--0.5f && value < 255.5f-]{+0 && value < 255+});\n    *to_++")),
    # The interface of C.
    *defects("c", In("backends/c/view.cpp", test="c/c_test each_convention"),
        ("the limits of the Jacobian are gsplat's", "[-  to.clamp = Conventions::JacobianClamp(from.clamp);\n-]")),
]
