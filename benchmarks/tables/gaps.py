# SPDX-License-Identifier: Apache-2.0
"""Stages on the GPU beside the shortest time that its ceilings allow."""
from tables import ceilings
from tables.frames import Frames, label
from tables.growth import BEST
from tables.markdown import prose, significant, table
from tables.results import InputError
from tables.source import machine_name

NEEDED = ("visible", "intersections", "contributing_pairs")


def sh_degrees(results):
    """{(scene, Gaussians): degree}"""
    return {(scene.get("scene"), scene.get("gaussians")): scene.get("sh_degree") for scene in results.scenes}


def gaps_of(results, row, most):
    """{stage: (measured ms, floor ms, what bounds it)} of a row."""
    degree = sh_degrees(results).get((row.scene, row.gaussians))
    if degree is None or any(getattr(row, name) is None for name in NEEDED):
        raise InputError(f"{results.path}: {row.renderer} on {row.scene}: expected its sh_degree and counts")
    found = {}
    for stage, floor in ceilings.FLOORS.items():
        seconds, bound = floor(row, degree, most)
        found[stage] = row.ms[stage].median, 1e3 * seconds, bound
    return found


def ceiling_table(source, machine):
    """The ceilings, as measured."""
    most = ceilings.read(source, machine)
    rows = [["copy in memory, read and written", f"{most.copy / 1e12:.2f} TB/s"],
            ["fused multiply-adds, float", f"{most.fma / 1e12:.1f} T/s"],
            ["`ex2.approx`", f"{most.ex2 / 1e12:.2f} T/s"]]
    for (bits, by), points in most.sorts.items():
        rows.append([f"sort by {by if by == bits else f'{by} of {bits}'} bits of the keys, 32-bit values", "; ".join(
            f"{size / 1e6:g} M in {1e6 * seconds:.0f} us" for size, seconds in points)])
    return f"{most.device}:\n\n" + table(["what", "most"], rows, words=2)


def first_rows(source, machine):
    """(Results, Ceilings, [(scene, row)]) of the first view of each scene; both of one device."""
    results, most = source.results(machine, "matrix.json"), ceilings.read(source, machine)
    if machine_name(results) != most.device:
        raise InputError(f"{source.path(machine, ceilings.NAME)}: measured on {most.device}; expected "
                         f"{machine_name(results)}, as matrix.json")
    frames = Frames(results)
    return results, most, [(scene, frames.first_row(scene, BEST)) for scene in frames.scenes]


def gaps(source, machine):
    """Each stage of the best renderer against its floor."""
    results, most, found = first_rows(source, machine)
    rows = []
    for scene, row in found:
        compared = [(stage, *gap) for stage, gap in gaps_of(results, row, most).items()]
        compared.append(("sort", row.ms["sort"].median, 1e3 * ceilings.cub_sort(row, most), "CUB's sorts"))
        for stage, measured, floor, bound in sorted(compared, key=lambda gap: list(ceilings.FLOORS).index(gap[0])):
            rows.append([label(scene), stage, bound, significant(1e3 * floor), significant(1e3 * measured),
                         significant(measured / floor, 2)])
    return f"{machine_name(results)}, `{BEST}`, first views, microseconds:\n\n" + table(
        ["scene", "stage", "beside", "least", "measured", "ratio"], rows, words=3)


def largest_gap(source, machine):
    """The stage with the largest ratio, and the one with most milliseconds to gain, in two sentences."""
    results, most, rows = first_rows(source, machine)
    found = [(scene, stage, measured, floor, bound) for scene, row in rows
             for stage, (measured, floor, bound) in gaps_of(results, row, most).items()]
    scene, stage, measured, floor, bound = max(found, key=lambda gap: gap[2] / gap[3])
    text = (f"The largest gap is that of `{stage}` in {label(scene)}: {significant(1e3 * measured)} us are "
            f"{significant(measured / floor, 2)} times what its {bound} would take. ")
    scene, stage, measured, floor, bound = max(found, key=lambda gap: gap[2] - gap[3])
    return prose(text + f"Most time is to be gained from `{stage}` in {label(scene)}: "
                        f"{significant(1e3 * (measured - floor))} of {significant(1e3 * measured)} us.")


TABLES = {"ceilings": ceiling_table, "gaps": gaps, "largest-gap": largest_gap}
