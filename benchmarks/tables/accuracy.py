# SPDX-License-Identifier: Apache-2.0
"""What the exponent representations cost in quality: the paper's Table 3, and ours."""
from statistics import mean

from tables import paper
from tables.frames import BOX, ELLIPSE, RASTERS, VANILLA, Frames, known, label
from tables.markdown import decibel, prose, table
from tables.results import InputError
from tables.source import machine_name


def paper_accuracy(_source):
    """Table 3, and the scenes of Table 1 in which the difference lies."""
    rows = []
    for run in paper.RUNS:
        before, after = paper.PSNR_PRINTED[run]
        given = [mean(values) for values in paper.PSNR[run]]
        rows.append([run, f"{before:.2f}", f"{after:.2f}", f"{after - before:+.2f}", f"{given[1] - given[0]:+.2f}",
                     ", ".join(f"{scene} {change:+.2f}" for scene, change in paper.lost(run)) or "none"])
    return table(["GPU, iterations", "gsplat, dB", "axis-shared, dB", "difference", "of Table 1's rows",
                  "scenes that differ there"], rows)


def change(value, base):
    return "-" if value is None or base is None else f"{value:.4f} ({value - base:+.4f})"


def accuracy(source, machine):
    """PSNR against photographs, beside the per-pixel rasterizer's, and against float64; all with opacity boxes."""
    results = source.results(machine, "matrix.json")
    frames = Frames(results)
    names = [(raster, f"standard/{raster}/{BOX}") for raster in RASTERS]
    photographed = {scene for (scene, _), rows in frames.of.items() if known(row.photo_psnr_db for row in rows)}
    seen = [scene for scene in frames.scenes if photographed and (scene in photographed or scene.name != "builtin")]
    rows = []
    for raster, name in names:
        photos = [change(frames.mean_of(scene, name, "photo_psnr_db"),
                         frames.mean_of(scene, names[0][1], "photo_psnr_db")) for scene in seen]
        rows.append([f"`{raster}`", *photos, *(decibel(frames.worst_psnr(scene, name)) for scene in frames.scenes)])
    without = ":" if photographed else ". No frame was compared with a photograph."
    return frames.with_missing(f"{machine_name(results)}, dB{without}\n\n" + table(
        ["rasterizer", *(f"{scene.name}, photographs" for scene in seen),
         *(f"{label(scene)}, float64" for scene in frames.scenes)], rows))


def sorts_change_nothing(source, machine):
    """Whether every sort and both conservative bounds have the errors of the first, rasterizer by rasterizer."""
    frames = Frames(source.results(machine, "matrix.json"))
    differ, compared = set(), 0
    for scene in frames.scenes:
        for raster in RASTERS:
            errors = {}
            for (found, name), rows in frames.of.items():
                _, other, bounds = name.split("/")
                if found == scene and other == raster and bounds != "three-sigma-square":
                    for row in rows:
                        if row.max_abs is not None:
                            errors.setdefault(row.view, set()).add((row.max_abs, row.psnr_db))
                            compared += 1
            differ |= {f"`{raster}` on {label(scene)}" for values in errors.values() if len(values) > 1}
    exceptions = f", except {', '.join(sorted(differ))}" if differ else ""
    return prose(f"The errors of {compared} frames were compared: with one rasterizer on one view, they are the same "
                 f"with every sort and both conservative bounds{exceptions}.")


def presets(source, machine):
    """What both presets reach against their reference, and what the square of one of them loses."""
    gsplat = Frames(source.results(machine, "matrix.json"))
    inria = Frames(source.results(machine, "vanilla.json"), "inria")
    scenes = [scene for scene in gsplat.scenes if scene in inria.scenes]
    if not scenes:
        raise InputError(f"{inria.results.path}: no scene of {gsplat.results.path}; expected some")
    conservative = VANILLA.rsplit("/", 1)[0] + f"/{ELLIPSE}"
    rows = [["`gsplat`, `ellipse`", "all that alpha keeps"]
            + [decibel(gsplat.worst_psnr(scene, conservative)) for scene in scenes],
            ["`inria`, `three-sigma-square`", "the square's part of it"]
            + [decibel(inria.worst_psnr(scene, VANILLA, "cut_psnr_db")) for scene in scenes],
            ["`inria`, `three-sigma-square`", "all that alpha keeps"]
            + [decibel(inria.worst_psnr(scene, VANILLA)) for scene in scenes]]
    return f"{machine_name(gsplat.results)}, `per-pixel`, dB in the worst view:\n\n" + table(
        ["conventions and bounds", "the reference draws", *map(label, scenes)], rows, words=2)


TABLES = {"paper-accuracy": paper_accuracy, "accuracy": accuracy, "sorts-change-nothing": sorts_change_nothing,
          "presets": presets}
