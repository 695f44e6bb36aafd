# SPDX-License-Identifier: Apache-2.0
"""Time and speed-up of the paper's steps: its Tables 1 and 2, and ours."""
from statistics import mean

from tables import paper
from tables.frames import BASELINE, OUR_STEPS, STEPS, Frames, average, known, label
from tables.markdown import decibel, heading, table, timed, times
from tables.source import machine_name


def paper_scenes(_source):
    """Table 1: each scene's times, speed-up and PSNR."""
    rows = []
    for run in paper.RUNS:
        before, after = paper.TIME[run]
        rows.append([run] + [f"{b:.2f} to {a:.2f}, {times(b / a)}" for b, a in zip(before, after)]
                    + [f"{mean(before):.2f} to {mean(after):.2f}, {times(mean(b / a for b, a in zip(before, after)))}"])
    for run in paper.RUNS:
        before, after = paper.PSNR[run]
        rows.append([f"{run}, dB"] + [f"{b:.2f} to {a:.2f}" for b, a in zip(before, after)]
                    + [f"{mean(before):.2f} to {mean(after):.2f}"])
    return table(["GPU, iterations", *paper.SCENES, "mean"], rows)


def paper_steps(_source):
    """Table 2, and the means of Table 1's rows for all steps together."""
    every = {**paper.STEPS, "all": tuple(mean(paper.TIME[run][1]) for run in paper.RUNS)}
    base = every["baseline"]
    return table(["step", *paper.RUNS], [[step] + [f"{t:.2f} ({times(b / t)})" for t, b in zip(row, base)]
                                         for step, row in every.items()])


def steps(source, machine):
    """Our Tables 1 and 2 on a machine: means over views, how many times the baseline's speed, and the accuracy of
    each."""
    frames = Frames(source.results(machine, "matrix.json"))
    photographs = {name: average([frames.mean_of(scene, name, "photo_psnr_db") for scene in frames.scenes])
                   for _, name in STEPS + OUR_STEPS}
    seen, rows = bool(known(photographs.values())), []
    spread, of_all = frames.spread(), frames.spread_of_all()
    for step, name in STEPS + OUR_STEPS:
        one, all_ = (None, None) if name == BASELINE else (spread, of_all)
        cells = [timed(frames.mean(scene, name), frames.speed_up(scene, name, BASELINE), one)
                 for scene in frames.scenes]
        rows.append([step, f"`{name}`", *cells, times(frames.speed_up_of_all(name, BASELINE), all_),
                     *([decibel(photographs[name])] if seen else []),
                     decibel(min(known(frames.worst_psnr(scene, name) for scene in frames.scenes), default=None))])
    header = ["step", "sort/raster/bounds", *map(label, frames.scenes), "geometric mean",
              *(["photographs, mean, dB"] if seen else []), "float64, worst, dB"]
    return frames.with_missing(
        heading(f"{machine_name(frames.results)}, `{frames.backend}`, milliseconds a frame", spread) + "\n\n"
        + table(header, rows, words=2))


def printed(_source):
    """What the paper prints beside what its own rows give."""
    rows = []

    def row(where, printed_, given):
        rows.append([where, printed_, given])

    row("largest number of intersections a Gaussian, sections 1, 3.1 and 4.1",
        f"{paper.RATIO_MOST_INTRODUCTION}, {paper.RATIO_MOST}, {100 * paper.SAVED_MOST:.2f} % saved",
        f"{paper.RATIO_MOST} saves {100 * paper.saved(paper.RATIO_MOST):.2f} %; {100 * paper.SAVED_MOST:.2f} % needs "
        f"{paper.ratio_for(paper.SAVED_MOST):.2f}")
    for run in paper.RUNS:
        given = [mean(values) for values in paper.TIME[run]]
        ratio = mean(b / a for b, a in zip(*paper.TIME[run]))
        before, after, speed_up = paper.TIME_PRINTED[run]
        if max(abs(before - given[0]), abs(after - given[1])) > 0.006 or abs(ratio - speed_up) > 0.006:
            row(f"Table 1, {run}, mean times", f"{before:.2f} to {after:.2f}, {times(speed_up)}",
                f"{given[0]:.2f} to {given[1]:.2f}; {times(ratio)} as mean of the ratios, "
                f"{times(given[0] / given[1])} as ratio of the means")
    for run in paper.RUNS:
        given = [mean(values) for values in paper.PSNR[run]]
        if max(abs(p - g) for p, g in zip(paper.PSNR_PRINTED[run], given)) > 0.006:
            row(f"Tables 1 and 3, {run}, mean PSNR", " to ".join(f"{p:.2f}" for p in paper.PSNR_PRINTED[run]),
                " to ".join(f"{g:.2f}" for g in given))
    for step, factors in paper.STEPS_PRINTED.items():
        for run, factor, time, base in zip(paper.RUNS, factors, paper.STEPS[step], paper.STEPS["baseline"]):
            if abs(factor - base / time) > 0.011:
                row(f"Table 2, {run}, {step}", times(factor), times(base / time))
    for what, value, given in zip(("original", "original and ours", "PUP-GS", "PUP-GS and ours"), paper.PRUNED_PRINTED,
                                  map(mean, paper.PRUNED)):
        if abs(value - given) > 0.006:
            row(f"Table 4, mean of '{what}'", f"{value:.2f} ms", f"{given:.2f} ms")
    return table(["where", "printed", "its own numbers give"], rows, words=3)


TABLES = {"paper-scenes": paper_scenes, "paper-steps": paper_steps, "steps": steps, "paper-printed": printed}
