# SPDX-License-Identifier: Apache-2.0
"""Frames from Python beside those from C++."""
from tables.markdown import count, significant, table
from tables.results import InputError, check_rows
from tables.source import device

NAME = "python.json"


def read(source, machine):
    """The file of python_overhead.py."""
    path = source.path(machine, NAME)
    found = source.json(machine, NAME, "swiftgs-python", machine=dict, rows=list)
    rows = found["rows"]
    check_rows(path, rows, texts=("scene", "renderer"), counts=("gaussians",))
    for n, row in enumerate(rows):
        times = row.get("python_ms")
        if not isinstance(times, dict) or not {"out", "new"} <= times.keys():
            raise InputError(f"{path}: rows[{n}].python_ms: expected an object with out and new")
        of_row = [row.get(name) for name in ("cpp_ms", "cpp_outside_us", "python_outside_us")]
        check_rows(path, [*of_row, *times.values()], numbers=("p10", "median"))
    return found


def rate(times, of):
    """Frames a second."""
    return significant(1e3 / times[of]) if times and times[of] > 0 else "-"


def python(source, *machines):
    """Frames a second in both languages, and what Python adds to each."""
    rows = []
    for machine, row in ((machine, row) for machine in machines for row in read(source, machine)["rows"]):
        ms = row["python_ms"]
        of_row = [device(read(source, machine)["machine"], row["renderer"].partition("/")[0]),
                  f"{row['scene']}, {count(row['gaussians'])}"]
        for of in ("median", "p10"):
            added = row["python_outside_us"][of] - row["cpp_outside_us"][of]
            rows.append([*of_row, of, rate(row["cpp_ms"], of),
                         *(rate(ms.get(call), of) for call in ("out", "new", "arrays")), f"{added:.0f}"])
    return table(["device", "scene, Gaussians", "of frames", "C++, 1/s", "`out`, 1/s", "`new`, 1/s", "`arrays`, 1/s",
                  "Python adds, us"], rows, words=3)


TABLES = {"python": python}
