#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the tables of a folder of results that measure_cpu.sh filled, as Markdown.

usage: tables.py FOLDER
"""
import collections
import glob
import json
import math
import os
import statistics
import sys

from markdown_table import table

BEST = "axis-shared-threshold-float-cholesky"
SQUARE = "three-sigma-square"
STAGES = ("project_ms", "sort_ms", "raster_ms")
Name = collections.namedtuple("Name", "what backend sort raster bounds scene size")


def read(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def benchmarks(path):
    """{Name: {measure: median over the repetitions}} of a Google Benchmark file; times in milliseconds."""
    runs = collections.defaultdict(list)
    for run in read(path)["benchmarks"] if os.path.exists(path) else []:
        if run.get("error_occurred"):
            sys.exit(f"{path}: {run['name']}: {run['error_message']}")
        if run["run_type"] == "iteration":
            runs[Name(*run["name"].split("/")[:7])].append(run)
    measures = STAGES + ("real_time", "visible", "instances", "peak_mib")
    return {name: {m: statistics.median(r[m] for r in repeated) for m in measures}
            for name, repeated in runs.items()}


def ms(value):
    return f"{value:.1f}"


def stages(measured):
    return [ms(measured[stage]) for stage in STAGES] + [ms(measured["real_time"])]


def print_machine(folder):
    machine = read(os.path.join(folder, "machine.json"))
    print(f"# {machine['cpu']}, {machine['cores']} cores, {machine['date']}\n")
    print(f"{machine['memory_gib']} GiB, {machine['system']}; {machine['compiler']}, `{machine['flags']}`; "
          f"commit `{machine['commit'][:12]}`"
          + (f" with {machine['changed_files']} changed files" if machine["changed_files"] else "")
          + f"; load before {machine['load_before']}.\n\n`{machine['command']}`\n")
    print("Times are milliseconds a frame, set-up excluded, medians over repetitions. A name is "
          "SORT/RASTER/BOUNDS.\n")


def of_scene(frames, scene, backend):
    return {n: m for n, m in frames.items() if n.scene == scene and n.backend == backend}


def print_best(frames, scenes):
    print("## The best combination, and Serial's best in the same run\n\nOf those that approximate nothing: float "
          "terms, lossless bounds.\n")
    rows = []
    for scene in scenes:
        best = {}
        for backend in ("cpu", "serial"):
            measured = {n: m for n, m in of_scene(frames, scene, backend).items()
                        if "half" not in n.raster and n.bounds != SQUARE}
            best[backend] = min(measured.items(), key=lambda item: item[1]["real_time"], default=None)
        name, m = best["cpu"]
        row = [f"{scene}, {name.size}", f"{m['visible']:,.0f}", f"{m['instances']:,.0f}",
               "/".join(name[2:5])] + stages(m)
        if best["serial"]:
            serial, s = best["serial"]
            row += [f"{ms(s['real_time'])} ({'/'.join(serial[2:5])})", f"{s['real_time'] / m['real_time']:.1f}"]
        else:
            row += ["-", "-"]
        rows.append(row)
    table(["scene", "visible", "instances", "best of `cpu`", "project", "sort", "raster", "frame",
           "best of `serial`", "times as long"], rows)


def print_ablation(frames, views, scene):
    measured = {n[2:5]: m for n, m in of_scene(frames, scene, "cpu").items()}
    mean = {n[2:5]: m for n, m in of_scene(views, scene, "cpu").items()}
    rasters = [r for s, r, b in measured if s == "early" and b == "ellipse"]
    steps = [("early", raster, "ellipse") for raster in rasters]
    steps += [(sort, BEST, "ellipse") for sort in ("standard", "adaptive")]
    steps += [("early", BEST, bounds) for bounds in ("opacity-box", SQUARE)]
    steps += [("standard", "per-pixel", SQUARE)]
    print(f"### {scene}\n")
    table(["renderer", "instances", "project", "sort", "raster", "frame", "mean over views"],
          [["/".join(step), f"{measured[step]['instances']:,.0f}"] + stages(measured[step])
           + [ms(mean[step]["real_time"]) if step in mean else "-"] for step in steps if step in measured])


def print_all(frames, scenes):
    print("## Every combination\n")
    sorts = ("standard", "early", "adaptive")
    rows = collections.defaultdict(dict)
    for n, m in frames.items():
        if n.backend == "cpu":
            rows[n.raster, n.bounds][n.scene, n.sort] = ms(m["real_time"])
    columns = [(scene, sort) for scene in scenes for sort in sorts]
    table(["raster/bounds"] + [f"{scene}, {sort}" for scene, sort in columns],
          [["/".join(row)] + [cells.get(column, "-") for column in columns] for row, cells in rows.items()])


def print_errors(folder, conventions, scenes, title):
    """Worst view of each rasterizer and kind of bounds. Renderers that promise the same bits share a row, and
    it is said where they do not keep the promise."""
    worst = collections.defaultdict(dict)
    for scene in scenes:
        path = os.path.join(folder, f"check-{conventions}-{scene.replace(':', '-')}.json")
        frames = collections.defaultdict(list)
        for result in read(path) if os.path.exists(path) else []:
            _, _, raster, bounds = result["renderer"].split("/")
            frames[raster, SQUARE if bounds == SQUARE else "lossless"].append(result)
        for row, results in frames.items():
            figures = collections.defaultdict(set)
            for r in results:
                figures[r["view"]].add((r["psnr_db"], r["max_abs"], r.get("photo_psnr_db")))
            psnr = min(math.inf if r["psnr_db"] is None else r["psnr_db"] for r in results)
            photos = [r["photo_psnr_db"] for r in results if r.get("photo_psnr_db") is not None]
            cell = f"{psnr:.1f}, {max(r['max_abs'] for r in results):.1e}"
            cell += f", {statistics.mean(photos):.3f}" if photos else ""
            cell += " (differ)" if any(len(f) > 1 for f in figures.values()) else ""
            worst[row][scene] = cell
    if not worst:
        return
    print(f"## {title}\n\nWorst of the views: PSNR in dB against float64 with the same conventions, largest difference; "
          "for captures also the mean PSNR against the photographs of these views.\n")
    table(["raster/bounds"] + scenes,
          [["/".join(row)] + [cells.get(scene, "-") for scene in scenes] for row, cells in worst.items()])


def slope(points):
    """Exponent of the power law that fits (x, y) best, in logarithms."""
    xs, ys = [math.log(x) for x, _ in points], [math.log(y) for _, y in points]
    mx, my = statistics.mean(xs), statistics.mean(ys)
    return sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / sum((x - mx) ** 2 for x in xs)


def print_scaling(folder):
    measured = {}
    for path in glob.glob(os.path.join(folder, "scaling-*.json")):
        for name, m in benchmarks(path).items():
            measured[int(name.scene.split(":")[1])] = m
    if not measured:
        return
    print("## Growth with the scene\n\nThe built-in scene, 1280x720, a process a size; memory includes making it.\n")
    sizes = sorted(measured)
    table(["Gaussians", "visible", "instances", "project", "sort", "raster", "frame", "peak memory, GiB"],
          [[f"{n:,}", f"{measured[n]['visible']:,.0f}", f"{measured[n]['instances']:,.0f}"]
           + stages(measured[n]) + [f"{measured[n]['peak_mib'] / 1024:.2f}"] for n in sizes])
    if len(sizes) > 1:
        by_size = slope([(n, measured[n]["real_time"]) for n in sizes])
        by_work = slope([(measured[n]["instances"], measured[n]["real_time"]) for n in sizes])
        print(f"Frame time grows as Gaussians^{by_size:.2f}, and as instances^{by_work:.2f}.\n")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    folder = sys.argv[1]
    frames = benchmarks(os.path.join(folder, "frames.json"))
    views = benchmarks(os.path.join(folder, "views.json"))
    scenes = list(dict.fromkeys(name.scene for name in frames))
    print_machine(folder)
    print_best(frames, scenes)
    print("## One policy at a time\n")
    for scene in scenes:
        print_ablation(frames, views, scene)
    print_all(frames, scenes)
    print_errors(folder, "gsplat", scenes, "Errors")
    print_errors(folder, "inria", scenes, "Errors with the inria preset")
    print_scaling(folder)


main()
