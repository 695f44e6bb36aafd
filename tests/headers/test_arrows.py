#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Features include the frame, and the frame includes no feature. Reads the include graph of the headers."""
import fnmatch
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2] / "include/swiftgs"

CORE = ["frame_renderer.hpp"]
# The most that a reader of the frame has to read. Lower them when the frame shrinks.
MOST_FILES, MOST_LINES = 40, 4650

FEATURES = {
    "drivers": ["any_*.hpp", "bound_renderer.hpp", "contribution.hpp", "frame_planes.hpp", "kept_scenes.hpp",
                "measure.hpp", "pick*.hpp", "pruning.hpp", "recorded_frames.hpp", "renderer*.hpp",
                "render_settings.hpp", "resident_frames.hpp", "statistics.hpp", "hidden_intersections.hpp"],
    "planes": ["plane/*", "attribute_stage.hpp", "raster/store.hpp", "raster/blend.hpp"],
    "lenses": ["lens/*", "camera*.hpp", "view.hpp", "project.hpp"],
    "loops over functors": ["stage_table.hpp", "project_stage.hpp", "shade_stage.hpp", "bin_stage.hpp"],
    "policies": ["bounds/ellipse.hpp", "bounds/ob*.hpp", "bounds/op*.hpp", "bounds/th*.hpp", "sort/early.hpp",
                 "sort/adaptive.hpp", "sort/standard.hpp", "raster/axis_shared.hpp", "raster/exponents.hpp",
                 "raster/per_pixel.hpp"],
    "files, edits and judges": ["io/*", "edit/*", "edit.hpp", "stress*", "reference*", "metrics.hpp", "c/*"],
    "scenes in memory": ["scene_arrays.hpp", "host_scene.hpp", "harmonic_packing.hpp", "chunks.hpp", "serial.hpp"],
}


def included(header):
    text = (ROOT / header).read_text()
    return [name for name in re.findall(r"^#include <swiftgs/([^>]+)>", text, re.M) if (ROOT / name).exists()]


def closure(headers):
    """Each header that `headers` include, with the one that included it first."""
    by, queue = {header: None for header in headers}, list(headers)
    for header in queue:
        for name in included(header):
            if name not in by:
                by[name] = header
                queue.append(name)
    return by


def way(by, header):
    return header if by[header] is None else f"{way(by, by[header])} > {header}"


def main():
    core, wrong = closure(CORE), []
    for feature, patterns in FEATURES.items():
        for pattern in patterns:
            if not [path for path in ROOT.glob("**/*") if fnmatch.fnmatch(str(path.relative_to(ROOT)), pattern)]:
                wrong.append(f"{feature}: no header is called {pattern}")
        wrong += [f"the frame includes one of its {feature}: {way(core, header)}" for header in core
                  if any(fnmatch.fnmatch(header, pattern) for pattern in patterns)]
    lines = sum((ROOT / header).read_text().count("\n") for header in core)
    if len(core) > MOST_FILES or lines > MOST_LINES:
        wrong.append(f"the frame includes {len(core)} headers of {lines} lines, expected at most {MOST_FILES} of {MOST_LINES}")
    print("\n".join(wrong) or f"{len(core)} headers of {lines} lines")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
