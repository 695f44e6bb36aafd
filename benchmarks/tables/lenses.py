# SPDX-License-Identifier: Apache-2.0
"""Frames of a capture through other lenses than its own."""
from tables.frames import FRAME_STAGES, Frames, gaussians
from tables.growth import BEST
from tables.markdown import count, ms, quotient, table
from tables.results import InputError
from tables.source import machine_name

LENSES = ("pinhole", "opencv", "fisheye", "panorama")  # ends of scenes' names, as measure_matrix.sh calls them
ORDERS = {"": "as stored", "-ordered": "in space"}


def lenses(source, machine):
    """Stages through each lens in each order, and the frame's time over the pinhole's in the same order."""
    results = source.results(machine, "lenses.json")
    frames = Frames(results)
    first = frames.scenes[0]
    capture, _, lens = first.name.rpartition("-")
    if lens != LENSES[0]:
        raise InputError(f"{results.path}: first scene {first.name!r}; expected one that ends in '-{LENSES[0]}'")
    rows = []
    for order, words in ORDERS.items():
        of_lens = {lens: first._replace(name=f"{capture}-{lens}{order}") for lens in LENSES}
        pinhole = frames.mean(of_lens[LENSES[0]], BEST)
        for lens, scene in of_lens.items():
            times = [frames.mean(scene, BEST, stage) for stage in FRAME_STAGES]
            rows.append([lens, words, count(frames.mean_of(scene, BEST, "visible")), *map(ms, times),
                         quotient(times[-1], pinhole)])
    return frames.with_missing(
        f"{machine_name(results)}, `{BEST}`, {capture}, {gaussians(first.gaussians)}, milliseconds, means over "
        f"{len(frames.rows(first, BEST))} views:\n\n"
        + table(["lens", "order", "visible splats", *FRAME_STAGES, "of the pinhole's"], rows, words=2))


TABLES = {"lenses": lenses}
