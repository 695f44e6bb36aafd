# SPDX-License-Identifier: Apache-2.0
"""This library beside gsplat, HiGS and Faster-GS: time against error of the same frames, and what planes cost."""
import dataclasses
from statistics import median

from tables.frames import gaussians, known
from tables.markdown import decibel, ms, prose, table
from tables.blocks import commit_of

NAME = "rivals.json"
OPTIONAL = "Faster-GS"  # rivals.py may run without it
# Each with its calls, of which the fastest in a scene counts.
RIVALS = {"gsplat": ("gsplat", "gsplat, not packed"), OPTIONAL: (OPTIONAL,),
          "HiGS": ("HiGS, tiles of 8", "HiGS, tiles of 16"), "SwiftGS": ("SwiftGS",)}
# Frames with planes beside colour, likewise: of each renderer colour first, which the others are compared with.
WITH_PLANES = {
    "SwiftGS": {"colour": ("SwiftGS, colour alone",), "alpha, expected depth": ("SwiftGS, depth",),
                "id of the largest weight": ("SwiftGS, id",)},
    "gsplat": {"colour": RIVALS["gsplat"], "alpha, expected depth": ("gsplat, depth", "gsplat, not packed, depth"),
               "id of the largest weight": ("gsplat, not packed, id",)}}


@dataclasses.dataclass(frozen=True)
class Found:
    """What a renderer reaches on a scene: milliseconds, the median over the views, and dB of the worst view."""
    ms: float
    db: float


def rivals_in(rows):
    """The renderers of a file, in the order of the table."""
    return [rival for rival in RIVALS if rival != OPTIONAL or any(row.renderer == rival for row in rows)]


def scenes_of(rows):
    """{scene: its rows}"""
    scenes = {}
    for row in rows:
        scenes.setdefault(row.scene, []).append(row)
    return scenes


def fastest(rows, calls):
    """(milliseconds, call) of the fastest call over the views of one scene."""
    return min((median(row.median("total") for row in rows if row.renderer == call), call) for call in calls)


def reached(rows, rival):
    """What a rival reaches over the views of one scene."""
    time, call = fastest(rows, RIVALS[rival])
    return Found(time, min(known(row.psnr_db for row in rows if row.renderer == call), default=None))


def views_of(rows):
    """The names of the views of one scene."""
    return {row.view for row in rows}


def counted(scenes):
    numbers = sorted({len(views_of(rows)) for rows in scenes.values()})
    return f"{numbers[0]} to {numbers[-1]}" if len(numbers) > 1 else str(numbers[0])


def rivals(source, machine):
    """Milliseconds and decibels of each on each scene."""
    about, found = source.rows(machine, NAME)
    scenes, lines = scenes_of(found), []
    for rival in rivals_in(found):
        each = [reached(rows, rival) for rows in scenes.values()]
        lines.append([f"**{rival}**" if rival == "SwiftGS" else rival,
                      *(text for one in each for text in (ms(one.ms), decibel(one.db)))])
    described = ", ".join(f"{scene} ({gaussians(rows[0].gaussians)} Gaussians, {rows[0].width}x{rows[0].height})"
                          for scene, rows in scenes.items())
    judged = max(len(views_of(row for row in rows if row.psnr_db is not None)) for rows in scenes.values())
    return (prose(f"Milliseconds a frame, the median over {counted(scenes)} views of {described}; dB is PSNR against "
                  f"float64 in the worst of {judged} views. One {about['gpu']}, {about['date']}, commit "
                  f"{commit_of(about)}.")
            + "\n\n" + table(["", *(text for scene in scenes for text in (f"{scene}, ms", "dB"))], lines))


def rivals_planes(source, machine):
    """Milliseconds of frames with planes, and how many times those of colour they take, of SwiftGS and gsplat."""
    about, found = source.rows(machine, NAME)
    scenes, lines = scenes_of(found), []
    for rival, sets in WITH_PLANES.items():
        for planes, of_set in sets.items():
            line = [rival, planes]
            for rows in scenes.values():
                colour, time = fastest(rows, sets["colour"])[0], fastest(rows, of_set)[0]
                line += [ms(time), "-" if planes == "colour" else f"{time / colour:.2f}"]
            lines.append(line)
    return (prose(f"Milliseconds a frame, the median over {counted(scenes)} views, and how many times the frame of "
                  f"colour it takes. One {about['gpu']}, {about['date']}, commit {commit_of(about)}.")
            + "\n\n" + table(["", "planes", *(text for scene in scenes for text in (f"{scene}, ms", "times"))], lines,
                             words=2))


TABLES = {"rivals": rivals, "planes-rivals": rivals_planes}
