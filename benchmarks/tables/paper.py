# SPDX-License-Identifier: Apache-2.0
"""What Gao, Wang, Mo and Fan print in SwiftGS: the numbers that docs/reproduction.md puts beside ours, and tables of
them."""
from statistics import mean

from tables.markdown import table, times

SCENES = ("bicycle", "garden", "stump", "bonsai", "counter", "kitchen", "room")  # three outdoor, then four indoor
RUNS = ("RTX 3090, 7k", "RTX 3090, 30k", "L40S, 7k", "L40S, 30k")  # GPU, iterations of training

# Table 1, in the order of SCENES: milliseconds and PSNR in dB of gsplat and of all techniques together.
TIME = {
    "RTX 3090, 7k": ((7.13, 7.18, 5.03, 4.50, 6.32, 8.34, 5.68), (6.23, 6.44, 4.55, 3.78, 4.97, 6.36, 4.57)),
    "RTX 3090, 30k": ((10.43, 8.14, 6.03, 5.07, 6.76, 8.42, 6.78), (9.10, 7.31, 5.41, 4.11, 5.28, 6.47, 5.26)),
    "L40S, 7k": ((5.63, 5.88, 3.93, 3.03, 4.53, 6.19, 3.93), (4.80, 5.18, 3.69, 2.73, 3.39, 4.42, 3.14)),
    "L40S, 30k": ((8.77, 6.93, 4.80, 3.48, 5.07, 6.34, 4.97), (7.64, 6.27, 4.42, 2.92, 3.69, 4.50, 3.67)),
}
PSNR = {
    "RTX 3090, 7k": ((24.03, 26.67, 25.84, 29.77, 27.27, 29.04, 31.52),
                     (24.03, 26.67, 25.84, 29.77, 27.27, 29.04, 31.52)),
    "RTX 3090, 30k": ((25.62, 27.79, 26.73, 32.34, 29.09, 31.21, 31.52),
                      (24.70, 27.79, 26.73, 32.34, 29.09, 31.21, 30.98)),
    "L40S, 7k": ((24.03, 26.62, 25.89, 29.77, 27.25, 29.20, 29.55),
                 (24.03, 26.62, 25.89, 29.77, 27.25, 29.20, 29.55)),
    "L40S, 30k": ((25.59, 27.75, 26.91, 32.21, 29.08, 31.43, 31.65),
                  (25.59, 27.75, 26.91, 32.21, 28.45, 31.43, 31.65)),
}
# Its column "Average" as printed.
PSNR_PRINTED = {"RTX 3090, 7k": (27.45, 27.45), "RTX 3090, 30k": (29.17, 29.04),
                "L40S, 7k": (27.47, 27.47), "L40S, 30k": (29.23, 29.14)}

# Table 2: milliseconds, mean over the scenes, in the order of RUNS.
STEPS = {"baseline": (6.31, 7.38, 4.73, 5.77), "AR": (5.65, 6.63, 4.41, 5.41), "AR + AT": (5.49, 6.42, 4.31, 5.29),
         "ES": (6.20, 7.30, 4.27, 5.19), "ES + AES": (5.98, 7.07, 4.23, 5.13)}

# Table 4: milliseconds of INRIA's rasterizer and of it with all techniques, then both for scenes that PUP-GS pruned.
PRUNED_SCENES = ("bicycle", "bonsai", "counter", "garden", "kitchen", "room", "stump")
PRUNED = ((69.49, 12.29, 16.60, 49.69, 18.89, 18.22, 31.93), (45.79, 9.00, 10.63, 34.03, 12.17, 12.03, 22.96),
          (26.97, 5.93, 7.71, 20.60, 7.16, 8.184, 17.40), (18.10, 4.17, 5.55, 13.78, 5.52, 5.56, 12.27))


def paper_scenes(_source):
    """Table 1: each scene's times, speed-up and PSNR."""
    rows = []
    for run in RUNS:
        before, after = TIME[run]
        rows.append([run] + [f"{b:.2f} to {a:.2f}, {times(b / a)}" for b, a in zip(before, after)]
                    + [f"{mean(before):.2f} to {mean(after):.2f}, {times(mean(b / a for b, a in zip(before, after)))}"])
    for run in RUNS:
        before, after = PSNR[run]
        rows.append([f"{run}, dB"] + [f"{b:.2f} to {a:.2f}" for b, a in zip(before, after)]
                    + [f"{mean(before):.2f} to {mean(after):.2f}"])
    return table(["GPU, iterations", *SCENES, "mean"], rows)


def paper_steps(_source):
    """Table 2, and the means of Table 1's rows for all steps together."""
    every = {**STEPS, "all": tuple(mean(TIME[run][1]) for run in RUNS)}
    base = every["baseline"]
    return table(["step", *RUNS], [[step] + [f"{t:.2f} ({times(b / t)})" for t, b in zip(row, base)]
                                   for step, row in every.items()])


def paper_accuracy(_source):
    """Table 3, and the scenes of Table 1 in which the difference lies."""
    rows = []
    for run in RUNS:
        (before, after), given = PSNR_PRINTED[run], [mean(values) for values in PSNR[run]]
        lost = [f"{scene} {a - b:+.2f}" for scene, b, a in zip(SCENES, *PSNR[run]) if a != b]
        rows.append([run, f"{before:.2f}", f"{after:.2f}", f"{after - before:+.2f}", f"{given[1] - given[0]:+.2f}",
                     ", ".join(lost) or "none"])
    return table(["GPU, iterations", "gsplat, dB", "axis-shared, dB", "difference", "of Table 1's rows",
                  "scenes that differ there"], rows)


def paper_pruned(_source):
    """Table 4, its means from its rows."""
    columns = [values + (mean(values),) for values in PRUNED]
    rows = [[scene, f"{a:.2f}", f"{b:.2f}", times(a / b), f"{c:.2f}", f"{d:.2f}", times(c / d)]
            for scene, a, b, c, d in zip(PRUNED_SCENES + ("mean",), *columns)]
    return table(["scene", "INRIA", "and all", "speed-up", "PUP-GS", "and all", "speed-up"], rows)


TABLES = {"paper-scenes": paper_scenes, "paper-steps": paper_steps, "paper-accuracy": paper_accuracy,
          "paper-pruned": paper_pruned}
