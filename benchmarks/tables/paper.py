# SPDX-License-Identifier: Apache-2.0
"""What Gao, Wang, Mo and Fan print in SwiftGS: the numbers that docs/reproduction.md puts beside ours."""

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
# Its column "Average" as printed: (gsplat, ours, speed-up) and PSNR.
TIME_PRINTED = {"RTX 3090, 7k": (6.31, 5.29, 1.20), "RTX 3090, 30k": (7.38, 6.43, 1.21),
                "L40S, 7k": (4.73, 3.93, 1.20), "L40S, 30k": (5.91, 4.77, 1.24)}
PSNR_PRINTED = {"RTX 3090, 7k": (27.45, 27.45), "RTX 3090, 30k": (29.17, 29.04),
                "L40S, 7k": (27.47, 27.47), "L40S, 30k": (29.23, 29.14)}

# Table 2: milliseconds, mean over the scenes, in the order of RUNS.
STEPS = {"baseline": (6.31, 7.38, 4.73, 5.77), "AR": (5.65, 6.63, 4.41, 5.41), "AR + AT": (5.49, 6.42, 4.31, 5.29),
         "ES": (6.20, 7.30, 4.27, 5.19), "ES + AES": (5.98, 7.07, 4.23, 5.13)}
STEPS_PRINTED = {"ES": (0.02, 0.01, 1.11, 1.11), "ES + AES": (0.06, 0.04, 1.12, 1.12)}  # its speed-ups

# Figure 2 in the text of section 3: mean shares on an RTX 3090; what is left is projection.
SHARES = {"raster": 0.5547, "sort": 0.2731}

# Figure 3 in the texts of sections 1 and 3.1: intersections a Gaussian, and what early sorting then saves by its formula.
RATIO_MEAN, RATIO_MOST, RATIO_MOST_INTRODUCTION = 2.37, 7.68, 7.61
SAVED_MEAN, SAVED_MOST = 0.2890, 0.4356

# Figures 8 and 9 in the texts of sections 7.3.1 and 7.3.2.
RASTER_AR = {"indoor": 0.2008, "outdoor": 0.1371}  # speed-up of the kernel by AR
RASTER_AT = {"indoor": 0.0673, "outdoor": 0.0567}  # and further by AT
SORT_MOST_LOST, SORT_MOST_SAVED = 0.2839, 0.4694   # RTX 3090 outdoor, L40S indoor

# Section 5.3: instructions of a thread for alpha.
INSTRUCTIONS = {("per-pixel", False): "12", ("half-split", False): "9.625",
                ("half-split", True): "9.625, 3 fewer where skipped"}

# Table 4: milliseconds of INRIA's rasterizer and of it with all techniques, then both for scenes that PUP-GS pruned.
PRUNED_SCENES = ("bicycle", "bonsai", "counter", "garden", "kitchen", "room", "stump")
PRUNED = ((69.49, 12.29, 16.60, 49.69, 18.89, 18.22, 31.93), (45.79, 9.00, 10.63, 34.03, 12.17, 12.03, 22.96),
          (26.97, 5.93, 7.71, 20.60, 7.16, 8.184, 17.40), (18.10, 4.17, 5.55, 13.78, 5.52, 5.56, 12.27))
PRUNED_PRINTED = (31.02, 20.66, 13.42, 9.28)


def saved(ratio):
    """The share of O(64 m) that O(32 (n + m)) saves, where m is `ratio` times n."""
    return (1 - 1 / ratio) / 2


def ratio_for(share):
    """The inverse of `saved`."""
    return 1 / (1 - 2 * share)


def lost(run):
    """[(scene, difference in dB)] of the scenes of Table 1 whose PSNR is not that of gsplat."""
    return [(scene, after - before) for scene, before, after in zip(SCENES, *PSNR[run]) if before != after]
