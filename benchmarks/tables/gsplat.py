# SPDX-License-Identifier: Apache-2.0
"""`rasterization` of this library beside gsplat's own."""
from tables.markdown import count, decibel, ms, table
from tables.results import InputError, check_rows

NAME = "beside-gsplat.json"
WORLDS_NAME = "beside-gsplat-worlds.json"
CALLS = ("swiftgs", "swiftgs, matrices on the host", "gsplat", "gsplat, not packed")
CALLS_OF_WORLDS = tuple(call for call in CALLS if call != "gsplat")  # whose packed way draws no batches
KEPT = "swiftgs, scene kept"  # of pinholes alone


def read(source, machine):
    """The file of beside_gsplat.py."""
    path = source.path(machine, NAME)
    found = source.json(machine, NAME, "swiftgs-beside-gsplat", rows=list)
    check_rows(path, found["rows"], texts=("scene", "camera_model"), counts=("gaussians", "views"))
    check_calls(path, "rows", found["rows"], CALLS)
    return found


def check_calls(path, section, rows, calls):
    """InputError unless each row has the times of these calls and decibels."""
    for n, row in enumerate(rows):
        if not isinstance(row.get("ms"), dict) or not isinstance(row.get("between_db"), list) or not row["between_db"]:
            raise InputError(f"{path}: {section}[{n}]: expected an object ms and a list between_db that is not empty")
        check_rows(path, [row["ms"]], numbers=calls, optional=(KEPT,))


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


def beside_gsplat_of_worlds(source, machine):
    """Times of a call that draws a batch of scenes, and images a second of each library's fastest call."""
    path = source.path(machine, WORLDS_NAME)
    found, rows = source.json(machine, WORLDS_NAME, "swiftgs-beside-gsplat", worlds=list)["worlds"], []
    check_rows(path, found, counts=("worlds", "gaussians", "views"))
    check_calls(path, "worlds", found, CALLS_OF_WORLDS)
    for row in found:
        if min(row["ms"].values()) <= 0 or not isinstance(row.get("size"), list):
            raise InputError(f"{path}: worlds: expected times above 0 and a list size")
        fastest = (min(row["ms"][call] for call in CALLS_OF_WORLDS if call.startswith(name))
                   for name in ("swiftgs", "gsplat"))
        rows.append([f"{count(row['worlds'])} of {count(row['gaussians'])}",
                     f"{count(row['views'])} of {'x'.join(map(str, row['size']))}",
                     *(ms(row["ms"][call]) for call in CALLS_OF_WORLDS),
                     *(count(row["worlds"] * row["views"] / time * 1e3) for time in fastest),
                     decibel(min(row["between_db"]))])
    return table(["worlds, Gaussians of each", "views of each", *(f"{call}, ms" for call in CALLS_OF_WORLDS),
                  "swiftgs, images/s", "gsplat, images/s", "between both, dB"], rows, words=2)


TABLES = {"beside-gsplat": beside_gsplat, "beside-gsplat-worlds": beside_gsplat_of_worlds}
