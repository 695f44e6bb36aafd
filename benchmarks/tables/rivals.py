# SPDX-License-Identifier: Apache-2.0
"""This library beside gsplat, HiGS and Faster-GS: time against error of the same frames."""
import dataclasses
from statistics import median

from tables.frames import gaussians
from tables.markdown import decibel, ms, prose, table
from tables.results import InputError, check_rows
from tables.summary import commit_of

NAME = "rivals.json"
OPTIONAL = "Faster-GS"  # rivals.py may run without it
# Each with its calls, of which the fastest in a scene counts.
RIVALS = {"gsplat": ("gsplat", "gsplat, not packed"), OPTIONAL: (OPTIONAL,),
          "HiGS": ("HiGS, tiles of 8", "HiGS, tiles of 16"), "SwiftGS": ("SwiftGS",)}


@dataclasses.dataclass(frozen=True)
class Found:
    """What a renderer reaches on a scene: milliseconds, the median over the views, and dB of the worst view."""
    ms: float
    db: float


def read(source, machine):
    """The file of rivals.py."""
    path = source.path(machine, NAME)
    found = source.json(machine, NAME, "swiftgs-rivals", rows=list, machine=dict)
    check_rows(path, found["rows"], texts=("scene",), counts=("gaussians",))
    for n, row in enumerate(found["rows"]):
        if not isinstance(row.get("ms"), dict) or not isinstance(row.get("errors", {}), dict):
            raise InputError(f"{path}: rows[{n}]: expected objects ms and errors")
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


def reached(rows, rival):
    """What a rival reaches over the views of one scene."""
    times = {call: median(row["ms"][call] for row in rows) for call in RIVALS[rival]}
    call = min(times, key=times.get)
    return Found(times[call], min((row["errors"][call]["psnr_db"] for row in rows if "errors" in row), default=None))


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


TABLES = {"rivals": rivals}
