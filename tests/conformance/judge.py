#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Judges the canvases of a renderer by the conformance set: judge.py SET FOLDER [--preset gsplat]

FOLDER has one file a clause: NAME.png (8 bits), NAME.rgba (raw bytes), NAME.npy or NAME.exr (floats), rows from the
top, colours premultiplied by alpha over black, with the clause's background where it has one. A pixel is right if every
channel is within half a step of its format and what ambiguous decisions may change; a clause, if every pixel is. Of one
that is not, conventions are changed one after another, and those that come nearest are named. Exit code 0 if all
clauses are right, else 1. Needs reference.py beside it, Python and NumPy.
"""
import argparse
import json
import pathlib
import struct
import sys
import zlib

import numpy as np

import reference

MOST_CHANGES, LEAST_GAIN = 3, 3.0  # conventions that are named together, and decibels that each must be worth


def read_png(path):
    """The bytes of a PNG of 8 bits a channel, RGB or RGBA."""
    data, chunks, at = path.read_bytes(), {}, 8
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        chunks[kind] = chunks.get(kind, b"") + data[at + 8:at + 8 + size]
        at += 12 + size
    width, height, bits, kind, _, _, interlaced = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    if bits != 8 or kind not in (2, 6) or interlaced:
        raise SystemExit(f"judge: {path}: expected a PNG of 8 bits, RGB or RGBA, not interlaced")
    n = {2: 3, 6: 4}[kind]
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, 1 + width * n).astype(int)
    out = np.zeros((height + 1, width + 1, n), int)  # a row above and a pixel to the left are 0
    for y, (method, row) in enumerate(zip(rows[:, 0], rows[:, 1:].reshape(height, width, n)), 1):
        for x in range(1, width + 1):
            left, up, corner = out[y, x - 1], out[y - 1, x], out[y - 1, x - 1]
            if method == 4:
                far = [abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)]
                guess = np.where((far[0] <= far[1]) & (far[0] <= far[2]), left, np.where(far[1] <= far[2], up, corner))
            else:
                guess = (0, left, up, (left + up) // 2)[method]
            out[y, x] = (row[x - 1] + guess) & 255
    return out[1:, 1:].astype(np.uint8)


def read_exr(path):
    """The channels R, G, B and A of an EXR in rows, of halfs or floats, not compressed or by ZIP."""
    data, at, head = path.read_bytes(), 8, {}
    while data[at]:
        name, kind = data[at:].split(b"\0", 2)[:2]
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<i", data, at)[0]
        head[name], at = data[at + 4:at + 4 + size], at + 4 + size
    x0, y0, x1, y1 = struct.unpack("<4i", head[b"dataWindow"])
    width, height, channels, c = x1 - x0 + 1, y1 - y0 + 1, [], head[b"channels"]
    while c[0]:
        name, _, c = c.partition(b"\0")
        channels, c = [*channels, (name, {1: "<f2", 2: "<f4"}[struct.unpack_from("<i", c)[0]])], c[16:]
    lines = {0: 1, 2: 1, 3: 16}.get(head[b"compression"][0])
    if not lines:
        raise SystemExit(f"judge: {path}: expected an EXR without compression, or with ZIP")
    row, out = np.dtype([(name.decode(), kind, (width,)) for name, kind in channels]), []
    for begin in struct.unpack_from(f"<{-(-height // lines)}Q", data, at + 1):
        y, size = struct.unpack_from("<ii", data, begin)
        part, full = data[begin + 8:begin + 8 + size], min(lines, y1 + 1 - y) * row.itemsize
        if size < full:  # differences of bytes, of which every other one stands in the first half
            sums = (np.cumsum(np.frombuffer(zlib.decompress(part), np.uint8) - 128) + 128).astype(np.uint8)
            whole = np.empty(full, np.uint8)
            whole[::2], whole[1::2] = sums[:(full + 1) // 2], sums[(full + 1) // 2:]
            part = whole.tobytes()
        out.append(np.frombuffer(part, row))
    rows = np.concatenate(out)
    return np.stack([rows[name] for name in "RGBA" if name in row.names], axis=2)


def read_canvas(folder, name, side, straight):
    """The values of a canvas, and how far rounding moves one of value 1; nothing where there is no file."""
    readers = {".npy": np.load, ".exr": read_exr, ".png": read_png,
               ".rgba": lambda path: np.fromfile(path, np.uint8).reshape(side, side, 4)}
    for ending, read in readers.items():
        path = folder / (name + ending)
        if path.exists():
            found = read(path)
            if found.shape[:2] != (side, side) or found.shape[2] not in (3, 4):
                raise SystemExit(f"judge: {path}: expected {side}x{side} pixels of 3 or 4 channels")
            is_bytes = found.dtype == np.uint8
            values = found.astype(float) / (255 if is_bytes else 1)
            if straight:
                values[..., :3] *= values[..., 3:]
            if values.shape[2] == 4 and np.all(values[..., 3] == 1):
                values = values[..., :3]  # an opaque canvas has no alpha to judge
            return values, 0 if is_bytes else float(np.finfo(found.dtype).eps)
    return None


def decibels(values, wanted):
    return -10 * float(np.log10(max(np.mean((values[..., :3] - wanted[..., :3]) ** 2), 1e-20)))


def judge(root, manifest, clause, canvas, preset, blends_in_bytes):
    """The row of one clause."""
    if canvas is None:
        return {"clause": clause["name"], "verdict": "not drawn"}
    (values, epsilon), expected = canvas, np.load(root / clause["presets"][preset])

    def shown(image):
        return image[..., :values.shape[2]] if epsilon else image[..., :values.shape[2]].clip(0, 1)

    def wrong(image):
        half_steps = 1 + (clause["layers"] if blends_in_bytes else 0)
        tolerance = 2e-6 + (epsilon * np.abs(shown(image)) if epsilon else half_steps / 510)
        found = np.abs(values - shown(image)) > tolerance + expected["ambiguous"][..., None]
        return np.any(found[..., :3], axis=2), np.any(found[..., 3:], axis=2)
    found, of_alpha = wrong(expected["rgba"])
    row = {"clause": clause["name"], "verdict": "differs" if np.any(found | of_alpha) else "right",
           "wrong": float(np.mean(found | of_alpha)), "db": decibels(values, shown(expected["rgba"]))}
    if row["verdict"] == "right":
        return row
    scene, camera = reference.read_scene(root / clause["scene"]), reference.read_camera(root / clause["cameras"])
    variants = [*((v["name"], v["conventions"]) for v in manifest["variants"] + manifest["departures"]),
                *((f"preset {name}", reference.PRESETS[name]) for name in reference.PRESETS if name != preset)]
    changed, named, best = {**reference.PRESETS[preset], **clause.get("conventions", {})}, [], row["db"]
    while len(named) < MOST_CHANGES and found.any():
        images = {name: reference.render(scene, camera, {**changed, **given}, clause.get("background", (0, 0, 0)))[0]
                  for name, given in variants}
        # What makes every pixel right is nearer than any PSNR.
        scores = {name: (not wrong(image)[0].any(), decibels(values, shown(image))) for name, image in images.items()}
        name = max(scores, key=scores.get)
        if scores[name] < (False, best + LEAST_GAIN):
            break
        changed |= dict(variants)[name]
        named, best, (found, of_alpha) = [*named, name], scores[name][1], wrong(images[name])
    named += ["alpha of the canvas"] if of_alpha.any() and not found.any() else []
    return {**row, "nearest": named, "nearest_db": best, "explained": not found.any()}


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("set", type=pathlib.Path, help="the folder of manifest.json")
    parser.add_argument("folder", type=pathlib.Path, help="the canvases, one a clause")
    parser.add_argument("--preset", default="gsplat", choices=reference.PRESETS, help="by which to judge (gsplat)")
    parser.add_argument("--straight", action="store_true", help="colours are not premultiplied, as in PNG files")
    parser.add_argument("--blends-in-bytes", action="store_true", help="allow half a step for each layer too")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write the rows")
    options = parser.parse_args(arguments)
    manifest = json.loads((options.set / "manifest.json").read_bytes())
    rows = []
    print(f"{'clause':20}{'verdict':12}{'wrong':>8}{'dB':>7}  nearest")
    for clause in manifest["clauses"]:
        canvas = read_canvas(options.folder, clause["name"], manifest["side"], options.straight)
        row = judge(options.set, manifest, clause, canvas, options.preset, options.blends_in_bytes)
        rows.append(row)
        numbers = f"{100 * row['wrong']:7.2f}%{row['db']:7.1f}" if "db" in row else ""
        nearest = f"  {', '.join(row['nearest']) or 'no convention'} ({row['nearest_db']:.1f} dB" + (
            ", every pixel)" if row["explained"] else ")") if "nearest" in row else ""
        print(f"{row['clause']:20}{row['verdict']:12}{numbers}{nearest}", flush=True)
    right = sum(row["verdict"] == "right" for row in rows)
    print(f"{right} of {len(rows)} clauses right by {options.preset}")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0 if right == len(rows) else 1


if __name__ == "__main__":
    sys.exit(main())
