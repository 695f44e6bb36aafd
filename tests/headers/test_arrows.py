#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Features include the frame, and the frame includes no feature. Reads the include graph of the headers."""
import fnmatch
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2] / "include/swiftgs"

CORE = ["frame/frame_renderer.hpp"]
# The most that a reader of the frame has to read. Lower them when the frame shrinks.
MOST_FILES, MOST_LINES = 28, 4700

FEATURES = {
    "drivers": ["drivers/*", "renderer.hpp", "any_renderer.hpp", "contribution.hpp", "pick.hpp", "pruning.hpp",
                "render_settings.hpp"],
    "planes": ["plane/*"],
    "lenses": ["lens/*", "camera*.hpp", "default_view.hpp"],
    "projection": ["project/*"],
    "loops over functors": ["functor/*"],
    "policies": ["bounds/*", "sort/*", "raster/*"],
    "files, edits and judges": ["io/*", "edit/*", "edit.hpp", "stress.hpp", "reference.hpp", "metrics.hpp", "c/*"],
    "scenes in memory": ["memory/*", "scene_arrays.hpp", "serial.hpp"],
    "tools": ["tools/*"],
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
