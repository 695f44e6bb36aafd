#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Features include the frame; the frame includes no feature, and a policy only policies. A frame of `Cuda` includes no
feature that it does without. Reads the include graph."""
import fnmatch
import pathlib
import re
import sys

TREE = pathlib.Path(__file__).resolve().parents[2]
ROOT, CUDA = TREE / "include/swiftgs", TREE / "backends/cuda"

CORE = ["frame/frame_renderer.hpp"]
# The most that a reader of the frame has to read. Lower them when the frame shrinks.
MOST_FILES, MOST_LINES = 29, 4325

# A frame of `Cuda` starts at these files of the headers and of the backend, and includes none of what stands beside it.
OF_HEADERS = "frame/frame_renderer.hpp bounds/ellipse.hpp sort/early.hpp raster/axis_shared.hpp".split()
OF_CUDA = ("include/swiftgs/cuda/stages.hpp cuda.cu memory.cpp stages.cu shade.cu sort.cu raster_order.cu "
           "raster_float_cholesky.cu").split()
BESIDE_CUDA = ["along_ray.cuh", "features.hpp", "other_exponents.hpp", "pick*.cuh", "sum.cuh", "split.hpp",
               "per_pixel.hpp"]
MOST_CUDA_FILES, MOST_CUDA_LINES = 85, 11805

FEATURES = {
    "drivers": ["drivers/*", "renderer.hpp", "any_renderer.hpp", "contribution.hpp"],
    "planes": ["plane/*"],
    "lenses": ["lens/*", "camera*.hpp", "conventions.hpp", "default_view.hpp"],
    "projection": ["project/*"],
    "loops over functors": ["functor/*"],
    "policies": ["bounds/*", "sort/*", "raster/*"],
    "files, edits and judges": ["io/*", "edit/*", "stress.hpp", "reference.hpp", "metrics.hpp", "c/*"],
    "pages": ["pages/*"],
    "scenes in memory": ["memory/*", "scene.hpp", "serial.hpp"],
    "tools": ["tools/*"],
}

# The headers of the frame that each of these features includes. Placed scenes are part of the frame: they are what
# it shows.
OF_FRAME = {
    "drivers": "api backend bounds frame_plan frame_renderer frame_view harmonics learnt math passes placed_scene "
               "placing raster render_input sort span splats stages stored_scenes tiles views",
    "planes": "backend frame_view lens math passes raster scene_view splats stored_scenes tiles view_constants views",
    "lenses": "frame_view lens math rendering_model tiles view_constants views",
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


def cuda_closure():
    """Each file of the library that a frame of `Cuda` includes."""
    roots = [TREE / "include", CUDA / "include"]
    queue = [ROOT / name for name in OF_HEADERS] + [CUDA / name for name in OF_CUDA]
    for path in queue:
        for mark, name in re.findall(r'^#include ([<"])([^>"]+)[>"]', path.read_text(), re.M):
            found = [root / name for root in ([path.parent] if mark == '"' else []) + roots if (root / name).exists()]
            queue += [header for header in found[:1] if header not in queue]
    return queue


def wrong_of_cuda(paths):
    """What is wrong with the files of a frame of `Cuda`."""
    without = [pattern for feature in ("drivers", "planes", "loops over functors", "files, edits and judges", "pages")
               for pattern in FEATURES[feature]]
    named = [str(path.relative_to(ROOT)) if ROOT in path.parents else path.name for path in paths]
    wrong = [f"a frame of Cuda includes {name}" for name in named
             if any(fnmatch.fnmatch(name, pattern) for pattern in without)
             or any(fnmatch.fnmatch(name.split("/")[-1], pattern) for pattern in BESIDE_CUDA)]
    return wrong + too_many("a frame of Cuda", paths, MOST_CUDA_FILES, MOST_CUDA_LINES)


def too_many(who, paths, most_files, most_lines):
    lines = sum(path.read_text().count("\n") for path in paths)
    if len(paths) <= most_files and lines <= most_lines:
        return []
    return [f"{who} includes {len(paths)} files of {lines} lines, expected at most {most_files} of {most_lines}"]


def way(by, header):
    return header if by[header] is None else f"{way(by, by[header])} > {header}"


def headers_of(feature):
    paths = [str(path.relative_to(ROOT)) for path in ROOT.glob("**/*.hpp")]
    return [path for path in paths if any(fnmatch.fnmatch(path, pattern) for pattern in FEATURES[feature])]


def included_features(who, headers, but=()):
    """What is wrong with headers of `who`, which may include no feature but those of `but`."""
    by = closure(headers)
    return [f"{who} include one of the {feature}: {way(by, header)}" for header in by
            for feature, patterns in FEATURES.items()
            if feature not in but and any(fnmatch.fnmatch(header, pattern) for pattern in patterns)]


def main():
    core, wrong = closure(CORE), []
    for feature, patterns in FEATURES.items():
        for pattern in patterns:
            if not [path for path in ROOT.glob("**/*") if fnmatch.fnmatch(str(path.relative_to(ROOT)), pattern)]:
                wrong.append(f"{feature}: no header is called {pattern}")
    wrong += included_features("headers of the frame", CORE)
    wrong += included_features("policies", headers_of("policies"), but=("policies", "tools"))
    for feature, expected in OF_FRAME.items():
        found = {name for header in headers_of(feature) for name in included(header) if name.startswith("frame/")}
        found = {name.removeprefix("frame/").removesuffix(".hpp") for name in found}
        for name in sorted(found.symmetric_difference(expected.split())):
            wrong.append(f"{feature} {'include' if name in found else 'do not include'} frame/{name}.hpp, expected "
                         f"{expected}")
    wrong += too_many("the frame", [ROOT / header for header in core], MOST_FILES, MOST_LINES)
    wrong += wrong_of_cuda(cuda_closure())
    print("\n".join(wrong) or f"{len(core)} headers of the frame, {len(cuda_closure())} files of a frame of Cuda")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
