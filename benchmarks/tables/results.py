# SPDX-License-Identifier: Apache-2.0
"""Reads result files, which docs/schemas/bench.schema.json describes, and checks what tables take from them."""
import dataclasses
import json
import math
import os

STAGES = ("project", "sort", "raster", "total", "wall")
KEY = ("scene", "gaussians", "enlarge", "view", "scale", "conventions", "planes", "threads", "renderer")
WORDS = ("scene", "view", "conventions", "renderer", "backend", "sort", "raster", "bounds")
NUMBERS = ("gaussians", "enlarge", "width", "height", "scale", "threads", "frames")
OPTIONAL = ("psnr_db", "ssim", "max_abs", "cut_psnr_db", "photo_psnr_db", "photo_ssim", "visible", "intersections",
            "contributing_pairs", "device_bytes", "host_bytes")


class InputError(Exception):
    """A file that cannot be used: which, what is wrong, and what was expected, in one line."""


@dataclasses.dataclass(frozen=True)
class Duration:
    """Milliseconds: a median with the limits of its 95 % confidence interval, where the file has them."""
    median: float
    low: float = None
    high: float = None
    p10: float = None


class Row:
    """One renderer on one view, with the members of the file; those that it lacks are None. `ms` holds durations."""

    def __init__(self, members):
        self.__dict__.update(members)
        self.ms = {stage: Duration(ms["median"], ms.get("low"), ms.get("high"), ms.get("p10"))
                   for stage, ms in members.get("ms", {}).items()}
        # Of equal images the file has null, as it has where errors were not asked for; but then no difference either.
        if self.max_abs == 0 and self.psnr_db is None:
            self.psnr_db = math.inf

    def __getattr__(self, name):
        return None

    @property
    def key(self):
        """What rows of two files are matched by. The host's threads say nothing of a GPU."""
        return tuple(None if name == "threads" and self.backend == "cuda" else getattr(self, name) or "" for name in KEY)

    @property
    def name(self):
        """SORT/RASTER/BOUNDS."""
        return f"{self.sort}/{self.raster}/{self.bounds}"

    @property
    def pixels(self):
        return self.width * self.height

    def median(self, stage):
        """Milliseconds; None where the stage was not timed."""
        return self.ms[stage].median if stage in self.ms else None


@dataclasses.dataclass(frozen=True)
class Results:
    """A result file: members as they are there, rows checked."""
    path: str
    machine: dict
    command: str
    scenes: list
    rows: list


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def read_format(path, name="swiftgs-bench"):
    """The JSON object in a file of this format, with a machine and rows that are objects."""
    try:
        with open(path, encoding="utf-8") as file:
            found = json.load(file)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; expected a readable file") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: {error}; expected JSON") from None
    if not isinstance(found, dict) or (found.get("format"), found.get("version")) != (name, 1):
        raise InputError(f"{path}: expected a JSON object of the format {name!r}, version 1")
    rows = found.get("rows")
    if not isinstance(found.get("machine"), dict) or not isinstance(rows, list) or \
            not all(isinstance(row, dict) for row in rows):
        raise InputError(f"{path}: expected an object 'machine' and an array 'rows' of objects")
    return found


def check_bench_row(path, n, row):
    """InputError unless `swiftgs bench` may have written the row: others have times and members of their own."""
    def check(member, right, expected):
        if not right:
            raise InputError(f"{path}: rows[{n}].{member}: expected {expected}")

    for name in WORDS:
        check(name, isinstance(row.get(name), str), "a string")
    for name in NUMBERS:
        check(name, is_number(row.get(name)) and row[name] >= 0, "a number that is not negative")
    for name in OPTIONAL:
        check(name, row.get(name) is None or is_number(row[name]), "a number or null")
    times = row.get("ms")
    check("ms", isinstance(times, dict), "an object")
    for stage in STAGES:
        limits = times.get(stage)
        numbers = [limits.get(name) for name in ("low", "median", "high")] if isinstance(limits, dict) else [None]
        check(f"ms.{stage}", all(map(is_number, numbers)) and 0 <= numbers[0] <= numbers[1] <= numbers[2],
              "low <= median <= high, milliseconds that are not negative")


def read(path):
    """The Results in a file of `swiftgs bench`; InputError where it is no such file."""
    found = read_format(path)
    for n, row in enumerate(found["rows"]):
        check_bench_row(path, n, row)
    rows = [Row(row) for row in found["rows"]]
    if len({row.key for row in rows}) != len(rows):
        raise InputError(f"{path}: rows: expected one row for each renderer on each view")
    return Results(os.fspath(path), found["machine"], str(found.get("command", "")), found.get("scenes", []), rows)
