#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the conformance set: tests/conformance/make_set.py OUT [--swiftgs PATH]

Scenes and cameras come from clauses.py. With --swiftgs the tool's float64 reference draws the expected image of each
clause by each preset, OUT/NAME/PRESET.npz, and OUT/sheet.png shows all of them; without it the images that lie in OUT
stay as they are. Needs NumPy.
"""
import argparse
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np

import reference
from clauses import clauses, camera, padding

SIDE = 64
VERSION = "1.0"
LICENCE = """The conformance set of SwiftGS, which is all files of this folder.

To the extent possible under law, its authors have waived all copyright and related or neighbouring rights to it:
CC0 1.0 Universal, https://creativecommons.org/publicdomain/zero/1.0/
"""
VARIANTS = [
    *[(f"blur {blur:g}", {"blur": blur}) for blur in (0.0, 0.075, 0.1, 0.3)],
    ("compensation", {"antialiased": True}), ("no compensation", {"antialiased": False}),
    ("order by z", {"order": "depth"}), ("order by distance", {"order": "distance"}),
    ("linear colours", {"colours": "linear"}), ("sRGB colours", {"colours": "srgb"}),
    *[(f"near plane {near:g}", {"near_plane": near}) for near in (0.0, 0.01, 0.1, 0.2)],
    *[(f"alphas from 1/{n}", {"alpha_min": 1 / n}) for n in (2**24, 512, 255)],
    *[(f"alphas to {most:g}", {"alpha_max": most}) for most in (0.99, 0.999, 1.0)],
    *[(f"stop at {stop:g}", {"stop": stop}) for stop in (0.0, 1e-4, 1e-3, 1 / 255)],
    ("clamp around the image", {"clamp": "around_image"}), ("clamp around the centre", {"clamp": "around_centre"}),
    ("ends by alpha", {"footprint": "alpha"}), ("ends at a square of 3 sigmas", {"footprint": "three_sigma_square"}),
    ("ends at 3 sigmas", {"footprint": "three_sigma_ellipse"})]
# What no conventions of the library express; reference.py does.
DEPARTURES = [
    ("ends at 2.83 sigmas", {"footprint": "root_eight_ellipse"}), ("falls to 0 at 2.83 sigmas", {"falls_to_0": True}),
    ("no clamp", {"clamp": "none"}), ("colours cut at 1", {"most_colour": 1.0}),
    ("the file's first in front", {"order": "first"}), ("the file's last in front", {"order": "last"}),
    ("blended in decoded colours", {"colours": "decoded"}),
    *[(f"harmonics to degree {degree}", {"most_degree": degree}) for degree in (0, 1, 2)],
    *[(f"means left out beyond {most:g} images", {"most_off_screen": most}) for most in (1.0, 1.2, 1.3, 1.4)],
    *[(f"splats below {least:g} pixels left out", {"least_pixels": least}) for least in (2.0, 4.0)],
    ("level splats left out", {"leaves_out_level": True})]


def ply_of(gaussians, antialiased):
    """INRIA's PLY, with harmonics where a Gaussian has some. An opacity of 1 has the logit 30, whose sigmoid is 1."""
    rest = 45 if any(g["rest"] for g in gaussians) else 0
    names = ["x", "y", "z", "nx", "ny", "nz", *[f"f_dc_{k}" for k in range(3)], *[f"f_rest_{k}" for k in range(rest)],
             "opacity", *[f"scale_{k}" for k in range(3)], *[f"rot_{k}" for k in range(4)]]
    lines = ["ply", "format binary_little_endian 1.0", *(["comment SplatRenderMode: mip"] if antialiased else []),
             f"element vertex {len(gaussians)}", *[f"property float {name}" for name in names], "end_header", ""]
    out = "\n".join(lines).encode()
    for g in gaussians:
        harmonics = [0.0] * rest
        for (k, channel), value in g["rest"].items():
            harmonics[15 * channel + k - 1] = value
        logit = math.log(g["opacity"] / (1 - g["opacity"])) if g["opacity"] < 1 else 30.0
        out += struct.pack(f"<{len(names)}f", *g["mean"], 0, 0, 0, *coefficients(g), *harmonics, logit,
                           *map(math.log, g["scales"]), *g["rotation"])
    return out


def coefficients(gaussian):
    return [(c - 0.5) / 0.28209479177387814 for c in gaussian["colour"]]


def glb_of(gaussians, colours):
    """KHR_gaussian_splatting, whose x points left and whose y points up."""
    khr, space = "KHR_gaussian_splatting", {"linear": "lin_rec709_display"}[colours]

    def turned(w, x, y, z):
        return -z, y, -x, w  # half a turn about z before the rotation, as (x, y, z, w)
    columns = {"POSITION": [(-g["mean"][0], -g["mean"][1], g["mean"][2]) for g in gaussians],
               f"{khr}:ROTATION": [turned(*g["rotation"]) for g in gaussians],
               f"{khr}:SCALE": [g["scales"] for g in gaussians],
               f"{khr}:OPACITY": [(g["opacity"],) for g in gaussians],
               f"{khr}:SH_DEGREE_0_COEF_0": [coefficients(g) for g in gaussians]}
    data, views, accessors = b"", [], []
    for values in columns.values():
        packed = b"".join(struct.pack(f"<{len(value)}f", *value) for value in values)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
        accessors.append({"bufferView": len(accessors), "componentType": 5126, "count": len(values),
                          "type": ["SCALAR", "VEC2", "VEC3", "VEC4"][len(values[0]) - 1]})
        data += packed
    accessors[0] |= {name: [float(np.float32(choose(p[k] for p in columns["POSITION"]))) for k in range(3)]
                     for name, choose in (("min", min), ("max", max))}
    said = {"kernel": "ellipse", "colorSpace": space, "sortingMethod": "cameraDistance", "projection": "perspective"}
    primitive = {"mode": 0, "attributes": dict(zip(columns, range(5))), "extensions": {khr: said}}
    text = json.dumps({"asset": {"version": "2.0"}, "extensionsUsed": [khr], "scene": 0, "scenes": [{"nodes": [0]}],
                       "nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}], "accessors": accessors,
                       "bufferViews": views, "buffers": [{"byteLength": len(data)}]}, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON")
            + text + struct.pack("<I4s", len(data), b"BIN\0") + data)


def made(side):
    """The rows of the manifest, and {path: bytes} of scenes and cameras."""
    rows, files = [], {"LICENSE": LICENCE.encode()}
    for name, meaning, gaussians, given in clauses(side):
        view, colours = given.get("camera", camera(side)), given.get("colours")
        if given.get("padded", True):
            gaussians = gaussians + padding(view)
        row = {"name": name, "meaning": meaning, "scene": f"{name}/scene.{'glb' if colours else 'ply'}",
               "cameras": f"{name}/cameras.json"}
        row |= {member: given[member] for member in ("background", "silent") if member in given}
        files[row["scene"]] = glb_of(gaussians, colours) if colours else ply_of(gaussians, given.get("antialiased"))
        files[row["cameras"]] = (json.dumps([view]) + "\n").encode()
        rows.append(row)
    return rows, files


def manifest_of(rows, layers, presets, side):
    """The manifest's bytes. `layers` and `presets`: {name of a clause: most layers, {preset: file}}."""
    def lines(members):
        return "[\n" + ",\n".join(f"  {json.dumps(member, ensure_ascii=False)}" for member in members) + "\n ]"

    def named(variants):
        return lines({"name": name, "conventions": conventions} for name, conventions in variants)
    rows = lines({**row, "layers": layers[row["name"]], "presets": presets[row["name"]]} for row in rows)
    return (f'{{\n "version": "{VERSION}",\n "licence": "CC0-1.0",\n "side": {side},\n "clauses": {rows},\n'
            f' "variants": {named(VARIANTS)},\n "departures": {named(DEPARTURES)}\n}}\n').encode()


def layers_of(out, rows):
    """Most splats that any preset blends in one pixel, by the name of the clause."""
    def count(row, preset):
        scene, view = reference.read_scene(out / row["scene"]), reference.read_camera(out / row["cameras"])
        return reference.render(scene, view, reference.PRESETS[preset])[1]
    return {row["name"]: max(count(row, preset) for preset in reference.PRESETS) for row in rows}


def draw(swiftgs, out, row, preset):
    """RGBA and the ambiguous weight of a clause's image, by the float64 reference of the tool."""
    with tempfile.TemporaryDirectory() as folder:
        command = [swiftgs, "render", out / row["scene"], "--cameras", out / row["cameras"], "--renderer", "reference",
                   "--conventions", preset, "--background", ",".join(map(str, row.get("background", (0, 0, 0)))),
                   "--format", "npy", "--out", folder]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        rgba, ambiguous = np.load(f"{folder}/view.npy"), np.load(f"{folder}/view.ambiguous.npy")
    # Bits beyond 2^-30 cost a third of the files' bytes, and tell nothing of a renderer.
    return {"rgba": np.round(rgba * 2**30) / 2**30, "ambiguous": np.ceil(ambiguous * 2**30) / 2**30}


def draw_all(swiftgs, out, rows):
    """Writes the expected images, and returns {name of a clause: {preset: file}}: presets that agree share one."""
    presets = {}
    for row in rows:
        images, presets[row["name"]] = {}, {}
        for preset in reference.PRESETS:
            image = draw(swiftgs, out, row, preset)
            same = [p for p, drawn in images.items() if all(np.array_equal(image[key], drawn[key]) for key in image)]
            path = f"{row['name']}/{same[0] if same else preset}.npz"
            if not same:
                images[preset] = image
                np.savez_compressed(out / path, **image)
            presets[row["name"]][preset] = path
    return presets


def png_of(image):
    """A PNG of bytes @shape{height, width, 3}."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    head = struct.pack(">IIBBBBB", image.shape[1], image.shape[0], 8, 2, 0, 0, 0)
    rows = b"".join(b"\0" + row.tobytes() for row in image)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def sheet_of(out, rows, presets, side, columns=8):
    """All clauses by the first preset in one picture, in the order of the manifest."""
    pitch = side + 2
    sheet = np.full((pitch * -(-len(rows) // columns), pitch * columns, 3), 64, np.uint8)
    for k, row in enumerate(rows):
        y, x = pitch * (k // columns) + 1, pitch * (k % columns) + 1
        rgba = np.load(out / presets[row["name"]]["gsplat"])["rgba"]
        sheet[y:y + side, x:x + side] = np.round(255 * rgba[..., :3].clip(0, 1))
    return png_of(sheet)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path, help="the folder to write")
    parser.add_argument("--swiftgs", help="the command-line tool, to draw the expected images")
    parser.add_argument("--side", type=int, default=SIDE, help=f"of the images, in pixels ({SIDE})")
    options = parser.parse_args()
    rows, files = made(options.side)
    for path, content in files.items():
        (options.out / path).parent.mkdir(parents=True, exist_ok=True)
        (options.out / path).write_bytes(content)
    if options.swiftgs:
        presets = draw_all(options.swiftgs, options.out, rows)
        (options.out / "sheet.png").write_bytes(sheet_of(options.out, rows, presets, options.side))
    else:
        before = json.loads((options.out / "manifest.json").read_bytes())
        presets = {row["name"]: row["presets"] for row in before["clauses"]}
    (options.out / "manifest.json").write_bytes(
        manifest_of(rows, layers_of(options.out, rows), presets, options.side))


if __name__ == "__main__":
    sys.exit(main())
