# SPDX-License-Identifier: Apache-2.0
"""This library beside gsplat, and beside HiGS, gsplat's path for inference."""
from tables.markdown import count, decibel, ms, table
from tables.results import InputError, check_rows

NAME = "beside-gsplat.json"
CALLS = ("swiftgs", "swiftgs, matrices on the host", "swiftgs, scene kept", "gsplat", "gsplat, not packed")


def read(source, machine):
    """The file of beside_gsplat.py."""
    path = source.path(machine, NAME)
    found = source.json(machine, NAME, "swiftgs-beside-gsplat", rows=list)
    check_rows(path, found["rows"], texts=("scene",), counts=("gaussians", "views"))
    for n, row in enumerate(found["rows"]):
        if not isinstance(row.get("ms"), dict) or not isinstance(row.get("between_db"), list) or not row["between_db"]:
            raise InputError(f"{path}: rows[{n}]: expected an object ms and a list between_db that is not empty")
        check_rows(path, [row["ms"]], numbers=CALLS)
    return found


def beside_gsplat(source, machine):
    """Times of a call, and decibels between both."""
    return table(["scene, Gaussians", "views of a frame", *(f"{call}, ms" for call in CALLS), "between both, dB"],
                 [[f"{row['scene']}, {count(row['gaussians'])}", str(row["views"]),
                   *(ms(row["ms"][call]) for call in CALLS), decibel(min(row["between_db"]))]
                  for row in read(source, machine)["rows"]])


# (name of the row, those of its calls, of which the fastest counts, and its name in `from_float64`)
RIVALS = (("gsplat", ("gsplat", "gsplat, not packed"), "gsplat"),
          ("HiGS, gsplat's path for inference", ("HiGS, tiles of 8", "HiGS, tiles of 16"), "HiGS"),
          ("**SwiftGS**", ("swiftgs, scene kept",), "swiftgs"))


def rivals_of(source, machine):
    """{scene: [(rival, ms of a frame of one view, dB of the worst view from float64)]}"""
    found = read(source, machine)
    return {row["scene"]: [(name, min(row["ms"][call] for call in calls),
                            min(view[measured]["db"] for view in found["from_float64"][row["scene"]]))
                           for name, calls, measured in RIVALS]
            for row in found["rows"] if row["views"] == 1 and row["scene"] in found["from_float64"]}


def rivals(source, machine):
    """Times of a frame of one view, each scene kept on the device, and decibels from float64."""
    found = rivals_of(source, machine)
    return table(["", *(text for scene in found for text in (f"{scene}, ms", "dB"))],
                 [[name, *(text for each in found.values() for text in (ms(each[n][1]), decibel(each[n][2])))]
                  for n, (name, _, _) in enumerate(RIVALS)])


TABLES = {"beside-gsplat": beside_gsplat, "rivals": rivals}
