# SPDX-License-Identifier: Apache-2.0
"""Judges what gsplat, HiGS and Faster-GS drew of the conformance set, and stores it:

    python3 benchmarks/rivals.py frames tests/conformance/set/*/ --judged 0 --canvases OUT --json RUN.json
    python3 benchmarks/conformance/canvases.py OUT RUN.json STORED.json

A folder of OUT is a renderer. RUN.json says on which machine. The driver hands renderers no background, so of clauses
that have one nothing is judged. Needs NumPy.
"""
import json
import pathlib
import sys

from results import SET, judged, packed


def main(out, run, stored):
    clauses = json.loads((SET / "manifest.json").read_bytes())["clauses"]
    with_background = {clause["name"] for clause in clauses if any(clause.get("background", ()))}
    rows = []
    for folder in sorted(path for path in pathlib.Path(out).iterdir() if path.is_dir()):
        for name in with_background:
            (folder / f"{name}.npy").unlink(missing_ok=True)
        rows += judged(folder.name, folder)
    document = {"format": "swiftgs-conformance", "version": 1, "set": "1.0", "preset": "gsplat",
                "command": "rivals.py frames SET/*/ --canvases OUT",
                "machine": json.loads(pathlib.Path(run).read_bytes())["machine"], "rows": rows}
    pathlib.Path(stored).write_text(packed(document), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
