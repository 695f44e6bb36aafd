# SPDX-License-Identifier: Apache-2.0
"""How the cost of each stage grows, along four axes: Gaussians, pixels, threads, tile occupancy."""
import collections
import dataclasses
import math

from tables.fits import dominance, fit
from tables.frames import CHOLESKY, ELLIPSE, SQUARE
from tables.markdown import count, ms, table
from tables.results import InputError, above_zero
from tables.source import machine_name

PARTS = ("project", "sort", "raster")
BEST = f"early/{CHOLESKY}/{ELLIPSE}"
STANDARD = f"standard/{CHOLESKY}/{ELLIPSE}"
RENDERERS = (BEST, STANDARD, f"standard/per-pixel/{SQUARE}")
NEEDED = ("width", "height", "visible", "intersections", *PARTS, "total")
END = 3  # points of the fit at the upper end
TILE = 16  # pixels a side


def tiles(row):
    return math.ceil(row.width / TILE) * math.ceil(row.height / TILE)


@dataclasses.dataclass(frozen=True)
class Axis:
    """What grows: its files, the number on the axis, and its unit."""
    files: tuple
    value: object
    unit: str

    def text(self, x):
        if self.unit.startswith("million"):
            return f"{x / 1e6:.3g}" if x < 1e7 else f"{x / 1e6:.0f}"
        return f"{x:.3g}" if x < 100 else count(x)


AXES = {
    "gaussians": Axis(("scaling-gaussians.json", "scaling-builtin.json"), lambda row: row.gaussians,
                      "million Gaussians"),
    "pixels": Axis(("scaling-pixels.json",), lambda row: row.pixels, "million pixels"),
    "threads": Axis(("scaling-threads.json",), lambda row: row.threads, "threads"),
    "occupancy": Axis(("scaling-occupancy.json",), lambda row: row.intersections / tiles(row), "intersections a tile"),
}


def axis_named(name):
    if name not in AXES:
        raise InputError(f"no axis '{name}'; expected one of {', '.join(AXES)}")
    return AXES[name]


def files_of(source, machine, axis):
    """The Results along an axis, of those files that the machine has: at least one."""
    there = [name for name in axis.files if source.has(machine, name)]
    return [source.results(machine, name) for name in there or axis.files]


def series(source, machine, axis):
    """{(scene, renderer): rows in the order of the axis}"""
    found = collections.defaultdict(list)
    for results in files_of(source, machine, axis):
        for row in results.rows:
            if row.name in RENDERERS:
                above_zero(results.path, row, *NEEDED)
                found[row.scene, row.name].append(row)
    for key, rows in found.items():
        rows.sort(key=axis.value)
        values = [axis.value(row) for row in rows]
        if not values[0] > 0 or len(set(values)) != len(values):
            raise InputError(f"{', '.join(axis.files)}: {key[1]} on {key[0]}: expected one row for each number of "
                             f"{axis.unit}, above 0")
    if not found:
        raise InputError(f"{', '.join(axis.files)}: no row of {BEST}; expected some")
    return found


def held(row):
    """Bytes of the memory that the renderer works in."""
    return row.device_bytes if row.backend == "cuda" else row.host_bytes


def rounded(value):
    return f"{round(value, 2) + 0.0:.2f}"  # no -0.00


def fitted(values, measured):
    """The exponent of a fit, and in brackets that of its upper end; '-' where something is missing."""
    if any(y is None or y <= 0 for y in measured):
        return "-"
    points = list(zip(values, measured))
    whole, end = fit(points), fit(points[-END:])
    return "-" if whole is None else f"{rounded(whole.exponent)} ({rounded(end.exponent)})"


def longest(axis, values, points):
    """Which stage takes longest, and from where on another does."""
    found = dominance(values, {part: [row.ms[part].median for row in points] for part in PARTS})
    return "; ".join(stage if n == 0 else f"from {axis.text(x)} {stage}" for n, (stage, x) in enumerate(found))


def exponents(source, machine, *axes):
    """The exponents of the best renderer's stages along the axes, and the longest stage."""
    if not axes:
        raise InputError(f"table 'exponents': expected an axis or several of {', '.join(AXES)}")
    rows = []
    for axis in map(axis_named, axes):
        for (scene, name), points in series(source, machine, axis).items():
            if name == BEST:
                values = [axis.value(row) for row in points]
                rows.append([f"{axis.text(values[0])} to {axis.text(values[-1])} {axis.unit}", scene,
                             *(fitted(values, [row.ms[part].median for row in points]) for part in (*PARTS, "total")),
                             fitted(values, list(map(held, points))), longest(axis, values, points)])
    return f"{machine_name(files_of(source, machine, axis_named(axes[0]))[0])}, `{BEST}`:\n\n" + table(
        ["axis", "scene", *PARTS, "total", "memory", "longest stage"], rows, words=2)


def sort_growth(source, machine, axis_name):
    """The sort stage of both strategies along an axis, and what early sorting does to it and to the frame."""
    axis, rows = axis_named(axis_name), []
    found = series(source, machine, axis)
    for scene in dict.fromkeys(scene for scene, _ in found):
        both = found[scene, BEST], found[scene, STANDARD]
        if len({tuple(map(axis.value, points)) for points in both}) > 1:
            raise InputError(f"{', '.join(axis.files)}: {scene}: expected rows of {BEST} and of {STANDARD} for the same "
                             f"numbers of {axis.unit}")
        for early, standard in zip(*both):
            rows.append([scene, axis.text(axis.value(early)), count(early.intersections),
                         *(ms(row.ms["sort"].median) for row in (standard, early)),
                         *(f"{100 * (early.ms[part].median / standard.ms[part].median - 1):+.1f} %"
                           for part in ("sort", "total"))])
    return f"{machine_name(files_of(source, machine, axis)[0])}, `{CHOLESKY}/{ELLIPSE}`, milliseconds of the sort:\n\n" + \
        table(["scene", axis.unit, "intersections", "standard", "early", "early against standard", "of the frame"], rows)


TABLES = {"sort-growth": sort_growth, "exponents": exponents}
