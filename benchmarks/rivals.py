# SPDX-License-Identifier: Apache-2.0
"""Frames of this library beside those of gsplat, HiGS and Faster-GS, in one run on one GPU: time against error.

    python3 benchmarks/rivals.py captures/garden captures/fox builtin:4000000 --json rivals.json

It needs PyTorch with CUDA, the package swiftgs, and what `build_rivals.py` builds. Each renderer draws one view at a
time of a scene that lies on the device as that renderer keeps it, and leaves the image there. `ms` is that of a frame
among ten in a row, `ms_alone` that of one from an idle device until it is idle again, Python included, each the median
of many; renderers take turns in a random order. gsplat's packed and unpacked arrays and both of HiGS's tiles are timed.
Faster-GS draws by its path for inference, without clamping colours.

SwiftGS and gsplat also draw planes beside colour. A call named `depth` draws alpha and expected depth, one named `id`
the Gaussian of the largest weight, for which gsplat walks its tile lists a second time; its 3DGS has no median depth.
gsplat always draws alpha, so `SwiftGS` does too.

`errors` are those of the first views, of the same frames at full size against `tests/python/float64.py`, with the rules
by which each renderer blends. A frame in float64 takes a minute of a core. `--references FOLDER` keeps them there;
`--only-references` draws these alone, and needs no device.
"""
import argparse
import importlib.util
import json
import pathlib
import random
import statistics
import sys

from beside_gsplat import Case, alone, command_of, describe

IN_A_ROW = 10


def kept_by_swiftgs(case, _tensors):
    import swiftgs  # pylint: disable=import-outside-toplevel
    import torch  # pylint: disable=import-outside-toplevel
    renderer, (width, height) = swiftgs.Renderer("cuda", scene=case.scene), case.size

    def frame_of(view):
        camera = swiftgs.Camera.from_matrices(view["viewmat"].cpu().numpy(), view["K"].cpu().numpy(), width, height)

        def plane(channels=1, kind=torch.float32):
            return torch.empty(height, width, channels, dtype=kind, device="cuda")
        frames = {"SwiftGS": swiftgs.Frame(plane(3), plane()),
                  "SwiftGS, colour alone": swiftgs.Frame(plane(3)),
                  "SwiftGS, depth": swiftgs.Frame(plane(3), plane(), plane()),
                  "SwiftGS, id": swiftgs.Frame(plane(3), id=plane(kind=torch.uint32))}
        return {name: lambda frame=frame: renderer.render(camera, out=frame).colour for name, frame in frames.items()}
    return frame_of


def kept_by_gsplat(case, tensors):
    import gsplat  # pylint: disable=import-outside-toplevel

    def frame_of(view):
        arguments = dict(tensors, viewmats=view["viewmat"][None], Ks=view["K"][None])

        def drawn(packed, mode="RGB"):
            return gsplat.rasterization(**arguments, packed=packed, render_mode=mode)[0][0, ..., :3]

        def drawn_with_ids():
            images, _, meta = gsplat.rasterization(**arguments, packed=False)
            splats = [meta[name] for name in ("means2d", "conics", "opacities", "isect_offsets", "flatten_ids")]
            gsplat.rasterize_top_contributing_gaussian_ids(*splats, *case.size, meta["tile_size"], 1)
            return images[0]
        return {"gsplat": lambda: drawn(True), "gsplat, not packed": lambda: drawn(False),
                "gsplat, depth": lambda: drawn(True, "RGB+ED"),
                "gsplat, not packed, depth": lambda: drawn(False, "RGB+ED"),
                "gsplat, not packed, id": drawn_with_ids}
    return frame_of


def kept_by_higs(case, tensors):
    from gsplat.experimental import (  # pylint: disable=import-outside-toplevel
        GaussianInferenceRenderer, GaussianInferenceScene)
    import torch  # pylint: disable=import-outside-toplevel
    scene = GaussianInferenceScene.from_gaussian_tensors(
        tensors["means"], torch.nn.functional.normalize(tensors["quats"], dim=-1), tensors["scales"],
        tensors["opacities"], tensors["colors"], tensors["sh_degree"], "none", id="scene")
    renderers = {tile: GaussianInferenceRenderer(scene, tile_size=tile) for tile in (8, 16)}
    width, height = case.size

    def frame_of(view):
        return {f"HiGS, tiles of {tile}": lambda renderer=renderer: renderer.render(
            viewmat=view["viewmat"], K=view["K"], width=width, height=height).frame[0, ..., :3]
                for tile, renderer in renderers.items()}
    return frame_of


def kept_by_faster_gs(case, tensors):
    from FasterGSCudaBackend.torch_bindings.rasterization import (  # pylint: disable=import-outside-toplevel
        RasterizerSettings, rasterize)
    import torch  # pylint: disable=import-outside-toplevel
    sh, (width, height), black = tensors["colors"], case.size, torch.zeros(3, device="cuda")
    kept = [each.float().contiguous() for each in (
        tensors["means"], tensors["scales"].double().log(), tensors["quats"], tensors["opacities"].double().logit(),
        sh[:, :1], sh[:, 1:])]

    def frame_of(view):
        eye = view["viewmat"].double().inverse()[:3, 3].float().contiguous()
        (fx, _, cx), (_, fy, cy), _ = view["K"].tolist()
        settings = RasterizerSettings(view["viewmat"], eye, black, (tensors["sh_degree"] + 1) ** 2, width, height,
                                      fx, fy, cx, cy, near_plane=0.01, far_plane=1e10, proper_antialiasing=False)
        return {"Faster-GS": lambda: rasterize(*kept, settings, to_chw=False, clamp_output=False)}
    return frame_of


RENDERERS = {"SwiftGS": kept_by_swiftgs, "gsplat": kept_by_gsplat, "HiGS": kept_by_higs, "Faster-GS": kept_by_faster_gs}


def built():
    """All renderers, without Faster-GS where `build_rivals.py` left it out."""
    if importlib.util.find_spec("FasterGSCudaBackend"):
        return list(RENDERERS)
    print("Faster-GS is left out: build_rivals.py has not built it", file=sys.stderr)
    return [name for name in RENDERERS if name != "Faster-GS"]


def in_a_row(calls, rounds):
    """Milliseconds of each call among several in a row, the calls taking turns."""
    import torch  # pylint: disable=import-outside-toplevel
    found = {name: [] for name in calls}
    begun, ended = torch.cuda.Event(enable_timing=True), torch.cuda.Event(enable_timing=True)
    for turn in range(rounds + 1):
        for name in random.sample(list(calls), len(calls)):
            torch.cuda.synchronize()
            begun.record()
            for _ in range(IN_A_ROW):
                calls[name]()
            ended.record()
            ended.synchronize()
            if turn:
                found[name].append(begun.elapsed_time(ended) / IN_A_ROW)
    return {name: statistics.median(times) for name, times in found.items()}


def references(case, index, folder):
    """{rules: frame of that view in float64}"""
    import float64  # pylint: disable=import-outside-toplevel
    import numpy as np  # pylint: disable=import-outside-toplevel
    path = folder and folder / f"{case.name.replace(':', '-')}-{index}.npy"
    if path and path.exists():
        return dict(zip(float64.RULES, np.load(path)))
    found = float64.render_first(case.arrays([case.cameras[index]]), rules=float64.RULES)
    if path:
        folder.mkdir(parents=True, exist_ok=True)
        np.save(path, found)
    return dict(zip(float64.RULES, found))


def errors(calls, wanted):
    import float64  # pylint: disable=import-outside-toplevel
    from conftest import decibels  # pylint: disable=import-outside-toplevel
    found = {}
    for name, call in calls.items():
        rules = float64.UNCLAMPED if name.startswith(("HiGS", "Faster-GS")) else float64.GSPLAT
        image = call().double().cpu().numpy()
        found[name] = {"psnr_db": float(decibels(image, wanted[rules])),
                       "max_abs": float(abs(image - wanted[rules]).max())}
    return found


def rows_of(case, arguments):
    tensors = case.tensors(case.cameras)
    views = [{"viewmat": viewmat.contiguous(), "K": matrix.contiguous()}
             for viewmat, matrix in zip(tensors.pop("viewmats"), tensors.pop("Ks"))]
    renderers = [RENDERERS[name](case, tensors) for name in arguments.renderers or built()]
    for index, view in enumerate(views):
        calls = {name: call for frame_of in renderers for name, call in frame_of(view).items()}
        found = {"scene": case.name, "gaussians": len(case.scene), "view": index, "size": list(case.size),
                 "ms": in_a_row(calls, arguments.rounds), "ms_alone": alone(calls, arguments.rounds)}
        if index < arguments.judged:
            found["errors"] = errors(calls, references(case, index, arguments.references))
        yield found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", help="builtin, builtin:N, or folders of captures")
    parser.add_argument("--renderers", nargs="+", choices=RENDERERS, help="else all that are built")
    parser.add_argument("--scale", type=float, default=1, help="factor of the images' sides")
    parser.add_argument("--rounds", type=int, default=20, help="times that a median is of")
    parser.add_argument("--judged", type=int, default=3, help="views of a scene that are drawn in float64 too")
    parser.add_argument("--references", type=pathlib.Path, help="folder of frames in float64")
    parser.add_argument("--only-references", action="store_true")
    parser.add_argument("--json", type=pathlib.Path)
    arguments = parser.parse_args()
    if arguments.only_references:
        for name in arguments.scenes:
            case = Case(name, arguments.scale)
            for index in range(min(arguments.judged, len(case.cameras))):
                references(case, index, arguments.references)
                print(f"{case.name}, view {index}: drawn in float64", flush=True)
        return
    import torch  # pylint: disable=import-outside-toplevel
    random.seed(1)
    found = {"format": "swiftgs-rivals", **describe(command_of(sys.argv[1:])), "rows": []}
    with torch.no_grad():
        for name in arguments.scenes:
            for row in rows_of(Case(name, arguments.scale), arguments):
                found["rows"].append(row)
                print(json.dumps(row), flush=True)
                if arguments.json:
                    arguments.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
