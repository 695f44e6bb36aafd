# SPDX-License-Identifier: Apache-2.0
"""How the cost of each stage grows, along four axes: Gaussians, pixels, threads, tile occupancy: power laws that fit
what was measured, and where one stage passes another."""
import collections
import dataclasses
import math

from tables.frames import BEST
from tables.markdown import count, table
from tables.blocks import machine_name
from tables.results import InputError

PARTS = ("project", "sort", "raster")
END = 3  # points of the fit at the upper end
TILE = 16  # pixels a side


class PowerLaw(collections.namedtuple("PowerLaw", "exponent x y")):
    """y * (at / x) ** exponent: a line through (x, y) in logarithms."""

    def __call__(self, at):
        return self.y * (at / self.x) ** self.exponent


def fit(points):
    """The PowerLaw that fits (x, y) best, by least squares of logarithms; through both where there are two. None for
    fewer than two x."""
    xs, ys = [math.log(x) for x, _ in points], [math.log(y) for _, y in points]
    mx, my = sum(xs) / len(xs), sum(ys) / len(ys)
    spread = sum((x - mx) ** 2 for x in xs)
    if not spread > 0:
        return None
    return PowerLaw(sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / spread, math.exp(mx), math.exp(my))


def crossing(first, second):
    """The x where two laws meet that were fitted at the same x."""
    return first.x * (second.y / first.y) ** (1 / (first.exponent - second.exponent))


def dominance(xs, curves):
    """[(name, x)]: which of `curves`, {name: y at each x}, is largest, and from which x on."""
    found = []
    for n, x in enumerate(xs):
        largest = max(curves, key=lambda name: curves[name][n])
        if found and largest != found[-1][0]:
            x = crossing(*(fit([(xs[m], curves[name][m]) for m in (n - 1, n)]) for name in (found[-1][0], largest)))
        if not found or largest != found[-1][0]:
            found.append((largest, x))
    return found


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
    """{scene: rows of the best renderer in the order of the axis}"""
    found = collections.defaultdict(list)
    for results in files_of(source, machine, axis):
        for row in results.rows:
            if row.name == BEST:
                found[row.scene].append(row)
    if not found:
        raise InputError(f"{', '.join(axis.files)}: no row of {BEST}; expected some")
    return {scene: sorted(rows, key=axis.value) for scene, rows in found.items()}


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
    found = dominance(values, {part: [row.median(part) for row in points] for part in PARTS})
    return "; ".join(stage if n == 0 else f"from {axis.text(x)} {stage}" for n, (stage, x) in enumerate(found))


def exponents(source, machine, *axes):
    """The exponents of the best renderer's stages along the axes, and the longest stage."""
    if not axes:
        raise InputError(f"table 'exponents': expected an axis or several of {', '.join(AXES)}")
    rows = []
    for axis in map(axis_named, axes):
        for scene, points in series(source, machine, axis).items():
            values = [axis.value(row) for row in points]
            rows.append([f"{axis.text(values[0])} to {axis.text(values[-1])} {axis.unit}", scene,
                         *(fitted(values, [row.median(part) for row in points]) for part in (*PARTS, "total")),
                         fitted(values, list(map(held, points))), longest(axis, values, points)])
    return f"{machine_name(files_of(source, machine, axis_named(axes[0]))[0])}, `{BEST}`:\n\n" + table(
        ["axis", "scene", *PARTS, "total", "memory", "longest stage"], rows, words=2)


TABLES = {"exponents": exponents}
