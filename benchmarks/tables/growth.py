# SPDX-License-Identifier: Apache-2.0
"""How the cost of each stage grows, along four axes: Gaussians, pixels, threads, tile occupancy."""
import collections
import dataclasses
import math

from tables.fits import dominance, exponent
from tables.frames import CHOLESKY, ELLIPSE, SQUARE
from tables.markdown import count, mebibytes, ms, table
from tables.results import InputError
from tables.source import machine_name

PARTS = ("project", "sort", "raster")
BEST = f"early/{CHOLESKY}/{ELLIPSE}"
RENDERERS = (BEST, f"standard/{CHOLESKY}/{ELLIPSE}", f"standard/per-pixel/{SQUARE}")
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
    "occupancy": Axis(("scaling-occupancy.json",), lambda row: row.instances / tiles(row), "instances a tile"),
}


def axis_named(name):
    if name not in AXES:
        raise InputError(f"no axis '{name}'; expected one of {', '.join(AXES)}")
    return AXES[name]


def series(source, machine, axis):
    """{(scene, renderer): rows in the order of the axis}"""
    found = collections.defaultdict(list)
    for name in axis.files:
        for row in source.results(machine, name).rows:
            if row.name in RENDERERS:
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


def growth(source, machine, axis_name):
    """Times and memory of the best renderer along an axis."""
    axis, rows = axis_named(axis_name), []
    for (scene, name), points in series(source, machine, axis).items():
        if name != BEST:
            continue
        for row in points:
            rows.append([scene, axis.text(axis.value(row)), count(row.visible), count(row.instances),
                         *(ms(row.ms[part].median) for part in (*PARTS, "total")), mebibytes(held(row))])
    results = source.results(machine, axis.files[0])
    device = f"{results.machine.get('cpu')}, {results.machine.get('cores')} cores" if axis_name == "threads" else \
        machine_name(results)
    return f"{device}, `{BEST}`, milliseconds:\n\n" + table(
        ["scene", axis.unit, "visible", "instances", *PARTS, "total", "memory, MiB"], rows)


def rounded(value):
    return f"{round(value, 2) + 0.0:.2f}"  # no -0.00


def fitted(values, measured):
    """The exponent of a fit, and in brackets that of its upper end; '-' where something is missing."""
    if any(y is None or y <= 0 for y in measured):
        return "-"
    points = list(zip(values, measured))
    whole, end = exponent(points), exponent(points[-END:])
    return "-" if whole is None else f"{rounded(whole)} ({rounded(end)})"


def exponents(source, machine, *axes):
    """The exponents of every stage along the axes."""
    rows = []
    for axis_name in axes:
        axis = axis_named(axis_name)
        for (scene, name), points in series(source, machine, axis).items():
            values = [axis.value(row) for row in points]
            rows.append([f"{axis.text(values[0])} to {axis.text(values[-1])} {axis.unit}", scene, f"`{name}`",
                         *(fitted(values, [row.ms[part].median for row in points]) for part in (*PARTS, "total")),
                         fitted(values, [held(row) for row in points])])
    return table(["axis", "scene", "sort/raster/bounds", *PARTS, "total", "memory"], rows, words=3)


def dominates(source, machine, *axes):
    """Which stage takes longest, and from where on."""
    rows = []
    for axis_name in axes:
        axis = axis_named(axis_name)
        for (scene, name), points in series(source, machine, axis).items():
            values = [axis.value(row) for row in points]
            found = dominance(values, {part: [row.ms[part].median for row in points] for part in PARTS})
            rows.append([f"{axis.text(values[0])} to {axis.text(values[-1])} {axis.unit}", scene, f"`{name}`",
                         "; ".join(stage if n == 0 else f"from {axis.text(x)} {stage}"
                                   for n, (stage, x) in enumerate(found))])
    return table(["axis", "scene", "sort/raster/bounds", "longest stage"], rows, words=4)


TABLES = {"growth": growth, "exponents": exponents, "dominates": dominates}
