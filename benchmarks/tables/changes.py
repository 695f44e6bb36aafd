# SPDX-License-Identifier: Apache-2.0
"""What a change of the code does to each stage: files of one run before and after it."""
from tables.frames import FRAME_STAGES, Frames, gaussians
from tables.markdown import decibel, ms, prose, signed, table
from tables.results import InputError
from tables.source import machine_name


def change(source, machine, what, backend):
    """Stages of each renderer on each scene in WHAT-before-BACKEND.json and WHAT-after-BACKEND.json, and errors where
    some were measured."""
    before, after = (Frames(source.results(machine, f"{what}-{when}-{backend}.json"), any_scale=True)
                     for when in ("before", "after"))
    if before.of.keys() != after.of.keys() or before.sizes != after.sizes:
        raise InputError(f"{before.results.path}, {after.results.path}: expected the same scenes, sizes and renderers in "
                         "both")
    with_errors = any(row.psnr_db is not None for row in after.results.rows)
    header = ["scene", "renderer", *FRAME_STAGES] + (["float64, worst, dB"] if with_errors else [])
    rows = []
    for scene in after.scenes:
        for name in (name for of, name in after.of if of == scene):
            cells = []
            for stage in FRAME_STAGES:
                times = [frames.mean(scene, name, stage) for frames in (before, after)]
                cells.append(f"{ms(times[0])} → {ms(times[1])} ({signed(times[1] / times[0])})")
            if with_errors:
                worst = [decibel(frames.worst_psnr(scene, name)) for frames in (before, after)]
                cells.append("-" if worst == ["-", "-"] else " → ".join(worst))
            rows.append([f"{scene.name}, {gaussians(scene.gaussians)}", f"`{name}`", *cells])
    return prose(f"{machine_name(after.results)}, `{backend}`: milliseconds of each stage, means over views, before and "
                 f"after.") + "\n\n" + table(header, rows, words=2)


TABLES = {"change": change}
