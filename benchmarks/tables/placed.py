# SPDX-License-Identifier: Apache-2.0
"""What placed scenes cost."""
from tables.markdown import ms, table
from tables.results import InputError, check_rows
from tables.source import backend, device

NAME = "placed.json"


def placed(source, machine):
    """Frames of placed scenes over those of one scene, which come first."""
    path = source.path(machine, NAME)
    results = source.json(machine, NAME, "swiftgs-placed", rows=list)
    check_rows(path, results["rows"], texts=("scene", "renderer", "frames", "size"), counts=("ms", "views"))
    first, rows = {}, []
    for row in results["rows"]:
        base = first.setdefault(row["scene"], row)["ms"]
        if base <= 0:
            raise InputError(f"{path}: scene {row['scene']!r}: expected a first frame of more than 0 ms")
        views = f", {row['views']:,} views" if row["views"] > 1 else ""
        rows.append([f"{row['scene']}{views}", row["frames"], ms(row["ms"]), f"{row['ms'] / base:.2f}"])
    copies = ", with the copies of poses to the device" if backend(machine) == "cuda" else ""
    return (f"{device(results['machine'], backend(machine))}, `{results['rows'][0]['renderer']}`; frames in a row{copies}:"
            "\n\n" + table(["scene", "frame", "ms", "over the first"], rows, words=2))


TABLES = {"placed": placed}
