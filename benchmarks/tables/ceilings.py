# SPDX-License-Identifier: Apache-2.0
"""The shortest time that a stage could take on a GPU, beside the time that it takes.

`ceilings` measures what the GPU can do. The floors count what no implementation of the stage with these inputs and
outputs, and with sorts by eight bits a pass, can leave out, at the full rate of the unit that has most to do; launches,
divergence, tests of pairs that do not contribute, and reads that are repeated are what a measured stage has on top.
"""
from tables.frames import BEST, Frames, label
from tables.growth import fit
from tables.markdown import prose, significant, table
from tables.blocks import device, machine_name
from tables.results import InputError

DEPTHS, TILES = (32, 32), (16, 13)  # (bits of a key, those that are sorted by); 13 for 8192 tiles
FLOAT = ID = 4  # bytes; ID is a pair's value
GEOMETRY = 3 + 3 + 4 + 1    # mean, scales, rotation and opacity of a Gaussian: floats
SHAPE = 2 + 3 + 1 + 1       # mean, conic, opacity and depth of a splat: floats
COLOUR = 3                  # of a splat or a pixel: floats
# Of a contributing pair: two for the exponent in its shared form, cut, weight, transmittance, and three colours.
PAIR_FMA = 8


def sort_seconds(points, pairs):
    """Of CUB: by power laws between the sizes that were measured, no less below them, in proportion beyond."""
    (fewest, least), (most, longest) = points[0], points[-1]
    if pairs <= fewest:
        return least
    if pairs >= most:
        return longest * pairs / most
    n = next(n for n, (size, _) in enumerate(points) if pairs <= size)
    return fit(points[n - 1:n + 1])(pairs)


def project(row, _sh_degree, rates):
    """(seconds, what bounds them): every Gaussian's geometry is read, a shape is written of those in view."""
    return FLOAT * (GEOMETRY * row.gaussians + SHAPE * row.visible) / rates["copy"], "memory"


def sort(row, sh_degree, rates):
    """Pairs are written once, then read and written in each pass: four of depths and two of tiles, eight bits each. The
    colours are evaluated beside."""
    def moved(pairs, key, passes):
        return (key[0] // 8 + ID) * pairs * (1 + 2 * passes)
    colours = FLOAT * (3 * (sh_degree + 1) ** 2 + COLOUR) * row.visible
    return (moved(row.visible, DEPTHS, 4) + moved(row.intersections, TILES, 2) + colours) / rates["copy"], "memory"


def raster(row, _sh_degree, rates):
    """Arithmetic of the contributing pairs, their exponentials, or splats, lists and image through memory."""
    memory = FLOAT * ((SHAPE + COLOUR) * row.visible + row.intersections + COLOUR * row.pixels)
    bounds = {"multiply-adds": row.contributing_pairs * PAIR_FMA / rates["fma"],
              "exponentials": row.contributing_pairs / rates["ex2"], "memory": memory / rates["copy"]}
    what = max(bounds, key=bounds.get)
    return bounds[what], what


def gaps(source, machine):
    """Each stage of the best renderer against its floor, and its sort against CUB's of depths and of tiles."""
    results, (about, found) = source.results(machine, "matrix.json"), source.rows(machine, "ceilings.json")
    if machine_name(results) != device(about, "cuda"):
        raise InputError(f"{source.path(machine, 'ceilings.json')}: expected {machine_name(results)}, as matrix.json")
    rates, sorts = {row.ceiling: row.per_s for row in found if row.per_s}, {}
    for row in found:
        if row.pairs:
            sorts.setdefault((row.key_bits, row.sorted_bits), []).append((row.pairs, row.median("total") / 1e3))
    degrees = {(scene["scene"], scene["gaussians"]): scene["sh_degree"] for scene in results.scenes}
    frames, lines = Frames(results), []
    for scene in frames.scenes:
        row = frames.first_row(scene, BEST)
        compared = [(stage, *floor(row, degrees[row.scene, row.gaussians], rates))
                    for stage, floor in (("project", project), ("sort", sort), ("raster", raster))]
        compared.insert(2, ("sort", sort_seconds(sorts[DEPTHS], row.visible)
                            + sort_seconds(sorts[TILES], row.intersections), "CUB's sorts"))
        for stage, seconds, bound in compared:
            measured = row.median(stage) / 1e3
            lines.append([label(scene), stage, bound, *(significant(1e6 * time) for time in (seconds, measured)),
                          significant(measured / seconds, 2)])
    return prose(f"{machine_name(results)}: {rates['copy'] / 1e12:.2f} TB/s copied, {rates['fma'] / 1e12:.1f} T/s "
                 f"multiply-adds, {rates['ex2'] / 1e12:.2f} T/s exponentials. `{BEST}`, first views, microseconds:"
                 ) + "\n\n" + table(["scene", "stage", "beside", "least", "measured", "ratio"], lines, words=3)


TABLES = {"gaps": gaps}
