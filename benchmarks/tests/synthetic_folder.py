# SPDX-License-Identifier: Apache-2.0
"""A folder of results as measure_matrix.sh leaves it, of invented numbers that are easy to check."""
import json

import synthetic

RASTERS = {"per-pixel": 2.0, "axis-shared-half-split": 1.6, "axis-shared-float-split": 1.2,
           "axis-shared-float-cholesky": 1.1, "axis-shared-threshold-half-split": 1.5,
           "axis-shared-threshold-float-split": 1.1, "axis-shared-threshold-float-cholesky": 1.0}
SORTS = {"standard": 1.0, "early": 0.8, "adaptive": 0.8}
BOUNDS = {"three-sigma-square": 6e6, "opacity-box": 3e6, "ellipse": 2e6}  # intersections
GAUSSIANS = {"garden": 1500000, "fox": 200000, "builtin": 200000}
FAMILIES = ("needles", "bare-needles", "ridges", "little-blur", "scales", "distant-means", "wide-angles",
            "distorted-lenses", "fisheyes", "orthographic", "panoramas", "deep-stacks", "mixtures")
BEST = ("early", "axis-shared-threshold-float-cholesky", "ellipse")
SCALING = (BEST, ("standard", *BEST[1:]), ("standard", "per-pixel", "three-sigma-square"))


def exact(milliseconds):
    return {"median": milliseconds, "low": milliseconds, "high": milliseconds}


def row(backend, words, scene="garden", grow=None, **members):
    """Stages take what RASTERS and SORTS say, and half a millisecond for projection; `grow` multiplies each. A counted
    frame is rasterized in twice the time, of which a fifth is balanced."""
    sort, raster, bounds = words
    parts = {"project": 0.5, "sort": SORTS[sort], "raster": RASTERS[raster]}
    parts = {stage: ms * (grow or {}).get(stage, 1) for stage, ms in parts.items()}
    total = sum(parts.values())
    half = "half" in raster
    return synthetic.row({**{s: exact(ms) for s, ms in parts.items()}, "total": exact(total), "wall": exact(total)},
                         "/".join((backend, *words)),
                         **{"scene": scene, "gaussians": GAUSSIANS.get(scene, 150000), "visible": 500000,
                            "intersections": BOUNDS[bounds], "psnr_db": 60.0 if half else 102.0,
                            "max_abs": 0.4 if half else 0.003,
                            "photo_psnr_db": 24.75 if half else 24.8,
                            "counted_ms": {"raster": 2 * parts["raster"], "balanced": 0.4 * parts["raster"]},
                            "segments": 1500, "longest_item": 2048,
                            "cut_psnr_db": 101.5 if bounds == "three-sigma-square" else None, **members})


def matrix(backend, scenes=("garden", "fox", "builtin"), suffix="", **members):
    return [row(backend, (sort, raster, bounds), scene + suffix, view=str(view), **members)
            for scene in scenes for view in range(2)
            for sort in SORTS for raster in RASTERS for bounds in BOUNDS]


def growing(backend, points, scenes=("garden",)):
    """Rows of SCALING at each of (members, growth of the stages)."""
    return [row(backend, words, scene, **members, grow=grow) for scene in scenes
            for members, grow in points for words in SCALING]


def stress(backend, sizes):
    """A file of `swiftgs stress`: ratios of 1 at severity 1 and of 2 at the other, which is infinite in scales; twice that with the threshold."""
    rows = []
    for width, height in sizes:
        for family in FAMILIES:
            for severity, ratio in ((1, 1.0), (None if family == "scales" else 1e4, 2.0)):
                for raster in RASTERS:
                    for name in {backend, "cuda" if backend == "cuda" else "serial"}:
                        scale = (2 if "threshold" in raster else 1) * (1 if name == backend else 3)
                        rows.append({"family": family, "severity": severity, "severity_label": "how hard",
                                     "width": width, "height": height, "renderer": f"{name}/early/{raster}/ellipse",
                                     "backend": name, "sort": "early", "raster": raster, "bounds": "ellipse",
                                     "seeds": 16, "failed": 0, "error": None, "strict_normalised_error": ratio * scale,
                                     "max_abs": 1e-6 * ratio * scale, "ambiguity": 0.5})
    machine = {"cpu": "a processor", "cores": 16, **({"gpu": "a GPU"} if backend == "cuda" else {})}
    return {"format": "swiftgs-stress", "version": 1, "machine": machine, "rows": rows}


def ceilings():
    """A file of `ceilings`: sorts of a fixed cost and one for each pair and bit."""
    pairs = (100000, 1000000, 10000000)
    return {"format": "swiftgs-ceilings", "version": 1, "machine": synthetic.file_of([])["machine"],
            "copy_bytes_per_s": 4e12, "fma_per_s": 30e12, "ex2_per_s": 5e12,
            "sorts": [{"key_bits": bits, "sorted_bits": by, "pairs": pairs, "us": [50 + by * n / 1e6 for n in pairs]}
                      for bits, by in ((32, 32), (16, 13), (64, 45))]}


def write(folder, backend):
    """All files of a machine. Projection grows as Gaussians, rasterization as pixels, sorting as intersections a tile."""
    folder.mkdir(parents=True, exist_ok=True)

    def bench(name, rows):
        found = synthetic.file_of(rows)
        found["scenes"] = [{"scene": scene, "gaussians": gaussians, "enlarge": 1, "sh_degree": 3} for scene, gaussians
                           in sorted({(r["scene"], r["gaussians"]) for r in rows})]
        if backend == "cpu":
            del found["machine"]["gpu"]
        synthetic.write(folder / name, found)

    bench("matrix.json", matrix(backend))
    bench("vanilla.json", matrix(backend, conventions="inria"))
    bench("pruned.json", matrix(backend, ("garden", "fox"), "-pruned", conventions="inria"))
    gaussians = [({"gaussians": n}, {"project": n / 1e6}) for n in (100000, 1000000, 10000000)]
    bench("scaling-gaussians.json", growing(backend, gaussians))
    bench("scaling-builtin.json", growing(backend, gaussians, ("builtin",)))
    bench("scaling-pixels.json", growing(backend, [({"scale": s, "width": 1000 * s, "height": 1000 * s},
                                                    {"raster": s * s}) for s in (1, 2, 4)]))
    bench("scaling-threads.json", growing("cpu", [({"threads": n}, {"raster": 1 / n}) for n in (1, 2, 4)]))
    bench("scaling-occupancy.json", growing(backend, [({"enlarge": e, "intersections": 1e6 * e}, {"sort": e})
                                                      for e in (0.5, 1, 2)]))
    bench("lenses.json", [row(backend, BEST, f"garden-{lens}{order}", gaussians=1500000, view=str(view),
                              grow={"project": n * (0.5 if order else 1)}, visible=n * 500000)
                          for order in ("", "-ordered") for view in range(4)
                          for n, lens in enumerate(("pinhole", "opencv", "fisheye", "panorama"), 1)])
    for kept, form, part in (("float", "floats", 1), ("smallest", "bytes", 0.5), ("half", "halves", 0.75)):
        bench(f"harmonics-{kept}.json", [row(backend, BEST, "fox", grow={"sort": part}, harmonics=form)])
    if backend == "cuda":
        synthetic.write(folder / "ceilings.json", ceilings())
    synthetic.write(folder / "stress.json", stress(backend, ((64, 48),)))
    synthetic.write(folder / "stress-large.json", stress(backend, ((960, 540), (1920, 1080))))
    for scene in ("fox", "garden"):
        for score in ("contribution", "opacity-volume"):
            side = {"gaussians": GAUSSIANS[scene], "photo_psnr_db": 24.8, "unpruned_psnr_db": None}
            (folder / f"prune-{scene}-{score}.json").write_text(json.dumps(
                {"format": "swiftgs-prune", "version": 1, "scene": scene, "score": score, "kept_weight": 0.9,
                 "before": side, "after": {"gaussians": 20000, "photo_psnr_db": 23.5, "unpruned_psnr_db": 28.25}}),
                encoding="utf-8")
