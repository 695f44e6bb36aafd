# SPDX-License-Identifier: Apache-2.0
"""What each policy costs, in the README; and what result files were measured on."""
import os
from statistics import median

from tables.frames import BASELINE, BOX, CHOLESKY, ELLIPSE, SHARED, SQUARE, THRESHOLD, VANILLA, Frames, gaussians
from tables.markdown import decibel, prose, table
from tables.results import InputError, read_json
from tables.source import backend, device, family, machine_name

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
    time = median(row.ms["total"].median for row in rows)
    return f"{time:.{2 if time < 10 else 1}f}"


def views_of(frames, scenes):
    """How many views the times are medians of, in words."""
    numbers = sorted({len({row.view for (of, _), rows in frames.of.items() if of == scene for row in rows})
                      for scene in scenes})
    if numbers == [1]:
        return "one view"
    return f"{numbers[0]} views" if len(numbers) == 1 else f"{numbers[0]} to {numbers[-1]} views"


def spread_of(frames):
    spread = frames.spread()
    return "" if spread is None else f", the same work measured again within {100 * (spread - 1):.1f} %"


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
            psnr = [frames.worst_psnr(scene, name) for scene in scenes]
            row += [*(milliseconds(frames, scene, name) for scene in scenes),
                    decibel(min((value for value in psnr if value is not None), default=None))]
        places.append(f"`{backend(machine)}` is {machine_name(frames.results)}, {views_of(frames, scenes)} a capture"
                      + spread_of(frames))
    sizes = ", ".join(f"{scene.name} ({gaussians(scene.gaussians)} Gaussians, {found[0].sizes[scene]})"
                      for scene in scenes)
    return (prose(f"Milliseconds a frame, the median over views of {sizes}. dB is PSNR against float64 in the worst view "
                  f"compared. {'; '.join(places)}.")
            + "\n\n" + table(header, rows, words=2))


def commit_of(found):
    commit = str(found.get("commit", "unknown"))
    return f"`{commit[:12]}`{' with changes' if commit.endswith('+') else ''}"


def files(source, machine):
    """What the files in a machine's folder were measured on, of those that tell it, the newest first."""
    runs = {}
    for name in source.names(machine, "", ".json"):
        found = read_json(source.path(machine, name))  # as it is, where a file of another format may be
        found = found.get("machine", found)
        if "date" in found:
            run = device(found, backend(machine)), str(found["date"]), commit_of(found)
            runs.setdefault(run, {}).setdefault(family(name), []).append(name)
    rows = [[", ".join(f"`{names[0] if len(names) == 1 else os.path.commonprefix(names) + '*.json'}`"
                       for names in families.values()), *run]
            for run, families in sorted(runs.items(), key=lambda run: run[0][1], reverse=True)]
    return table(["files", "measured on", "date", "commit"], rows, words=4)


TABLES = {"headline": headline, "files": files}
