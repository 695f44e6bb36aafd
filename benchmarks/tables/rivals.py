# SPDX-License-Identifier: Apache-2.0
"""This library beside gsplat, HiGS and Faster-GS: time against error of the same frames, and what planes cost."""
import dataclasses
from statistics import median

from tables.frames import gaussians
from tables.markdown import decibel, ms, prose, table
from tables.results import InputError, check_rows
from tables.summary import commit_of

NAME = "rivals.json"
PLANES_NAME = "planes-rivals.json"
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


def read_file(source, machine, name):
    """A file of rivals.py; its rows may have times of any calls."""
    path = source.path(machine, name)
    found = source.json(machine, name, "swiftgs-rivals", rows=list, machine=dict)
    check_rows(path, found["rows"], texts=("scene",), counts=("gaussians",))
    for n, row in enumerate(found["rows"]):
        if not isinstance(row.get("ms"), dict) or not isinstance(row.get("errors", {}), dict):
            raise InputError(f"{path}: rows[{n}]: expected objects ms and errors")
    return path, found


def read(source, machine):
    """The file of all rivals, with their errors."""
    path, found = read_file(source, machine, NAME)
    calls = [call for rival in rivals_in(found) for call in RIVALS[rival]]
    for row in found["rows"]:
        check_rows(path, [row["ms"]], numbers=calls)
        if "errors" in row:
            check_rows(path, [row["errors"].get(call) for call in calls], numbers=("psnr_db",))
    return found


def rivals_in(found):
    """The renderers of a file, in the order of the table."""
    return [rival for rival in RIVALS if rival != OPTIONAL or any(rival in row["ms"] for row in found["rows"])]


def scenes_of(found):
    """{scene: its rows}"""
    scenes = {}
    for row in found["rows"]:
        scenes.setdefault(row["scene"], []).append(row)
    return scenes


def fastest(rows, calls):
    """(milliseconds, call) of the fastest call over the views of one scene."""
    return min((median(row["ms"][call] for row in rows), call) for call in calls)


def reached(rows, rival):
    """What a rival reaches over the views of one scene."""
    time, call = fastest(rows, RIVALS[rival])
    return Found(time, min((row["errors"][call]["psnr_db"] for row in rows if "errors" in row), default=None))


def rivals(source, machine):
    """Milliseconds and decibels of each on each scene."""
    found = read(source, machine)
    scenes, about = scenes_of(found), found["machine"]
    rows = []
    for rival in rivals_in(found):
        each = [reached(views, rival) for views in scenes.values()]
        rows.append([f"**{rival}**" if rival == "SwiftGS" else rival,
                     *(text for one in each for text in (ms(one.ms), decibel(one.db)))])
    described = ", ".join(
        f"{scene} ({gaussians(views[0]['gaussians'])} Gaussians, {'x'.join(map(str, views[0]['size']))})"
        for scene, views in scenes.items())
    judged = max(sum("errors" in row for row in views) for views in scenes.values())
    return (prose(f"Milliseconds a frame, the median over {views_of(scenes)} views of {described}; dB is PSNR against "
                  f"float64 in the worst of {judged} views. One {about['gpu']}, {about['date']}, commit "
                  f"{commit_of(about)}.")
            + "\n\n" + table(["", *(text for scene in scenes for text in (f"{scene}, ms", "dB"))], rows))


def views_of(scenes):
    numbers = sorted({len(views) for views in scenes.values()})
    return f"{numbers[0]} to {numbers[-1]}" if len(numbers) > 1 else str(numbers[0])


def rivals_planes(source, machine):
    """Milliseconds of frames with planes, and how many times those of colour they take, of SwiftGS and gsplat."""
    path, found = read_file(source, machine, PLANES_NAME)
    calls = [call for sets in WITH_PLANES.values() for of_set in sets.values() for call in of_set]
    check_rows(path, [row["ms"] for row in found["rows"]], numbers=calls)
    scenes, about = scenes_of(found), found["machine"]
    rows = []
    for rival, sets in WITH_PLANES.items():
        for planes, of_set in sets.items():
            row = [rival, planes]
            for views in scenes.values():
                colour, time = fastest(views, sets["colour"])[0], fastest(views, of_set)[0]
                row += [ms(time), "-" if planes == "colour" else f"{time / colour:.2f}"]
            rows.append(row)
    return (prose(f"Milliseconds a frame, the median over {views_of(scenes)} views, and how many times the frame of "
                  f"colour it takes. One {about['gpu']}, {about['date']}, commit {commit_of(about)}.")
            + "\n\n" + table(["", "planes", *(text for scene in scenes for text in (f"{scene}, ms", "times"))], rows,
                             words=2))


TABLES = {"rivals": rivals, "planes-rivals": rivals_planes}
