# SPDX-License-Identifier: Apache-2.0
"""What an H200 can do, and the least that each stage must do: the shortest time that a stage could take on it.

The ceilings were measured on one H200 (132 multiprocessors, CUDA 13.0), each by a program that does nothing else,
medians of repeated runs. The floors count what no implementation of the stage with these inputs and outputs, and with
sorts by eight bits a pass, can leave out, at the full rate of the unit that has most to do; launches, divergence, tests
of pairs that do not contribute, and reads that are repeated are what a measured stage has on top.
"""
from tables.fits import fit

COPY = 4.14e12  # bytes a second, read and written together
FMA = 30.0e12   # fused multiply-adds of single lanes a second, in float
EX2 = 4.14e12   # ex2.approx of single lanes a second, on a pipe of its own
# CUB's DeviceRadixSort::SortPairs with values of 32 bits: microseconds for these numbers of pairs.
SORT_SIZES = (0.1e6, 0.3e6, 1e6, 2e6, 5e6, 10e6)
SORT = {"32 bits": (67, 80, 86, 120, 228, 375),      # keys of 32 bits, as depths
        "13 of 16 bits": (39, 43, 48, 64, 114, 182),  # tiles, up to 8192 of them
        "45 of 64 bits": (92, 100, 139, 224, 398, 682)}  # tile and depth in one key

FLOAT = 4  # bytes
GEOMETRY = 3 + 3 + 4 + 1    # mean, scales, rotation and opacity of a Gaussian: floats
SHAPE = 2 + 3 + 1 + 1       # mean, conic, opacity and depth of a splat: floats
COLOUR = 3                  # of a splat or a pixel: floats
ID, DEPTH, TILE, BOTH = 4, 4, 2, 8  # bytes of a pair's value, and of its key: depth, tile, tile and depth
# Passes of a sort that moves pairs by eight bits at a time.
DEPTH_PASSES, TILE_PASSES, BOTH_PASSES = 4, 2, 6
# Of a contributing pair: two for the exponent in its shared form, cut, weight, transmittance, and three colours.
PAIR_FMA = 8


def sort_seconds(pairs, kind):
    """Of CUB: by power laws between the sizes that were measured, no less below them, in proportion beyond."""
    times = [t * 1e-6 for t in SORT[kind]]
    if pairs <= SORT_SIZES[0]:
        return times[0]
    if pairs >= SORT_SIZES[-1]:
        return times[-1] * pairs / SORT_SIZES[-1]
    n = next(n for n in range(1, len(SORT_SIZES)) if pairs <= SORT_SIZES[n])
    return fit(list(zip(SORT_SIZES[n - 1:n + 1], times[n - 1:n + 1])))(pairs)


def cub_sort(row):
    """Seconds of CUB for one sort of visible depths and one of intersections by tile, or one of intersections by both."""
    if row.sort == "standard":
        return sort_seconds(row.intersections, "45 of 64 bits")
    return sort_seconds(row.visible, "32 bits") + sort_seconds(row.intersections, "13 of 16 bits")


def project(row, _sh_degree):
    """(seconds, what bounds them): every Gaussian's geometry is read, a shape is written of those in view."""
    return FLOAT * (GEOMETRY * row.gaussians + SHAPE * row.visible) / COPY, "memory"


def sort(row, sh_degree):
    """Pairs are written once, then read and written in each pass; the colours are evaluated beside."""
    def moved(pairs, key, passes):
        return (key + ID) * pairs * (1 + 2 * passes)
    pairs = moved(row.intersections, BOTH, BOTH_PASSES) if row.sort == "standard" else \
        moved(row.visible, DEPTH, DEPTH_PASSES) + moved(row.intersections, TILE, TILE_PASSES)
    colours = FLOAT * (3 * (sh_degree + 1) ** 2 + COLOUR) * row.visible
    return (pairs + colours) / COPY, "memory"


def raster(row, _sh_degree):
    """Arithmetic of the contributing pairs, their exponentials, or splats, lists and image through memory."""
    bounds = {"multiply-adds": row.contributing_pairs * PAIR_FMA / FMA, "exponentials": row.contributing_pairs / EX2,
              "memory": FLOAT * ((SHAPE + COLOUR) * row.visible + row.intersections + COLOUR * row.pixels) / COPY}
    what = max(bounds, key=bounds.get)
    return bounds[what], what


FLOORS = {"project": project, "sort": sort, "raster": raster}
