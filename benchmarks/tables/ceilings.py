# SPDX-License-Identifier: Apache-2.0
"""What a GPU can do, and the least that each stage must do: the shortest time that a stage could take on it.

`ceilings` measures what the GPU can do. The floors count what no implementation of the stage with these inputs and
outputs, and with sorts by eight bits a pass, can leave out, at the full rate of the unit that has most to do; launches,
divergence, tests of pairs that do not contribute, and reads that are repeated are what a measured stage has on top.
"""
import dataclasses

from tables.fits import fit
from tables.results import InputError, is_number
from tables.source import device

NAME = "ceilings.json"
DEPTHS, TILES, BOTH = (32, 32), (16, 13), (64, 45)  # (bits of a key, those that are sorted by); 13 for 8192 tiles

FLOAT = 4  # bytes
GEOMETRY = 3 + 3 + 4 + 1    # mean, scales, rotation and opacity of a Gaussian: floats
SHAPE = 2 + 3 + 1 + 1       # mean, conic, opacity and depth of a splat: floats
COLOUR = 3                  # of a splat or a pixel: floats
ID = 4  # bytes of a pair's value
# Passes of a sort that moves pairs by eight bits at a time.
DEPTH_PASSES, TILE_PASSES, BOTH_PASSES = 4, 2, 6
# Of a contributing pair: two for the exponent in its shared form, cut, weight, transmittance, and three colours.
PAIR_FMA = 8


@dataclasses.dataclass(frozen=True)
class Ceilings:
    """What `device` does a second at most. `sorts` holds pairs and seconds, growing, of CUB's sort for each key."""
    device: str
    copy: float  #: bytes, read and written together
    fma: float   #: fused multiply-adds of single lanes, in float
    ex2: float   #: ex2.approx of single lanes, on a pipe of its own
    sorts: dict

    def sort_seconds(self, pairs, key):
        """Of CUB: by power laws between the sizes that were measured, no less below them, in proportion beyond."""
        points = self.sorts[key]
        (fewest, least), (most, longest) = points[0], points[-1]
        if pairs <= fewest:
            return least
        if pairs >= most:
            return longest * pairs / most
        n = next(n for n, (size, _) in enumerate(points) if pairs <= size)
        return fit(points[n - 1:n + 1])(pairs)


def read(source, machine):
    """The Ceilings in the file of `ceilings`."""
    path = source.path(machine, NAME)
    found = source.json(machine, NAME, "swiftgs-ceilings", machine=dict, sorts=list)

    def positive(values):
        return isinstance(values, list) and values != [] and all(is_number(value) and value > 0 for value in values)

    for name in ("copy_bytes_per_s", "fma_per_s", "ex2_per_s"):
        if not positive([found.get(name)]):
            raise InputError(f"{path}: {name}: expected a number above 0")
    sorts = {}
    for n, row in enumerate(found["sorts"]):
        key, pairs, times = ([row.get("key_bits"), row.get("sorted_bits")], row.get("pairs"), row.get("us")) \
            if isinstance(row, dict) else (None, None, None)
        if not all(map(positive, (key, pairs, times))) or len(pairs) != len(times) or pairs != sorted(set(pairs)):
            raise InputError(f"{path}: sorts[{n}]: expected key_bits, sorted_bits, growing pairs, and as many us, all "
                             "above 0")
        sorts[tuple(key)] = [(size, 1e-6 * us) for size, us in zip(pairs, times)]
    for key in (DEPTHS, TILES, BOTH):
        if key not in sorts:
            raise InputError(f"{path}: sorts: expected one with key_bits {key[0]} and sorted_bits {key[1]}")
    return Ceilings(device(found["machine"], "cuda"), found["copy_bytes_per_s"], found["fma_per_s"],
                    found["ex2_per_s"], sorts)


def cub_sort(row, most):
    """Seconds of CUB for one sort of visible depths and one of intersections by tile, or one of intersections by both."""
    if row.sort == "standard":
        return most.sort_seconds(row.intersections, BOTH)
    return most.sort_seconds(row.visible, DEPTHS) + most.sort_seconds(row.intersections, TILES)


def project(row, _sh_degree, most):
    """(seconds, what bounds them): every Gaussian's geometry is read, a shape is written of those in view."""
    return FLOAT * (GEOMETRY * row.gaussians + SHAPE * row.visible) / most.copy, "memory"


def sort(row, sh_degree, most):
    """Pairs are written once, then read and written in each pass; the colours are evaluated beside."""
    def moved(pairs, key, passes):
        return (key[0] // 8 + ID) * pairs * (1 + 2 * passes)
    pairs = moved(row.intersections, BOTH, BOTH_PASSES) if row.sort == "standard" else \
        moved(row.visible, DEPTHS, DEPTH_PASSES) + moved(row.intersections, TILES, TILE_PASSES)
    colours = FLOAT * (3 * (sh_degree + 1) ** 2 + COLOUR) * row.visible
    return (pairs + colours) / most.copy, "memory"


def raster(row, _sh_degree, most):
    """Arithmetic of the contributing pairs, their exponentials, or splats, lists and image through memory."""
    memory = FLOAT * ((SHAPE + COLOUR) * row.visible + row.intersections + COLOUR * row.pixels)
    bounds = {"multiply-adds": row.contributing_pairs * PAIR_FMA / most.fma,
              "exponentials": row.contributing_pairs / most.ex2, "memory": memory / most.copy}
    what = max(bounds, key=bounds.get)
    return bounds[what], what


FLOORS = {"project": project, "sort": sort, "raster": raster}
