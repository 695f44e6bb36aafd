# SPDX-License-Identifier: Apache-2.0
"""Pruned scenes: the paper's Table 4, and ours with scenes that `swiftgs prune` made."""
from statistics import mean

from tables import paper
from tables.frames import CHOLESKY, OURS, SQUARE, THRESHOLD, VANILLA, Frames, gaussians, label
from tables.markdown import heading, percent, table, timed, times
from tables.results import InputError, is_number
from tables.source import machine_name

ALL = f"adaptive/{THRESHOLD}half-split/{SQUARE}"
ALL_OURS = f"adaptive/{CHOLESKY}/{SQUARE}"


def paper_pruned(_source):
    """Table 4, its means from its rows."""
    columns = [values + (mean(values),) for values in paper.PRUNED]
    rows = [[scene, f"{a:.2f}", f"{b:.2f}", times(a / b), f"{c:.2f}", f"{d:.2f}", times(c / d)]
            for scene, a, b, c, d in zip(paper.PRUNED_SCENES + ("mean",), *columns)]
    return table(["scene", "INRIA", "and all", "speed-up", "PUP-GS", "and all", "speed-up"], rows)


def with_inria(source, machine, name):
    """Every step on the scenes of a file, with the inria conventions."""
    frames = Frames(source.results(machine, name), "inria")
    # This file repeats no work; matrix.json, of the same machine, does.
    spread = Frames(source.results(machine, "matrix.json")).spread() if source.has(machine, "matrix.json") else None
    rows = []
    for step in (VANILLA, ALL, ALL_OURS, OURS):
        of_step = None if step == VANILLA else spread
        rows.append([f"`{step}`", *(timed(frames.mean(scene, step), frames.speed_up(scene, step, VANILLA), of_step)
                                    for scene in frames.scenes), times(frames.speed_up_of_all(step, VANILLA), of_step)])
    return frames.with_missing(heading(f"{machine_name(frames.results)}, milliseconds", spread) + "\n\n" + table(
        ["sort/raster/bounds", *map(label, frames.scenes), "geometric mean"], rows))


def vanilla(source, machine):
    """Whole scenes."""
    return with_inria(source, machine, "vanilla.json")


def pruned(source, machine):
    """Table 4: pruned scenes."""
    return with_inria(source, machine, "pruned.json")


def read_pruned(source, machine, name):
    """The object in a file of `swiftgs prune --json`, checked."""
    found, path = source.json(machine, name, "swiftgs-prune", before=dict, after=dict), source.path(machine, name)
    for side in ("before", "after"):
        if not is_number(found[side].get("gaussians")):
            raise InputError(f"{path}: {side}.gaussians: expected a number")
    if not is_number(found.get("kept_weight")):
        raise InputError(f"{path}: kept_weight: expected a number")
    return found


def decibels(value):
    return f"{value:.2f}" if is_number(value) else "-"


def prune_quality(source, machine):
    """What each score keeps: quality of the views that it has not seen, before and after."""
    rows = []
    for name in source.names(machine, "prune-", ".json"):
        found = read_pruned(source, machine, name)
        before, after = found["before"], found["after"]
        rows.append([str(found.get("scene")), str(found.get("score")), gaussians(before["gaussians"]),
                     gaussians(after["gaussians"]), percent(found["kept_weight"]),
                     decibels(before.get("photo_psnr_db")), decibels(after.get("photo_psnr_db")),
                     decibels(after.get("unpruned_psnr_db"))])
    return table(["scene", "score", "Gaussians before", "after", "of all scores kept", "photographs before, dB",
                  "after, dB", "against unpruned, dB"], rows, words=2)


TABLES = {"paper-pruned": paper_pruned, "pruned": pruned, "vanilla": vanilla, "prune-quality": prune_quality}
