# SPDX-License-Identifier: Apache-2.0
"""Draws the conformance set with renderers of this library, and judges what they draw as any other renderer's images:

    python3 benchmarks/conformance/own.py SWIFTGS OUT [RENDERER...]

SWIFTGS is the command-line tool, RENDERER a name of `swiftgs list`. OUT/RENDERER gets an EXR of each clause, and
OUT/swiftgs.json what the judge says. Needs NumPy.
"""
import json
import pathlib
import subprocess
import sys

from results import SET, judged, packed

RENDERERS = ["serial/early/per-pixel/ellipse", *(f"cpu/early/{raster}/ellipse" for raster in (
    "per-pixel", "axis-shared-threshold-float-cholesky", "axis-shared-float-split", "axis-shared-half-split"))]


def draw(swiftgs, renderer, clause, folder):
    background = ",".join(map(str, clause.get("background", (0, 0, 0))))
    subprocess.run([swiftgs, "render", SET / clause["scene"], "--cameras", SET / clause["cameras"],
                    "--renderer", renderer, "--background", background, "--planes", "alpha", "--format", "exr",
                    "--out", folder], check=True, stdout=subprocess.DEVNULL)
    (folder / "view.exr").rename(folder / f"{clause['name']}.exr")


def main(swiftgs, out, *renderers):
    clauses, rows = json.loads((SET / "manifest.json").read_bytes())["clauses"], []
    for renderer in renderers or RENDERERS:
        folder = pathlib.Path(out) / renderer.replace("/", "-")
        folder.mkdir(parents=True, exist_ok=True)
        for clause in clauses:
            draw(swiftgs, renderer, clause, folder)
        rows += judged(renderer, folder)
    subprocess.run([swiftgs, "list", "--json", f"{out}/list.json"], check=True, stdout=subprocess.DEVNULL)
    document = {"format": "swiftgs-conformance", "version": 1, "set": "1.0", "preset": "gsplat",
                "command": " ".join(["own.py SWIFTGS OUT", *renderers]),
                "machine": json.loads(pathlib.Path(out, "list.json").read_bytes())["machine"], "rows": rows}
    pathlib.Path(out, "swiftgs.json").write_text(packed(document), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
