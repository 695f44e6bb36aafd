# SPDX-License-Identifier: Apache-2.0
"""`rasterization` of this library beside gsplat's own."""
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


TABLES = {"beside-gsplat": beside_gsplat}
