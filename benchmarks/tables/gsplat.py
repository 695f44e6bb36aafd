# SPDX-License-Identifier: Apache-2.0
"""`rasterization` of this library beside gsplat's own."""
from tables.markdown import count, decibel, ms, table
from tables.results import InputError, check_rows

NAME = "beside-gsplat.json"
CALLS = ("swiftgs", "swiftgs, matrices on the host", "gsplat", "gsplat, not packed")
KEPT = "swiftgs, scene kept"  # of pinholes alone


def read(source, machine):
    """The file of beside_gsplat.py."""
    path = source.path(machine, NAME)
    found = source.json(machine, NAME, "swiftgs-beside-gsplat", rows=list)
    check_rows(path, found["rows"], texts=("scene", "camera_model"), counts=("gaussians", "views"))
    for n, row in enumerate(found["rows"]):
        if not isinstance(row.get("ms"), dict) or not isinstance(row.get("between_db"), list) or not row["between_db"]:
            raise InputError(f"{path}: rows[{n}]: expected an object ms and a list between_db that is not empty")
        check_rows(path, [row["ms"]], numbers=CALLS, optional=(KEPT,))
    return found


def beside_gsplat(source, machine, *scenes):
    """Times of a call, and decibels between both; of these scenes, or else of all."""
    found, rows = read(source, machine)["rows"], []
    for scene in scenes:
        if scene not in {row["scene"] for row in found}:
            raise InputError(f"{source.path(machine, NAME)}: no row of {scene}; expected one")
    for row in found:
        if scenes and row["scene"] not in scenes:
            continue
        kept = ms(row["ms"][KEPT]) if KEPT in row["ms"] else "-"
        rows.append([f"{row['scene']}, {count(row['gaussians'])}", row["camera_model"], str(row["views"]),
                     *(ms(row["ms"][call]) for call in CALLS), kept, decibel(min(row["between_db"]))])
    return table(["scene, Gaussians", "`camera_model`", "views of a frame", *(f"{call}, ms" for call in (*CALLS, KEPT)),
                  "between both, dB"], rows, words=2)


TABLES = {"beside-gsplat": beside_gsplat}
