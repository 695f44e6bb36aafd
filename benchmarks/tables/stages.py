# SPDX-License-Identifier: Apache-2.0
"""Stages of a frame: their shares (the paper's Figure 2), rasterization (Figure 8) and sorting (Figure 9)."""
from statistics import mean

from tables import paper
from tables.frames import BASELINE, BOX, CHOLESKY, OURS, SHARED, THRESHOLD, Frames, average, label
from tables.markdown import heading, ms, percent, signed, table, timed, times
from tables.source import machine_name

SORTS = ("standard", "early", "adaptive")
PARTS = ("project", "sort", "raster")


def shares(source, *machines):
    """Figure 2: of the sum of the three stages, with the baseline and with ours."""
    rest = 1 - sum(paper.SHARES.values())
    rows = [["paper, RTX 3090", "mean of seven scenes", percent(rest), percent(paper.SHARES["sort"]),
             percent(paper.SHARES["raster"]), "-", "-", "-"]]
    for machine in machines:
        results = source.results(machine, "matrix.json")
        frames = Frames(results)
        for scene in frames.scenes:
            cells = []
            for name in (BASELINE, OURS):
                parts = [frames.mean(scene, name, part) for part in PARTS]
                cells += ["-" if None in parts else percent(part / sum(parts)) for part in parts]
            rows.append([machine_name(results), label(scene), *cells])
    return table(["machine", "scene", "baseline: project", "sort", "raster", "ours: project", "sort", "raster"], rows,
                 words=2)


RASTER_STEPS = (("AR", SHARED + "half-split"), ("AR + AT", THRESHOLD + "half-split"),
                ("AR, float", SHARED + "float-split"), ("AR + AT, float", THRESHOLD + "float-split"),
                ("AR, Cholesky", SHARED + "float-cholesky"), ("AR + AT, Cholesky", CHOLESKY))


def raster_stage(source, machine):
    """Figure 8: milliseconds of rasterization, and how many times the baseline's speed."""
    results = source.results(machine, "matrix.json")
    frames = Frames(results)
    rows = [["baseline", "`per-pixel`", *(ms(frames.mean(scene, BASELINE, "raster")) for scene in frames.scenes),
             "1.00x"]]
    spread, of_all = frames.spread("raster"), frames.spread_of_all("raster")
    for step, raster in RASTER_STEPS:
        name = f"standard/{raster}/{BOX}"
        rows.append([step, f"`{raster}`", *(timed(frames.mean(scene, name, "raster"),
                                                  frames.speed_up(scene, name, BASELINE, "raster"), spread)
                                            for scene in frames.scenes),
                     times(frames.speed_up_of_all(name, BASELINE, "raster"), of_all)])
    return frames.with_missing(
        heading(f"{machine_name(results)}, milliseconds", spread) + "\n\n" + table(
            ["step", "rasterizer", *map(label, frames.scenes), "geometric mean"], rows, words=2))


def by_view(frames, scene, sort, bounds):
    """{view: milliseconds of the sort stage}, with the per-pixel rasterizer, as in the paper."""
    return {row.view: frames.needed(row, "sort") for row in frames.rows(scene, f"{sort}/per-pixel/{bounds}")}


def sort_stage(source, machine):
    """Figure 9: the sort stage of each strategy, over views, and the regret of the adaptive one."""
    results = source.results(machine, "matrix.json")
    frames = Frames(results)
    rows = []
    for scene in frames.scenes:
        for bounds in frames.bounds(scene, "standard/per-pixel"):
            standard, early, adaptive = (by_view(frames, scene, sort, bounds) for sort in SORTS)
            views = [view for view in standard if view in early]
            changes = [early[view] / standard[view] for view in views]
            means = [average(list(times_.values())) for times_ in (standard, early, adaptive)]
            gained = means[1] / means[0] if changes else None
            regret = None if None in means else means[2] / min(means[:2])
            intersections = mean(frames.needed(row, "intersections") / frames.needed(row, "visible")
                             for row in frames.rows(scene, f"standard/per-pixel/{bounds}"))
            rows.append([label(scene), bounds, f"{intersections:.2f}", *map(ms, means), signed(gained),
                         f"{signed(min(changes))} to {signed(max(changes))}" if changes else "-",
                         f"{sum(change < 1 for change in changes)} of {len(views)}", signed(regret)])
    return frames.with_missing(f"{machine_name(results)}, milliseconds, means over views:\n\n" + table(
        ["scene", "bounds", "intersections a visible Gaussian", "standard", "early", "adaptive", "early against standard",
         "over views", "views with early quicker", "adaptive against the better"], rows, words=2))


def paper_stages(_source):
    """Figures 8 and 9 in the words of sections 7.3.1 and 7.3.2."""
    places = ("indoor", "outdoor")
    return table(["stage", "step", *places], [
        ["raster", "AR", *(f"{100 * paper.RASTER_AR[place]:.2f} % quicker" for place in places)],
        ["raster", "AT, further", *(f"{100 * paper.RASTER_AT[place]:.2f} % quicker" for place in places)],
        ["sort", "ES, extremes", f"down to {-100 * paper.SORT_MOST_SAVED:+.2f} % (L40S)",
         f"up to {100 * paper.SORT_MOST_LOST:+.2f} % (RTX 3090)"]], words=2)


TABLES = {"shares": shares, "raster-stage": raster_stage, "sort-stage": sort_stage, "paper-stages": paper_stages}
