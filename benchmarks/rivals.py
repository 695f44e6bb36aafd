# SPDX-License-Identifier: Apache-2.0
"""Frames of this library beside those of gsplat, HiGS and Faster-GS, in one run on one GPU: time against error.

    python3 benchmarks/rivals.py frames captures/garden captures/fox builtin:4000000 --json rivals.json
    python3 benchmarks/rivals.py calls builtin:200000 captures/fox worlds --json beside-gsplat.json

It needs PyTorch with CUDA, the package swiftgs, and what `build_rivals.py` builds. All take the same tensors on the
device, under `no_grad`, and take turns in a random order; times are medians of many. `wall` is that of one call from an
idle device until it is idle again, Python included.

`frames` draws one view at a time of a scene that lies on the device as each renderer keeps it, and leaves the image
there; `total` is the time of a frame among ten in a row. gsplat's packed and unpacked arrays and both of HiGS's tiles
are timed. Faster-GS draws by its path for inference, without clamping colours. SwiftGS and gsplat also draw planes
beside colour: a call named `depth` draws alpha and expected depth, one named `id` the Gaussian of the largest weight,
for which gsplat walks its tile lists a second time. gsplat always draws alpha, so `SwiftGS` does too. The first views
are compared with `tests/python/float64.py` after all is timed, by the rules by which each renderer blends: a minute of a
core for each.

`calls` measures `rasterization` of SwiftGS and of gsplat, pinholes in frames of 1, 4 and 16 views and gsplat's other
camera models in frames of 4. `swiftgs, scene kept` draws a scene that was set before into the same memory. `worlds` are
64 scenes of 20,000 Gaussians, each drawn for 16 cameras of its own in 128x128 pixels, by one call.
"""
import argparse
import concurrent.futures
import importlib.util
import json
import multiprocessing
import os
import pathlib
import random
import statistics
import subprocess
import sys
import time

from build_rivals import PLACES, ROOT

sys.path[:0] = [*PLACES, str(ROOT / "tests/python")]

IN_A_ROW = 10
# (camera model, views of a frame)
FRAMES = (("pinhole", 1), ("pinhole", 4), ("pinhole", 16), ("ortho", 4), ("fisheye", 4))
WORLDS, GAUSSIANS, VIEWS, SIDE = 64, 20_000, 16, 128


class Case:
    """One scene, and every eighth of its views."""

    def __init__(self, name, scale):
        import swiftgs  # pylint: disable=import-outside-toplevel
        if name.startswith("builtin"):
            self.scene = swiftgs.Scene.builtin(int(name.partition(":")[2] or 200_000))
            first = swiftgs.Camera.builtin().scaled(scale)
            around = [(0.9 * x, -1.5, 0.9 * z) for x, z in ((-1, -4.4), (4, -2), (4, 2), (0, 4.4), (-4, 2), (-4, -2))]
            self.cameras = [first] + [swiftgs.Camera.look_at(eye, (0, -0.5, 0), width=first.width,
                                                             height=first.height, vertical_fov=0.8) for eye in around]
        else:
            self.scene = swiftgs.load(name)
            found = [camera.scaled(scale) for camera in swiftgs.load_cameras(name)[::8]]
            self.cameras = [each for each in found if (each.width, each.height) == (found[0].width, found[0].height)]
        self.name, self.size = pathlib.Path(name).name, (self.cameras[0].width, self.cameras[0].height)
        self.row = {"scene": self.name, "gaussians": len(self.scene), "width": self.size[0], "height": self.size[1]}

    def arrays(self, cameras):
        """Arguments of `rasterization`, by name, in arrays of NumPy."""
        import numpy as np  # pylint: disable=import-outside-toplevel
        scene = self.scene
        found = {"means": scene.means, "quats": scene.rotations, "scales": scene.scales, "opacities": scene.opacities,
                 "colors": scene.sh, "viewmats": [camera.viewmat for camera in cameras],
                 "Ks": [camera.K for camera in cameras]}
        return {name: np.asarray(array, np.float32) for name, array in found.items()} | {
            "width": self.size[0], "height": self.size[1], "sh_degree": scene.sh_degree}

    def tensors(self, cameras):
        """The same on the device."""
        return on_device(self.arrays(cameras))


def arrays_of_worlds():
    """Arguments of `rasterization` for the built-in scene in other sizes, the worlds' dimension first, each with as many
    cameras around it. Colours have no harmonics: with them batches end the process in gsplat 1.6.0."""
    import numpy as np  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    scene, sizes = swiftgs.Scene.builtin(GAUSSIANS), 1 + 0.01 * np.arange(WORLDS).reshape(-1, 1, 1)
    cameras = [swiftgs.Camera.look_at((4.4 * np.sin(angle), -1.5, -4.4 * np.cos(angle)), (0, -0.5, 0), width=SIDE,
                                      height=SIDE, vertical_fov=0.8) for angle in 2 * np.pi * np.arange(VIEWS) / VIEWS]
    found = {"means": sizes * scene.means, "scales": sizes * scene.scales}
    same = {"quats": scene.rotations, "opacities": scene.opacities, "colors": 0.5 + 0.2820948 * scene.sh0,
            "viewmats": [camera.viewmat for camera in cameras], "Ks": [camera.K for camera in cameras]}
    found.update({name: np.stack(WORLDS * [array]) for name, array in same.items()})
    return {name: array.astype(np.float32) for name, array in found.items()} | {"width": SIDE, "height": SIDE}


def on_device(arrays):
    """The same arguments in tensors."""
    import torch  # pylint: disable=import-outside-toplevel
    return {name: value if isinstance(value, int) else torch.tensor(value, device="cuda")
            for name, value in arrays.items()}


def alone(calls, rounds):
    """Milliseconds of each call from an idle device until it is idle again, the calls taking turns."""
    import torch  # pylint: disable=import-outside-toplevel
    found = {name: [] for name in calls}
    for turn in range(rounds + 5):
        for name in random.sample(list(calls), len(calls)):
            torch.cuda.synchronize()
            begun = time.perf_counter()
            calls[name]()
            torch.cuda.synchronize()
            if turn >= 5:
                found[name].append((time.perf_counter() - begun) * 1e3)
    return {name: statistics.median(times) for name, times in found.items()}


def through(arguments, model):
    """The arguments with a camera model of gsplat's; parallel rays have the scale of the scene's middle depth."""
    if model == "ortho":
        means, to_camera = arguments["means"], arguments["viewmats"]
        depths = means @ to_camera[:, 2, :3].T + to_camera[:, 2, 3]
        for focal, depth in zip(arguments["Ks"], depths.T):
            focal[:2, :2] /= depth[depth > 0].median()
    return dict(arguments, camera_model=model)


def calls_of(arguments, viewmats, matrices):
    """What is timed, by name, with the cameras' matrices on the host too."""
    import gsplat  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    on_host = dict(arguments, viewmats=viewmats, Ks=matrices)
    return {"swiftgs": lambda: swiftgs.rasterization(**arguments),
            "swiftgs, matrices on the host": lambda: swiftgs.rasterization(**on_host),
            "gsplat": lambda: gsplat.rasterization(**arguments),
            "gsplat, not packed": lambda: gsplat.rasterization(**arguments, packed=False)}


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


def errors(arguments, images):
    """{call: members of its row} of the images of one view, against the view in float64."""
    import float64  # pylint: disable=import-outside-toplevel
    from conftest import decibels  # pylint: disable=import-outside-toplevel
    wanted = dict(zip(float64.RULES, float64.render_first(arguments, rules=float64.RULES)))
    found = {}
    for name, image in images.items():
        rules = float64.UNCLAMPED if name.startswith(("HiGS", "Faster-GS")) else float64.GSPLAT
        found[name] = {"psnr_db": float(decibels(image, wanted[rules])),
                       "max_abs": float(abs(image - wanted[rules]).max())}
    return found


class Judge:
    """Compares images with the view in float64, several views at once, after all is timed: it fills the processor."""

    def __init__(self):
        self.views = []  # rows by call, arguments, images

    def add(self, case, index, calls, rows):
        images = {name: call().cpu().numpy() for name, call in calls.items()}
        self.views.append((rows, case.arrays([case.cameras[index]]), images))

    def run(self):
        os.environ["OPENBLAS_NUM_THREADS"] = "1"  # of each band of an image, which are threads themselves
        spawned = multiprocessing.get_context("spawn")  # a fork would share the GPU's state
        with concurrent.futures.ProcessPoolExecutor(mp_context=spawned) as pool:
            for (rows, *_), found in zip(self.views, pool.map(errors, *zip(*(view[1:] for view in self.views)))):
                for name, members in found.items():
                    rows[name].update(members)


def write_canvases(folder, case, calls):
    """Writes the image of each call, for the judge of the conformance set where the scene is a clause of it."""
    import numpy as np  # pylint: disable=import-outside-toplevel
    for name, call in calls.items():
        path = folder / name / f"{case.name}.npy"
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(path, call().cpu().numpy())


def rows_of_frames(name, arguments, judge):
    case = Case(name, arguments.scale)
    tensors = case.tensors(case.cameras)
    views = [{"viewmat": viewmat.contiguous(), "K": matrix.contiguous()}
             for viewmat, matrix in zip(tensors.pop("viewmats"), tensors.pop("Ks"))]
    renderers = [RENDERERS[name](case, tensors) for name in arguments.renderers or built()]
    for index, view in enumerate(views):
        calls = {name: call for frame_of in renderers for name, call in frame_of(view).items()}
        if arguments.canvases and index == 0:
            write_canvases(arguments.canvases, case, calls)
        total, wall = in_a_row(calls, arguments.rounds), alone(calls, arguments.rounds)
        rows = {call: {**case.row, "view": str(index), "renderer": call,
                       "ms": {"total": {"median": total[call]}, "wall": {"median": wall[call]}}} for call in calls}
        if index < arguments.judged:
            judge.add(case, index, calls, rows)
        yield from rows.values()


def rows_of_calls(name, arguments, _judge):
    if name == "worlds":
        yield from rows_of_worlds(arguments.rounds)
        return
    import gsplat  # pylint: disable=import-outside-toplevel
    import torch  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    case = Case(name, arguments.scale)
    for model, views in FRAMES:
        cameras = [case.cameras[i % len(case.cameras)] for i in range(views)]
        tensors = through(case.tensors(cameras), model)
        calls = calls_of(tensors, tensors["viewmats"].cpu().numpy(), tensors["Ks"].cpu().numpy())
        if model == "pinhole":
            renderer, (width, height) = swiftgs.Renderer("cuda", scene=case.scene), case.size
            frame = swiftgs.Frame(torch.empty(views, height, width, 3, device="cuda"),
                                  torch.empty(views, height, width, 1, device="cuda"))
            calls["swiftgs, scene kept"] = lambda: renderer.render(cameras, out=frame)
        between = least_decibels(swiftgs.rasterization(**tensors)[0], gsplat.rasterization(**tensors)[0])
        for call, ms in alone(calls, arguments.rounds).items():
            yield {**case.row, "camera_model": model, "batch": views, "renderer": call,
                   "ms": {"wall": {"median": ms}}, "between_db": between}


def rows_of_worlds(rounds):
    import gsplat  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    arrays = arrays_of_worlds()
    tensors = on_device(arrays)
    ours, theirs = swiftgs.rasterization(**tensors)[0], gsplat.rasterization(**tensors, packed=False)[0]
    if tuple(theirs.shape) != (WORLDS, VIEWS, SIDE, SIDE, 3):
        raise SystemExit(f"gsplat {gsplat.__version__} drew {tuple(theirs.shape)}, expected a batch of scenes")
    some = [divmod(k * (WORLDS * VIEWS - 1) // 15, VIEWS) for k in range(16)]  # of other worlds, other views
    between = least_decibels([ours[at] for at in some], [theirs[at] for at in some])
    calls = calls_of(tensors, arrays["viewmats"], arrays["Ks"])
    del calls["gsplat"]  # slower, packed, than the other
    for call, ms in alone(calls, rounds).items():
        yield {"scene": "worlds", "worlds": WORLDS, "gaussians": GAUSSIANS, "batch": VIEWS, "width": SIDE,
               "height": SIDE, "renderer": call, "ms": {"wall": {"median": ms}}, "between_db": between}


def least_decibels(ours, theirs):
    from conftest import decibels  # pylint: disable=import-outside-toplevel
    return min(float(decibels(a.cpu(), b.cpu())) for a, b in zip(ours, theirs))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("frames", "calls"))
    parser.add_argument("scenes", nargs="+", help="builtin, builtin:N, folders of captures; of calls also worlds")
    parser.add_argument("--renderers", nargs="+", choices=RENDERERS, help="of frames; else all that are built")
    parser.add_argument("--scale", type=float, default=1, help="factor of the images' sides")
    parser.add_argument("--rounds", type=int, default=30, help="times that a median is of")
    parser.add_argument("--judged", type=int, default=3, help="views of a scene that are drawn in float64 too")
    parser.add_argument("--canvases", type=pathlib.Path, help="folder for the first view of each scene, of frames")
    parser.add_argument("--json", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    import gsplat  # pylint: disable=import-outside-toplevel
    import torch  # pylint: disable=import-outside-toplevel
    random.seed(1)
    command = " ".join(os.path.basename(word) for word in sys.argv)  # without folders
    machine = subprocess.run([ROOT / "benchmarks/describe_machine.sh", ROOT / "build/release", command], check=True,
                             stdout=subprocess.PIPE, text=True).stdout
    found = {"format": "swiftgs-bench", "version": 1, "machine": json.loads(machine), "command": command,
             "notes": [f"PyTorch {torch.__version__}, gsplat {gsplat.__version__}"], "scenes": [], "views": [],
             "rows": []}
    rows_of, judge = {"frames": rows_of_frames, "calls": rows_of_calls}[arguments.what], Judge()
    with torch.no_grad():
        for name in arguments.scenes:
            for row in rows_of(name, arguments, judge):
                found["rows"].append(row)
                print(json.dumps(row), flush=True)
                arguments.json.write_text(json.dumps(found, indent=1) + "\n")
    if judge.views:
        judge.run()
        arguments.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
