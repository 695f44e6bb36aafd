#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the tables of a folder of results that measure_gpu_frames.sh filled, as Markdown.

usage: tables_cuda.py FOLDER [--summary]

--summary prints the table of the project's README alone, medians over the views of each scene.
"""
import collections
import csv
import glob
import json
import os
import re
import statistics
import subprocess
import sys

from markdown_table import table

BEST = "axis-shared-threshold-float-cholesky"
SQUARE = "three-sigma-square"
BOUNDS = (SQUARE, "opacity-box", "ellipse")
SORTS = ("standard", "early", "adaptive")
FORMS = ("half-split", "float-split", "float-cholesky")
RASTERS = ("per-pixel",) + tuple(f"axis-shared-{t}{form}" for t in ("", "threshold-") for form in FORMS)
STAGES = ("project_ms", "sort_ms", "raster_ms", "total_ms")


def read(folder):
    with open(os.path.join(folder, "machine.json"), encoding="utf-8") as file:
        machine = json.load(file)
    rows = collections.defaultdict(list)
    with open(os.path.join(folder, "gpu_frames.jsonl"), encoding="utf-8") as file:
        for line in file:
            row = json.loads(line)
            rows[row["kind"]].append(row)
    return machine, rows


class Frames:
    """The timed frames, by scene and renderer, in the order of their views."""

    def __init__(self, rows):
        self.of = collections.defaultdict(list)
        self.sizes = {}
        for row in rows:
            self.of[row["scene"], row["renderer"]].append(row)
            self.sizes.setdefault(row["scene"], f"{row['width']}x{row['height']}")
        self.scenes = list(self.sizes)

    def has(self, scene, name):
        return (scene, name) in self.of

    def first(self, scene, name, measure):
        return self.of[scene, name][0][measure]

    def over_views(self, scene, name, measure, fold=statistics.mean):
        return fold(row[measure] for row in self.of[scene, name])


def cuda(sort, raster, bounds):
    return f"cuda/{sort}/{raster}/{bounds}"


def ms(value):
    return f"{value:.3f}"


def title(frames, scene):
    return f"{scene}, {frames.sizes[scene]}"


def print_machine(machine):
    print(f"# {machine['gpu']}, {machine['date']}\n")
    print(f"{machine['gpu_memory']}, at most {machine['gpu_clock']}, driver {machine['driver']}, CUDA "
          f"{machine['cuda']}; {machine['cpu']}, {machine['cores']} cores, {machine['system']}; commit "
          f"`{machine['commit'][:12]}`.\n\n`{machine['command']}`\n")
    print("Milliseconds a frame, medians over the frames of a view, set-up excluded. Project, sort, raster and total are "
          "times between CUDA events on the stream, the host's read of the counts included; wall is from the call to a "
          "finished frame. Frames stay on the GPU. Views are every eighth of a capture.\n")


def worst_error(errors, scene, name, conventions="gsplat", footprint="alpha"):
    """(least PSNR, largest difference) over the views that were compared."""
    found = [e for e in errors if (e["scene"], e["renderer"], e["conventions"], e["footprint"]) ==
             (scene, name, conventions, footprint)]
    return (min(e["psnr_db"] for e in found), max(e["max_abs"] for e in found)) if found else None


def print_best(frames, errors):
    print("## The best exact combinations\n\nOf those that approximate nothing, the three with the least mean over views; "
          "PSNR against float64, the worst view of those compared.\n")
    rows = []
    for scene in frames.scenes:
        exact = [cuda(s, r, b) for s in SORTS for r in RASTERS for b in BOUNDS
                 if "half" not in r and b != SQUARE and frames.has(scene, cuda(s, r, b))]
        best = sorted(exact, key=lambda name: frames.over_views(scene, name, "total_ms"))[:3]
        usual = cuda("early", BEST, "ellipse")
        for name in best + ([usual] if usual in exact and usual not in best else []):
            error = worst_error(errors, scene, name)
            rows.append([title(frames, scene), name[len("cuda/"):]]
                        + [ms(frames.first(scene, name, stage)) for stage in STAGES]
                        + [ms(frames.first(scene, name, "wall_ms"))]
                        + [ms(frames.over_views(scene, name, "total_ms", fold))
                           for fold in (statistics.mean, statistics.median, max)]
                        + [ms(frames.over_views(scene, name, "wall_ms")), f"{error[0]:.1f}" if error else "-"])
    table(["scene", "renderer", "project", "sort", "raster", "first view", "its wall", "mean over views", "median",
           "slowest", "mean wall", "PSNR, dB"], rows)


def ablation_steps(form):
    """(what, sort, raster) of the paper's Table 2, and all of it together."""
    shared, threshold = f"axis-shared-{form}", f"axis-shared-threshold-{form}"
    return [("baseline", "standard", "per-pixel"), ("AR", "standard", shared), ("AR + AT", "standard", threshold),
            ("ES", "early", "per-pixel"), ("ES + AES", "adaptive", "per-pixel"),
            ("AR + AT + ES", "early", threshold), ("all", "adaptive", threshold)]


def print_ablation(frames, bounds):
    print(f"### {bounds}\n\nMean over the views of a scene, and how many times the baseline's speed.\n")
    rows = []
    done = set()
    for form in FORMS:
        for what, sort, raster in ablation_steps(form):
            name = cuda(sort, raster, bounds)
            if name in done or not all(frames.has(scene, name) for scene in frames.scenes):
                continue
            done.add(name)
            cells, ratios = [], []
            for scene in frames.scenes:
                mean = frames.over_views(scene, name, "total_ms")
                base = frames.over_views(scene, cuda("standard", "per-pixel", bounds), "total_ms")
                ratios.append(base / mean)
                cells.append(f"{ms(mean)} ({base / mean:.2f}x)")
            label = what if raster == "per-pixel" else f"{what}, {form}"
            rows.append([label, f"{sort}/{raster}"] + cells + [f"{statistics.geometric_mean(ratios):.2f}x"])
    table(["", "renderer"] + frames.scenes + ["geometric mean"], rows)
    for scene in frames.scenes:
        names = [cuda(sort, raster, bounds) for form in FORMS for _, sort, raster in ablation_steps(form)]
        names = [name for name in dict.fromkeys(names) if frames.has(scene, name)]
        if not names:
            continue
        print(f"{title(frames, scene)}, first view, {frames.first(scene, names[0], 'instances'):,} instances of "
              f"{frames.first(scene, names[0], 'visible'):,} visible Gaussians:\n")
        table(["renderer", "project", "sort", "raster", "total"],
              [[name[len("cuda/"):].rsplit("/", 1)[0]] + [ms(frames.first(scene, name, stage)) for stage in STAGES]
               for name in names])


def largest_regret(standard, early, adaptive):
    """By how much the adaptive sort took longer than the better of the two, in the view where it was most."""
    return max(a["sort_ms"] / min(s["sort_ms"], e["sort_ms"]) - 1 for s, e, a in zip(standard, early, adaptive))


def percent(ratio):
    return f"{100 * ratio:.1f} %"


def print_sorts(frames):
    print("## Sorts\n\nSort stage, mean over views, with the best rasterizer. Regret is by how much the adaptive sort "
          "takes longer than the better of the two: of the means over views, and the largest of a single view; with "
          "the best rasterizer, and the largest with any.\n")
    rows = []
    for scene in frames.scenes:
        for bounds in BOUNDS:
            def mean(sort, raster=BEST, measure="sort_ms"):
                return frames.over_views(scene, cuda(sort, raster, bounds), measure)

            measured = [raster for raster in RASTERS if all(frames.has(scene, cuda(s, raster, bounds)) for s in SORTS)]
            if BEST not in measured:
                continue
            regrets = {r: mean("adaptive", r) / min(mean("standard", r), mean("early", r)) - 1 for r in measured}
            of_views = {r: largest_regret(*(frames.of[scene, cuda(sort, r, bounds)] for sort in SORTS)) for r in measured}
            name = cuda("early", BEST, bounds)
            ratios = [row["instances"] / max(row["visible"], 1) for row in frames.of[scene, name]]
            wins = sum(e["sort_ms"] < s["sort_ms"] for e, s in
                       zip(frames.of[scene, name], frames.of[scene, cuda("standard", BEST, bounds)]))
            rows.append([scene, bounds, f"{min(ratios):.2f} to {max(ratios):.2f}"] + [ms(mean(sort)) for sort in SORTS]
                        + [f"{mean('standard') / mean('early'):.2f}x", f"{wins} of {len(ratios)}",
                           percent(regrets[BEST]), percent(of_views[BEST]),
                           percent(max(regrets.values())), percent(max(of_views.values()))])
    table(["scene", "bounds", "instances a visible Gaussian", "standard", "early", "adaptive", "early against standard",
           "views where early is quicker", "regret", "of a view", "any rasterizer", "and of a view"], rows)


def print_errors(errors, scenes, conventions, footprint, bounds, heading):
    rows = []
    for raster in RASTERS:
        cells = []
        for scene in scenes:
            each = [worst_error(errors, scene, cuda(s, raster, b), conventions, footprint) for s in SORTS for b in bounds]
            found = [e for e in each if e]
            cell = f"{min(e[0] for e in found):.1f}, {max(e[1] for e in found):.1e}" if found else "-"
            cells.append(cell + (" (differ)" if len(set(found)) > 1 else ""))
        rows.append([raster] + cells)
    if any(cell != "-" for row in rows for cell in row[1:]):
        print(f"### {heading}\n")
        table(["raster"] + scenes, rows)


def print_all_errors(errors, scenes):
    print("## Errors\n\nThe worst view: PSNR in dB against float64, largest difference; one row for all sorts and bounds, "
          "which is marked where they differ. `gsplat` and lossless bounds: three views; the others: the first.\n")
    lossless = BOUNDS[1:]
    print_errors(errors, scenes, "gsplat", "alpha", lossless, "gsplat, opacity-box and ellipse")
    print_errors(errors, scenes, "inria", "alpha", lossless,
                 "inria, opacity-box and ellipse, against every pixel of at least the least alpha")
    print_errors(errors, scenes, "inria", SQUARE, (SQUARE,), "inria, three-sigma-square, against the same square")
    print_errors(errors, scenes, "gsplat", SQUARE, (SQUARE,), "gsplat, three-sigma-square, against the same square")
    print_errors(errors, scenes, "gsplat", "alpha", (SQUARE,),
                 "gsplat, three-sigma-square, against every pixel of at least the least alpha")


def print_memory(rows):
    print("## Memory\n\nBytes of the device after all views, the context excluded, in steps of its 2 MiB: scene, renderer, "
          "and one frame of float RGB.\n")
    scenes = {row["scene"]: row for row in rows["scene"]}
    usual = cuda("early", BEST, "ellipse")
    cells = []
    for name, scene in scenes.items():
        n = scene["gaussians"]
        held = {row["renderer"]: row["device_bytes"] for row in rows["memory"] if row["scene"] == name}
        if not held:
            continue
        best, most = held.get(usual, max(held.values())), max(held, key=held.get)
        cells.append([name, f"{n:,}", str(scene["sh_degree"]), f"{scene['device_bytes'] / n:.0f}",
                      f"{(best - scene['device_bytes']) / n:.0f}", f"{best / 2**20:,.0f} MiB",
                      f"{held[most] / 2**20:,.0f} MiB ({most[len('cuda/'):]})"])
    table(["scene", "Gaussians", "SH degree", "bytes a Gaussian, scene", f"and `{usual}`", "together", "the largest"],
          cells)


def short(kernel):
    name = re.sub(r"^void |swiftgs::|kernels::|cub::|\(bool\)", "", re.sub(r"\(.*\)$", "", kernel.replace("(bool)", "")))
    return re.sub(r"^(DeviceRadixSort\w+|DeviceScan\w+).*", r"\1", name)


def print_kernels(folder):
    files = sorted(glob.glob(os.path.join(folder, "kernels-*.csv")))
    if not files:
        return
    print("## Kernels\n\nFirst view: one frame of each rasterizer with the early sort, then one with the standard sort; by "
          "ncu, clocks left alone. A profiler starts every kernel alone and with cold caches.\n")
    for path in files:
        kernels = collections.OrderedDict()
        with open(path, encoding="utf-8") as file:
            for row in csv.DictReader(file):
                kernel = kernels.setdefault(row["ID"], {"name": short(row["Kernel Name"])})
                kernel[row["Metric Name"]] = float(row["Metric Value"].replace(",", ""))
        launches = collections.OrderedDict()
        for kernel in kernels.values():
            launches.setdefault(kernel["name"], []).append(kernel)
        rows = []
        for name, each in launches.items():
            def mean(metric, unit=1.0):
                return statistics.mean(kernel.get(metric, 0) for kernel in each) / unit

            rows.append([f"`{name}`", str(len(each)), f"{mean('gpu__time_duration.sum', 1e3):.1f}",
                         f"{mean('smsp__inst_executed.sum', 1e6):.2f}", f"{mean('dram__bytes.sum', 1e6):.1f}",
                         f"{mean('launch__registers_per_thread'):.0f}",
                         f"{mean('sm__warps_active.avg.pct_of_peak_sustained_active'):.0f}",
                         f"{mean('smsp__issue_active.avg.pct_of_peak_sustained_active'):.0f}"])
        print(f"### {os.path.basename(path)[len('kernels-'):-len('.csv')]}\n")
        table(["kernel", "launches", "us each", "million warp instructions", "MB of memory traffic", "registers",
               "warps active, %", "issue slots, %"], rows)


def print_instructions(folder):
    counter = os.path.join(os.path.dirname(os.path.abspath(__file__)), "count_instructions.py")
    for path in sorted(glob.glob(os.path.join(folder, "instructions-*.csv"))):
        scene = os.path.basename(path)[len("instructions-"):-len(".csv")]
        print(f"## Instructions, {scene}\n", flush=True)
        subprocess.run([sys.executable, counter, path, "--scene", scene, "--pairs",
                        os.path.join(folder, "gpu_frames.jsonl")], check=False)


def print_summary(frames, errors):
    names = [("early", raster, "ellipse") for raster in RASTERS]
    names += [("early", BEST, "opacity-box"), ("early", BEST, SQUARE), ("standard", BEST, "ellipse"),
              ("adaptive", BEST, "ellipse"), ("standard", "per-pixel", SQUARE)]
    rows = []
    for sort, raster, bounds in names:
        name = cuda(sort, raster, bounds)
        cells = []
        for scene in frames.scenes:
            error = worst_error(errors, scene, name)
            median = statistics.median
            cell = f"{frames.over_views(scene, name, 'total_ms', median):.2f} ms" if frames.has(scene, name) else "-"
            cells.append(cell + (f", {error[0]:.1f} dB" if error else ""))
        rows.append([f"`{name}`"] + cells)
    table(["renderer"] + [title(frames, scene) for scene in frames.scenes], rows)


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--summary"]):
        sys.exit(__doc__.strip())
    folder = sys.argv[1]
    machine, rows = read(folder)
    frames, errors = Frames(rows["frame"]), rows["error"]
    if len(sys.argv) == 3:
        print_summary(frames, errors)
        return
    print_machine(machine)
    print_best(frames, errors)
    print("## One policy at a time\n\nThe steps of the paper's Table 2: AR is axis-shared rasterization, AT the dynamic "
          "threshold, ES early sorting, AES its adaptive choice.\n")
    for bounds in (SQUARE, "ellipse"):
        print_ablation(frames, bounds)
    print_sorts(frames)
    print_all_errors(errors, frames.scenes)
    print_memory(rows)
    print_kernels(folder)
    print_instructions(folder)


main()
