# SPDX-License-Identifier: Apache-2.0
"""Every policy on every scene: the README's table, the Pareto front, the paper's Tables 1 to 4 and its stages."""
import fnmatch
from statistics import median

from tables.frames import (BASELINE, BOX, CHOLESKY, ELLIPSE, FRAME_STAGES, OUR_STEPS, OURS, RASTERS, SHARED, SQUARE,
                           STEPS, THRESHOLD, VANILLA, Frames, average, gaussians, known, label)
from tables.markdown import count, decibel, heading, ms, prose, table, timed, times
from tables.blocks import backend, machine_name
from tables.results import InputError

# The renderers of the README, with whose choices they are.
HEADLINE = {VANILLA: "INRIA's", BASELINE: "gsplat's choices, our code",
            f"early/{THRESHOLD}half-split/{BOX}": "the paper's", f"early/per-pixel/{ELLIPSE}": "",
            f"early/{THRESHOLD}float-split/{ELLIPSE}": "", f"early/{CHOLESKY}/{SQUARE}": "", f"early/{CHOLESKY}/{BOX}": "",
            f"standard/{CHOLESKY}/{ELLIPSE}": "", f"early/{SHARED}float-cholesky/{ELLIPSE}": "",
            f"early/{CHOLESKY}/{ELLIPSE}": "**ours**"}


def captures(frames):
    """The scenes that are no built-in one, or all where there is no other."""
    return [scene for scene in frames.scenes if scene.name != "builtin"] or frames.scenes


def milliseconds(frames, scene, name):
    """A frame's, the median over the views."""
    rows = frames.rows(scene, name)
    if not rows:
        return "-"
    time = median(row.median("total") for row in rows)
    return f"{time:.{2 if time < 10 else 1}f}"


def views_of(frames, scenes):
    """How many views the times are medians of, in words."""
    numbers = sorted({len({row.view for (of, _), rows in frames.of.items() if of == scene for row in rows})
                      for scene in scenes})
    if numbers == [1]:
        return "one view"
    return f"{numbers[0]} views" if len(numbers) == 1 else f"{numbers[0]} to {numbers[-1]} views"


def headline(source, *machines):
    """Ten renderers on the captures of every machine, and the least PSNR over these."""
    if not machines:
        raise InputError("table 'headline': expected a MACHINE or several")
    found = [Frames(source.results(machine, "matrix.json")) for machine in machines]
    scenes = captures(found[0])
    header, rows = ["sort/raster/bounds", "choices"], [[f"`{name}`", whose] for name, whose in HEADLINE.items()]
    places = []
    for machine, frames in zip(machines, found):
        if captures(frames) != scenes:
            raise InputError(f"{frames.results.path}: expected the captures of {found[0].results.path}")
        first, *others = [scene.name for scene in scenes]
        header += [f"`{backend(machine)}`, ms: {first}", *others, "dB"]
        for row, name in zip(rows, HEADLINE):
            row += [*(milliseconds(frames, scene, name) for scene in scenes), decibel(frames.worst_of_all(name, scenes))]
        spread = frames.spread()
        places.append(f"`{backend(machine)}` is {machine_name(frames.results)}, {views_of(frames, scenes)} a capture"
                      + ("" if spread is None else
                         f", the same work measured again within {100 * (spread - 1):.1f} %"))
    sizes = ", ".join(f"{scene.name} ({gaussians(scene.gaussians)} Gaussians, {found[0].sizes[scene]})"
                      for scene in scenes)
    return (prose(f"Milliseconds a frame, the median over views of {sizes}. dB is PSNR against float64 in the worst view "
                  f"compared. {'; '.join(places)}.")
            + "\n\n" + table(header, rows, words=2))


def steps(source, machine):
    """Tables 1 and 2 on a machine: means over views, how many times the baseline's speed, and the accuracy of each."""
    frames = Frames(source.results(machine, "matrix.json"))
    photographs = {name: average([frames.mean_of(scene, name, "photo_psnr_db") for scene in frames.scenes])
                   for _, name in STEPS + OUR_STEPS}
    seen, rows = bool(known(photographs.values())), []
    spread, of_all = frames.spread(), frames.spread_of_all()
    for step, name in STEPS + OUR_STEPS:
        one, all_ = (None, None) if name == BASELINE else (spread, of_all)
        rows.append([step, f"`{name}`", *(timed(frames.mean(scene, name), frames.speed_up(scene, name, BASELINE), one)
                                          for scene in frames.scenes),
                     times(frames.speed_up_of_all(name, BASELINE), all_),
                     *([decibel(photographs[name])] if seen else []), decibel(frames.worst_of_all(name))])
    header = ["step", "sort/raster/bounds", *map(label, frames.scenes), "geometric mean",
              *(["photographs, mean, dB"] if seen else []), "float64, worst, dB"]
    return frames.with_missing(
        heading(f"{machine_name(frames.results)}, `{frames.backend}`, milliseconds a frame", spread) + "\n\n"
        + table(header, rows, words=2))


def change(value, base):
    return "-" if value is None or base is None else f"{value:.4f} ({value - base:+.4f})"


def accuracy(source, machine):
    """Table 3: PSNR against photographs, beside the per-pixel rasterizer's, and against float64; all with opacity
    boxes."""
    frames = Frames(source.results(machine, "matrix.json"))
    names = [(raster, f"standard/{raster}/{BOX}") for raster in RASTERS]
    photographed = {scene for (scene, _), rows in frames.of.items() if known(row.photo_psnr_db for row in rows)}
    seen = [scene for scene in frames.scenes if photographed and (scene in photographed or scene.name != "builtin")]
    rows = [[f"`{raster}`", *(change(frames.mean_of(scene, name, "photo_psnr_db"),
                                     frames.mean_of(scene, names[0][1], "photo_psnr_db")) for scene in seen),
             *(decibel(frames.worst_psnr(scene, name)) for scene in frames.scenes)] for raster, name in names]
    without = ":" if photographed else ". No frame was compared with a photograph."
    return frames.with_missing(f"{machine_name(frames.results)}, dB{without}\n\n" + table(
        ["rasterizer", *(f"{scene.name}, photographs" for scene in seen),
         *(f"{label(scene)}, float64" for scene in frames.scenes)], rows))


def presets(source, machine):
    """What both presets reach against their reference, and what the square of one of them loses."""
    gsplat = Frames(source.results(machine, "matrix.json"))
    inria = Frames(source.results(machine, "vanilla.json"), "inria")
    scenes = [scene for scene in gsplat.scenes if scene in inria.scenes]
    conservative = VANILLA.rsplit("/", 1)[0] + f"/{ELLIPSE}"
    rows = [[conventions, drawn, *(decibel(frames.worst_psnr(scene, name, member)) for scene in scenes)]
            for conventions, drawn, frames, name, member in (
                ("`gsplat`, `ellipse`", "all that alpha keeps", gsplat, conservative, "psnr_db"),
                ("`inria`, `three-sigma-square`", "the square's part of it", inria, VANILLA, "cut_psnr_db"),
                ("`inria`, `three-sigma-square`", "all that alpha keeps", inria, VANILLA, "psnr_db"))]
    return f"{machine_name(gsplat.results)}, `per-pixel`, dB in the worst view:\n\n" + table(
        ["conventions and bounds", "the reference draws", *map(label, scenes)], rows, words=2)


def with_inria(source, machine, name):
    """Table 4: every step on the scenes of a file, with the inria conventions."""
    frames = Frames(source.results(machine, name), "inria")
    # This file repeats no work; matrix.json, of the same machine, does.
    spread = Frames(source.results(machine, "matrix.json")).spread() if source.has(machine, "matrix.json") else None
    rows = []
    for step in (VANILLA, f"adaptive/{THRESHOLD}half-split/{SQUARE}", f"adaptive/{CHOLESKY}/{SQUARE}", OURS):
        of_step = None if step == VANILLA else spread
        rows.append([f"`{step}`", *(timed(frames.mean(scene, step), frames.speed_up(scene, step, VANILLA), of_step)
                                    for scene in frames.scenes), times(frames.speed_up_of_all(step, VANILLA), of_step)])
    return frames.with_missing(heading(f"{machine_name(frames.results)}, milliseconds", spread) + "\n\n" + table(
        ["sort/raster/bounds", *map(label, frames.scenes), "geometric mean"], rows))


def vanilla(source, machine):
    return with_inria(source, machine, "vanilla.json")


def pruned(source, machine):
    return with_inria(source, machine, "pruned.json")


def on_front(found):
    """Names of {name: (milliseconds, dB)} that no other beats in both, from the fastest on."""
    best, front = None, []
    for name, (_, psnr) in sorted(found.items(), key=lambda one: (one[1][0], -one[1][1])):
        if best is None or psnr > best:
            best, front = psnr, front + [name]
    return front


def pareto(source, machine):
    """The front of each scene, with what was measured beside it counted."""
    frames, rows, left_out = Frames(source.results(machine, "matrix.json")), [], False
    for scene in frames.scenes:
        names = [name for of, name in frames.of if of == scene]
        found = {name: (frames.mean(scene, name), frames.worst_psnr(scene, name)) for name in names}
        judged = {name: values for name, values in found.items() if None not in values}
        left_out |= len(judged) < len(found)
        rows += [[label(scene), f"`{name}`", ms(judged[name][0]), decibel(judged[name][1]), str(len(judged))]
                 for name in on_front(judged)]
    words = "" if not left_out else " Renderers that were not compared with float64 are left out."
    return (prose(f"{machine_name(frames.results)}, `{frames.backend}`: renderers that none of those measured beats in "
                  f"both, milliseconds a frame as means over views and PSNR against float64 in the worst view.{words}")
            + "\n\n" + table(["scene", "sort/raster/bounds", "ms", "dB", "of renderers"], rows, words=2))


def stages(source, machine, *patterns):
    """Figures 2, 3, 8 and 9: stages of the renderers SORT/RASTER/BOUNDS that a pattern has, means over the views."""
    frames, rows = Frames(source.results(machine, "matrix.json")), []
    for scene, name in frames.of:
        if any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns):
            of_each = average([row.intersections / row.visible for row in frames.rows(scene, name) if row.visible])
            rows.append([label(scene), f"`{name}`", count(frames.mean_of(scene, name, "visible")), f"{of_each:.2f}",
                         *(ms(frames.mean(scene, name, stage)) for stage in FRAME_STAGES)])
    if not rows:
        raise InputError(f"table 'stages': no renderer matches {' '.join(patterns)}; expected as 'early/*/ellipse'")
    return f"{machine_name(frames.results)}, `{frames.backend}`, milliseconds, means over views:\n\n" + table(
        ["scene", "sort/raster/bounds", "visible splats", "intersections of each", *FRAME_STAGES], rows, words=2)


TABLES = {"headline": headline, "steps": steps, "accuracy": accuracy, "presets": presets, "vanilla": vanilla,
          "pruned": pruned, "pareto": pareto, "stages": stages}
