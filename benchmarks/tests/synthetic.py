# SPDX-License-Identifier: Apache-2.0
"""Result files as `swiftgs bench` would write them, of frames whose times a seeded generator makes."""
import json
import math
import random

STAGES = {"project": 0.14, "sort": 0.18, "raster": 0.16}  # milliseconds


def interval(frames):
    """The median of the frames, and the limits of its 95 % confidence interval from order statistics."""
    ordered, n = sorted(frames), len(frames)
    rank, chance = 0, 0.0
    while chance + math.comb(n, rank) / 2**n <= 0.025:
        chance += math.comb(n, rank) / 2**n
        rank += 1
    rank = max(rank - 1, 0)
    middle = (ordered[(n - 1) // 2] + ordered[n // 2]) / 2
    return {"median": middle, "low": ordered[rank], "high": ordered[n - 1 - rank],
            "p10": ordered[n // 10], "p90": ordered[n - 1 - n // 10]}


def times(rng, noise, frames, slower):
    """Durations of a row; `slower` holds factors of stages."""
    made = {stage: [] for stage in (*STAGES, "total", "wall")}
    for _ in range(frames):
        parts = {s: ms * slower.get(s, 1) * math.exp(rng.gauss(0, noise)) for s, ms in STAGES.items()}
        for stage, ms in parts.items():
            made[stage].append(ms)
        made["total"].append(sum(parts.values()))
        made["wall"].append(sum(parts.values()) + 0.007 * math.exp(rng.gauss(0, noise)))
    return {stage: interval(each) for stage, each in made.items()}


def row(ms, renderer="cuda/early/per-pixel/ellipse", **members):
    backend, sort, raster, bounds = renderer.split("/")
    return {"scene": "garden", "gaussians": 1512439, "enlarge": 1, "view": "0", "width": 1297, "height": 840,
            "scale": 1, "conventions": "gsplat", "threads": 16, "renderer": renderer, "backend": backend, "sort": sort,
            "raster": raster, "bounds": bounds, "frames": 15, "ms": ms, "psnr_db": 102.2, "ssim": 0.999999,
            "max_abs": 2.5e-3, "photo_psnr_db": None, "photo_ssim": None, "visible": 634397, "intersections": 1699159,
            "contributing_pairs": 49000000, "device_bytes": 2**29, "host_bytes": 2**20, **members}


def file_of(rows, **machine):
    return {"format": "swiftgs-bench", "version": 1,
            "machine": {"date": "2026-11-21", "cpu": "a processor", "cores": 16, "gpu": "a GPU", "commit": "0" * 40,
                        **machine},
            "command": "swiftgs bench", "scenes": [], "views": [], "rows": rows}


RENDERERS = [f"cuda/{sort}/{raster}/{bounds}" for sort in ("standard", "early", "adaptive")
             for raster in ("per-pixel", "axis-shared-float-split", "axis-shared-threshold-float-cholesky")
             for bounds in ("opacity-box", "ellipse")]


def run(seed, noise=0.01, views=8, frames=15, slower=None):
    """A file of RENDERERS on `views` views; `slower` maps a renderer to factors of its stages."""
    rng, slower = random.Random(seed), slower or {}
    return file_of([row(times(rng, noise, frames, slower.get(renderer, {})), renderer, view=str(view),
                         frames=frames)
                    for view in range(views) for renderer in RENDERERS])


def write(path, content):
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return str(path)
