# SPDX-License-Identifier: Apache-2.0
"""Reads result files of the commands, which docs/schemas describes, and checks what tables take from them."""
import dataclasses
import json
import math
import os

STAGES = ("project", "sort", "raster", "total", "wall")
KEY = ("scene", "gaussians", "enlarge", "view", "scale", "conventions", "planes", "threads", "renderer")
WORDS = ("scene", "view", "conventions", "renderer", "backend", "sort", "raster", "bounds")
NEW_WORDS = ("planes", "harmonics")  # older files do not know others than those that a Row has by itself
NUMBERS = ("gaussians", "enlarge", "width", "height", "scale", "threads", "frames")
OPTIONAL = ("psnr_db", "ssim", "max_abs", "cut_psnr_db", "photo_psnr_db", "photo_ssim", "visible", "intersections",
            "contributing_pairs", "segments", "longest_item", "device_bytes", "host_bytes")


class InputError(Exception):
    """A file that cannot be used: which, what is wrong, and what was expected, in one line."""


@dataclasses.dataclass(frozen=True)
class Duration:
    """Milliseconds: a median with the limits of its 95 % confidence interval."""
    median: float
    low: float
    high: float


@dataclasses.dataclass(frozen=True)
class Row:
    """One renderer on one view. Numbers that a file does not know are None; the PSNR of equal images is infinite."""
    scene: str
    gaussians: int
    enlarge: float
    view: str
    width: int
    height: int
    scale: float
    conventions: str
    threads: int
    frames: int
    renderer: str
    backend: str
    sort: str
    raster: str
    bounds: str
    ms: dict
    psnr_db: float = None
    ssim: float = None
    max_abs: float = None
    cut_psnr_db: float = None
    photo_psnr_db: float = None
    photo_ssim: float = None
    visible: float = None
    intersections: float = None
    contributing_pairs: float = None
    segments: float = None
    longest_item: float = None
    device_bytes: float = None
    host_bytes: float = None
    bytes: dict = None
    counted_ms: dict = None
    planes: str = ""  #: beside colour
    harmonics: str = "floats"  #: as they are kept

    @property
    def key(self):
        """What rows of two files are matched by. The host's threads say nothing of a GPU."""
        return tuple(None if name == "threads" and self.backend == "cuda" else getattr(self, name) for name in KEY)

    @property
    def name(self):
        """SORT/RASTER/BOUNDS."""
        return f"{self.sort}/{self.raster}/{self.bounds}"

    @property
    def place(self):
        """The frame, whatever renders it."""
        return self.scene, self.gaussians, self.enlarge, self.view, self.scale, self.conventions

    @property
    def pixels(self):
        return self.width * self.height


@dataclasses.dataclass(frozen=True)
class Results:
    """A result file: members as they are there, rows checked."""
    path: str
    machine: dict
    command: str
    scenes: list
    views: list
    rows: list


def above_zero(path, row, *members):
    """Numbers of a row that a table cannot do without, stages by their medians; InputError where one is null or 0."""
    found = []
    for member in members:
        found.append(row.ms[member].median if member in STAGES else getattr(row, member))
        if found[-1] is None or found[-1] <= 0:
            raise InputError(f"{path}: {'ms.' if member in STAGES else ''}{member} of {row.renderer} on view "
                             f"{row.view!r} of {row.scene}: expected a number above 0")
    return found


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def read_json(path):
    """The JSON object in a file."""
    try:
        with open(path, encoding="utf-8") as file:
            found = json.load(file)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; expected a readable file") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: {error}; expected JSON") from None
    if not isinstance(found, dict):
        raise InputError(f"{path}: found a {type(found).__name__}; expected a JSON object")
    return found


def read_format(path, name, /, **members):
    """The object in a file of the format `name`; `members` are the types of those that it must have, dict or list."""
    found = read_json(path)
    if found.get("format") != name or found.get("version") != 1:
        raise InputError(f"{path}: format {found.get('format')!r}, version {found.get('version')!r}; "
                         f"expected {name!r}, 1")
    for member, kind in members.items():
        if not isinstance(found.get(member), kind):
            raise InputError(f"{path}: {member}: expected {'an object' if kind is dict else 'an array'}")
    return found


def check_rows(path, rows, texts=(), counts=(), numbers=(), optional=()):
    """InputError unless each row has these members: strings, numbers that are not negative, any numbers, and those that
    may be null or absent."""
    def check(member, right, expected):
        if not right:
            raise InputError(f"{path}: rows[{n}].{member}: expected {expected}")

    for n, row in enumerate(rows):
        if not isinstance(row, dict):
            raise InputError(f"{path}: rows[{n}]: expected an object")
        for name in texts:
            check(name, isinstance(row.get(name), str), "a string")
        for name in counts:
            check(name, is_number(row.get(name)) and row[name] >= 0, "a number that is not negative")
        for name in numbers:
            check(name, is_number(row.get(name)), "a number")
        for name in optional:
            check(name, row.get(name) is None or is_number(row[name]), "a number or null")


def read(path):
    """The Results in a file of `swiftgs bench`; InputError where it is no such file."""
    found = read_format(path, "swiftgs-bench", machine=dict, rows=list, scenes=list, views=list)
    check_rows(path, found["rows"], texts=WORDS, counts=NUMBERS, optional=OPTIONAL)
    for n, row in enumerate(found["rows"]):
        for name in NEW_WORDS:
            if not isinstance(row.get(name, ""), str):
                raise InputError(f"{path}: rows[{n}].{name}: expected a string")
    for name in ("scenes", "views"):
        for n, entry in enumerate(found[name]):
            if not isinstance(entry, dict):
                raise InputError(f"{path}: {name}[{n}]: expected an object")
    rows = [read_row(path, n, row) for n, row in enumerate(found["rows"])]
    seen = set()
    for n, row in enumerate(rows):
        if row.key in seen:
            raise InputError(f"{path}: rows[{n}]: {row.renderer} on view {row.view!r} of {row.scene} is there twice; "
                             "expected one row for each renderer on each view")
        seen.add(row.key)
    return Results(os.fspath(path), found["machine"], str(found.get("command", "")), found["scenes"], found["views"],
                   rows)


def read_row(path, n, row):
    def wrong(member, expected):
        return InputError(f"{path}: rows[{n}].{member}: expected {expected}")

    values = {name: row.get(name) for name in (*WORDS, *NUMBERS, *OPTIONAL)}
    # Of equal images the file has null, as it has where errors were not asked for; but then no difference either.
    if values["max_abs"] == 0 and values["psnr_db"] is None:
        values["psnr_db"] = math.inf
    return Row(**values, ms=read_durations(row.get("ms"), wrong), bytes=read_bytes(row.get("bytes"), wrong),
               counted_ms=read_counted(row.get("counted_ms"), wrong),
               **{name: row[name] for name in NEW_WORDS if name in row})


def read_bytes(found, wrong):
    """{stage: bytes of its buffers}; None where the file is older than these numbers."""
    if found is None:
        return None
    if not isinstance(found, dict):
        raise wrong("bytes", "an object")
    for stage in ("project", "sort", "raster"):
        if not is_number(found.get(stage)) or found[stage] < 0:
            raise wrong(f"bytes.{stage}", "a number that is not negative")
    return found


def read_counted(found, wrong):
    """{"raster", "balanced": milliseconds of a counted frame}; None where the file is older than these numbers."""
    if found is None:
        return None
    if not isinstance(found, dict):
        raise wrong("counted_ms", "an object")
    for name in ("raster", "balanced"):
        if not is_number(found.get(name)) or found[name] < 0:
            raise wrong(f"counted_ms.{name}", "a number that is not negative")
    return found


def read_durations(found, wrong):
    if not isinstance(found, dict):
        raise wrong("ms", "an object")
    durations = {}
    for stage in STAGES:
        limits = found.get(stage)
        numbers = [limits.get(name) for name in ("median", "low", "high")] if isinstance(limits, dict) else [None]
        if not all(is_number(value) and value >= 0 for value in numbers) or not numbers[1] <= numbers[0] <= numbers[2]:
            raise wrong(f"ms.{stage}", "low <= median <= high, milliseconds that are not negative")
        durations[stage] = Duration(*map(float, numbers))
    return durations
