# SPDX-License-Identifier: Apache-2.0
"""Frames from Python beside those from C++."""
from tables.markdown import count, significant, table
from tables.results import InputError, check_rows

NAME = "python.json"


def read(source, machine):
    """The rows of the file of python_overhead.py."""
    path = source.path(machine, NAME)
    rows = source.json(machine, NAME, "swiftgs-python", rows=list)["rows"]
    check_rows(path, rows, texts=("scene", "renderer"), counts=("gaussians",))
    for n, row in enumerate(rows):
        times = row.get("python_ms")
        if not isinstance(times, dict) or not {"out", "new", "nothing"} <= times.keys():
            raise InputError(f"{path}: rows[{n}].python_ms: expected an object with out, new and nothing")
        of_row = [row.get(name) for name in ("cpp_ms", "cpp_nothing_ms", "cpp_outside_us", "python_outside_us")]
        check_rows(path, [*of_row, *times.values()], numbers=("p10", "median"))
    return rows


def rate(times, of):
    """Frames a second."""
    return significant(1e3 / times[of]) if times and times[of] > 0 else "-"


def python(source, machine):
    """Frames a second in both languages, and what Python adds to each."""
    rows = []
    for row in read(source, machine):
        ms, backend = row["python_ms"], row["renderer"].partition("/")[0]
        for of in ("median", "p10"):
            added = row["python_outside_us"][of] - row["cpp_outside_us"][of]
            warm = (ms["nothing"][of] - row["cpp_nothing_ms"][of]) * 1e3
            rows.append([f"{row['scene']}, {count(row['gaussians'])}", f"`{backend}`", of, rate(row["cpp_ms"], of),
                         *(rate(ms.get(call), of) for call in ("out", "new", "arrays")), f"{added:.0f}", f"{warm:.1f}"])
    return table(["scene, Gaussians", "backend", "of frames", "C++, 1/s", "`out`, 1/s", "`new`, 1/s", "`arrays`, 1/s",
                  "Python adds, us", "in warm caches, us"], rows, words=3)


TABLES = {"python": python}
