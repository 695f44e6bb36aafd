# SPDX-License-Identifier: Apache-2.0
"""`rasterization` of this library beside gsplat's own."""
from tables.markdown import count, decibel, ms, table
from tables.results import InputError, check_rows

NAME = "beside-gsplat.json"
CALLS = ("swiftgs", "swiftgs, matrices on the host", "swiftgs, scene kept", "gsplat", "gsplat, not packed")
DISTANCES = ("db", "otherwise", "db_of_others")


def read(source, machine):
    """The file of beside_gsplat.py."""
    path = source.path(machine, NAME)
    found = source.json(machine, NAME, "swiftgs-beside-gsplat", rows=list, from_float64=dict)
    check_rows(path, found["rows"], texts=("scene",), counts=("gaussians", "views"))
    for n, row in enumerate(found["rows"]):
        if not isinstance(row.get("ms"), dict) or not isinstance(row.get("between_db"), list) or not row["between_db"]:
            raise InputError(f"{path}: rows[{n}]: expected an object ms and a list between_db that is not empty")
        check_rows(path, [row["ms"]], numbers=CALLS)
    for scene, views in found["from_float64"].items():
        if not isinstance(views, list) or not all(isinstance(view, dict) for view in views):
            raise InputError(f"{path}: from_float64.{scene}: expected a list of objects")
        for view in views:
            check_rows(path, [view.get("swiftgs"), view.get("gsplat")], numbers=DISTANCES)
    return found


def beside_gsplat(source, machine):
    """Times of a call, and decibels between both."""
    return table(["scene, Gaussians", "views of a frame", *(f"{call}, ms" for call in CALLS), "between both, dB"],
                 [[f"{row['scene']}, {count(row['gaussians'])}", str(row["views"]),
                   *(ms(row["ms"][call]) for call in CALLS), decibel(min(row["between_db"]))]
                  for row in read(source, machine)["rows"]])


def gsplat_exactness(source, machine):
    """How far both are from float64, by view."""
    rows = []
    for scene, views in read(source, machine)["from_float64"].items():
        for name in ("swiftgs", "gsplat"):
            cells = ([view[name][key] for view in views] for key in DISTANCES)
            db, otherwise, others = cells
            rows.append([scene, name, ", ".join(map(decibel, db)), ", ".join(map(count, otherwise)),
                         ", ".join(map(decibel, others))])
    return table(["scene", "drawn by", "from float64, dB", "pixels that decide otherwise", "of the others, dB"], rows,
                 words=2)


TABLES = {"beside-gsplat": beside_gsplat, "gsplat-exactness": gsplat_exactness}
