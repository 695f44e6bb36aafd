# SPDX-License-Identifier: Apache-2.0
"""How often a Gaussian is sorted: the paper's Figure 3."""
from statistics import mean

from tables import paper
from tables.frames import Frames, gaussians
from tables.markdown import count, percent, table
from tables.results import InputError
from tables.source import machine_name


def redundancy(source, machine):
    """Gaussians, intersections and their ratio over the views of each scene, with each bounds."""
    results = source.results(machine, "matrix.json")
    frames = Frames(results)
    rows = [["paper, seven scenes", "box", "-", "-", "-", f"{paper.RATIO_MEAN:.2f}", f"{paper.RATIO_MOST:.2f}",
             percent(paper.saved(paper.RATIO_MEAN))]]
    for scene in frames.scenes:
        for bounds in frames.bounds(scene, "standard/per-pixel"):
            views = frames.rows(scene, f"standard/per-pixel/{bounds}")
            views = [row for row in views if row.visible != 0]  # a view of nothing has no ratio
            ratios = [frames.needed(row, "intersections") / frames.needed(row, "visible") for row in views]
            if not views:
                raise InputError(f"{results.path}: visible on {scene.name}: 0 in every view; expected some")
            rows.append([f"{scene.name}, {gaussians(scene.gaussians)}, {len(views)} views", bounds,
                         count(mean(r.visible for r in views)), count(mean(r.intersections for r in views)),
                         count(max(r.intersections for r in views)),
                         f"{mean(ratios):.2f}", f"{max(ratios):.2f}",
                         percent(mean(map(paper.saved, ratios)))])
    return table(["scene", "bounds", "visible Gaussians, mean", "intersections, mean", "most", "a visible Gaussian, mean",
                  "most", "early sorting saves by the paper's formula"], rows, words=2) + \
        f"\n\nCounted on {machine_name(results)}."


TABLES = {"redundancy": redundancy}
