# SPDX-License-Identifier: Apache-2.0
"""`swiftgs.rasterization` beside gsplat's own, in one run on one GPU: times, and how far each is from float64.

    python3 benchmarks/beside_gsplat.py build    builds gsplat from the folder SWIFTGS_GSPLAT into build/gsplat, once
    python3 benchmarks/beside_gsplat.py run builtin:200000 captures/fox --json results.json
    python3 benchmarks/beside_gsplat.py lenses builtin:200000 captures/fox    compares gsplat's other camera models

Both need PyTorch with CUDA; `run` needs the package swiftgs, and gsplat of `build` or another that is installed. gsplat
is built in a copy of its sources, for 3DGS in 1 to 4 channels and HiGS, its path for inference, alone. GLM, which it
brings as a submodule, is that of SWIFTGS_PREFIX or of the system where the submodule is empty.

All take the same tensors on the device, under `no_grad`, and take turns in a random order. A time is that of one call
from an idle device until it is idle again, the median of many. `swiftgs, scene kept` draws a scene that was set before
into the same memory, and so does HiGS, one view at a time.
"""
import argparse
import importlib.util
import json
import os
import pathlib
import random
import shutil
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILT = pathlib.Path(os.environ.get("SWIFTGS_GSPLAT_BUILD", ROOT / "build/gsplat"))
sys.path[:0] = [str(BUILT), str(ROOT / "tests/python")]

# Views that are drawn in float64 too, of each scene.
SEEN_IN_FLOAT64 = 4

# What a comparison does not need is left out, since it takes most of the time of a build.
LEAN = {"BUILD_2DGS": "0", "BUILD_3DGUT": "0", "BUILD_ADAM": "0", "BUILD_RELOC": "0",
        "BUILD_LOSSES": "0", "NUM_CHANNELS": "1,2,3,4"}

STUB_OF_RICH = '''class Console:
    """What gsplat prints its notes by, where rich is not installed."""

    print = staticmethod(print)

    def status(self, *_, **__):
        import contextlib
        return contextlib.nullcontext()
'''


def find_glm():
    places = [os.environ.get("SWIFTGS_PREFIX", "/nowhere") + "/usr/include", "/usr/include", "/usr/local/include"]
    for place in map(pathlib.Path, places):
        if (place / "glm/glm.hpp").exists():
            return place / "glm"
    raise SystemExit(f"GLM: expected glm/glm.hpp in one of {', '.join(places)}")


def build(lean):
    source = os.environ.get("SWIFTGS_GSPLAT")
    if not source or not (pathlib.Path(source) / "gsplat").is_dir():
        raise SystemExit(f"SWIFTGS_GSPLAT is '{source}', expected a folder with the sources of gsplat")
    if list(BUILT.glob("gsplat/csrc*.so")):
        return print(f"gsplat is built in {BUILT}")
    shutil.copytree(source, BUILT, dirs_exist_ok=True,
                    ignore=shutil.ignore_patterns(".git", "build", "examples", "docs", "assets"))
    glm = BUILT / "gsplat/cuda/csrc/third_party/glm"
    if not (glm / "glm/glm.hpp").exists():
        glm.mkdir(parents=True, exist_ok=True)
        shutil.copytree(find_glm(), glm / "glm", dirs_exist_ok=True)
    if importlib.util.find_spec("rich") is None:
        (BUILT / "rich").mkdir(exist_ok=True)
        (BUILT / "rich/__init__.py").write_text("")
        (BUILT / "rich/console.py").write_text(STUB_OF_RICH)
    begun = time.monotonic()
    import torch  # pylint: disable=import-outside-toplevel
    kind = ".".join(map(str, torch.cuda.get_device_capability())) if torch.cuda.is_available() else "9.0"
    environment = {"TORCH_CUDA_ARCH_LIST": kind, "MAX_JOBS": str(os.cpu_count()), **(LEAN if lean else {}),
                   **os.environ}
    subprocess.run([sys.executable, "setup.py", "build_ext", "--inplace"], cwd=BUILT, check=True, env=environment)
    return print(f"gsplat was built in {BUILT} within {time.monotonic() - begun:.0f} s")


class Case:
    """One scene and a batch of its views, as arguments of both functions."""

    def __init__(self, name, batch, scale):
        import swiftgs  # pylint: disable=import-outside-toplevel
        if name.startswith("builtin"):
            self.scene = swiftgs.Scene.builtin(int(name.partition(":")[2] or 200_000))
            first = swiftgs.Camera.builtin().scaled(scale)
            around = [(0.9 * x, -1.5, 0.9 * z) for x, z in ((-1, -4.4), (4, -2), (4, 2), (0, 4.4), (-4, 2), (-4, -2))]
            cameras = [first] + [swiftgs.Camera.look_at(eye, (0, -0.5, 0), width=first.width, height=first.height,
                                                        vertical_fov=0.8) for eye in around]
        else:
            self.scene = swiftgs.load(name)
            found = [camera.scaled(scale) for camera in swiftgs.load_cameras(name)[::8]]
            cameras = [camera for camera in found if (camera.width, camera.height) == (found[0].width, found[0].height)]
        self.name, self.cameras = pathlib.Path(name).name, [cameras[i % len(cameras)] for i in range(batch)]

    def arguments(self, cameras=None):
        import numpy as np  # pylint: disable=import-outside-toplevel
        import torch  # pylint: disable=import-outside-toplevel
        cameras = cameras or self.cameras
        scene = self.scene

        def tensor(array):
            return torch.tensor(np.asarray(array, np.float32), device="cuda")

        return {"means": tensor(scene.means), "quats": tensor(scene.rotations), "scales": tensor(scene.scales),
                "opacities": tensor(scene.opacities), "colors": tensor(scene.sh),
                "viewmats": tensor([camera.viewmat for camera in cameras]),
                "Ks": tensor([camera.K for camera in cameras]), "width": cameras[0].width,
                "height": cameras[0].height, "sh_degree": scene.sh_degree}


def measure(calls, rounds):
    """Milliseconds of each call, the calls taking turns."""
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


def between(arguments):
    """dB between both, of each view."""
    import gsplat  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    from conftest import decibels  # pylint: disable=import-outside-toplevel
    ours, theirs = swiftgs.rasterization(**arguments)[0], gsplat.rasterization(**arguments)[0]
    return [float(decibels(a.cpu(), b.cpu())) for a, b in zip(ours, theirs)]


def higs(arguments, tile):
    """Draws the first view of the arguments by gsplat's path for inference, with tiles of that side."""
    from gsplat.experimental import (  # pylint: disable=import-outside-toplevel
        GaussianInferenceRenderer, GaussianInferenceScene)
    scene = GaussianInferenceScene.from_gaussian_tensors(
        *(arguments[name] for name in ("means", "quats", "scales", "opacities", "colors")),
        sh_degree=arguments["sh_degree"], id="scene")
    renderer = GaussianInferenceRenderer(scene, tile_size=tile)
    view = {"viewmat": arguments["viewmats"][0].contiguous(), "K": arguments["Ks"][0].contiguous(),
            "width": arguments["width"], "height": arguments["height"]}
    return lambda: renderer.render(**view).frame[..., :3]


def from_float64(case, small):
    """How far each is from float64 in views of a smaller size."""
    import float64  # pylint: disable=import-outside-toplevel
    import gsplat  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    found = []
    for camera in case.cameras:
        arguments = case.arguments([camera.scaled(small)])
        wanted = float64.render_first(arguments)
        images = {name: each.rasterization(**arguments)[0] for name, each in (("swiftgs", swiftgs), ("gsplat", gsplat))}
        images["HiGS"] = higs(arguments, 8)().float()
        distances = {name: float64.distance(image[0].cpu(), wanted) for name, image in images.items()}
        found.append({"size": [arguments["width"], arguments["height"]], **distances})
    return found


def row(case, rounds):
    import gsplat  # pylint: disable=import-outside-toplevel
    import torch  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    arguments = case.arguments()
    on_host = dict(arguments, viewmats=arguments["viewmats"].cpu().numpy(), Ks=arguments["Ks"].cpu().numpy())
    renderer, count = swiftgs.Renderer("cuda", scene=case.scene), len(case.cameras)
    size = case.cameras[0].width, case.cameras[0].height
    frame = swiftgs.Frame(torch.empty(count, size[1], size[0], 3, device="cuda"),
                          torch.empty(count, size[1], size[0], 1, device="cuda"))
    inference = {f"HiGS, tiles of {tile}": higs(arguments, tile) for tile in (8, 16)} if count == 1 else {}
    times = measure(inference | {
        "swiftgs": lambda: swiftgs.rasterization(**arguments),
        "swiftgs, matrices on the host": lambda: swiftgs.rasterization(**on_host),
        "swiftgs, scene kept": lambda: renderer.render(case.cameras, out=frame),
        "gsplat": lambda: gsplat.rasterization(**arguments),
        "gsplat, not packed": lambda: gsplat.rasterization(**arguments, packed=False)}, rounds)
    return {"scene": case.name, "gaussians": len(case.scene), "views": count, "size": list(size), "ms": times,
            "between_db": between(arguments)}


def run(arguments):
    import gsplat  # pylint: disable=import-outside-toplevel
    import torch  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    random.seed(1)
    with torch.no_grad():
        rows = [row(Case(scene, batch, arguments.scale), arguments.rounds)
                for scene in arguments.scenes for batch in arguments.views]
        exactness = {each: from_float64(Case(each, SEEN_IN_FLOAT64, arguments.scale), arguments.small)
                     for each in arguments.scenes}
    results = {"format": "swiftgs-beside-gsplat", "version": 1, "gpu": torch.cuda.get_device_name(),
               "torch": torch.__version__, "gsplat": gsplat.__version__, "swiftgs": swiftgs.__version__, "rows": rows,
               "from_float64": exactness}
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=1) + "\n")
    names = list(dict.fromkeys(name for each in rows for name in each["ms"]))
    print("| scene | views | size | " + " | ".join(f"{name}, ms" for name in names) + " | dB between, least |")
    print("| --- | ---: | --- | " + " | ".join("---:" for _ in range(len(names) + 1)) + " |")
    for each in rows:
        print(f"| {each['scene']} | {each['views']} | {'x'.join(map(str, each['size']))} | " +
              " | ".join(f"{each['ms'][name]:.3f}" if name in each["ms"] else "-" for name in names) + f" | {min(each['between_db']):.1f} |")
    print("\n| scene | renderer | dB from float64, by view | pixels that decide otherwise | dB of the others |")
    print("| --- | --- | --- | --- | --- |")
    for scene, views in exactness.items():
        for name in ("swiftgs", "gsplat", "HiGS"):
            cells = (", ".join(format(view[name][key], form) for view in views)
                     for key, form in (("db", ".1f"), ("otherwise", ""), ("db_of_others", ".1f")))
            print(f"| {scene} | {name} | {' | '.join(cells)} |")


def seen_through(case, model):
    """Arguments of the case's views through a camera model of gsplat's; in parallel rays its scale is that of the
    scene's middle depth."""
    arguments = dict(case.arguments(), camera_model=model)
    if model == "ortho":
        means, to_camera = arguments["means"], arguments["viewmats"]
        depths = means @ to_camera[:, 2, :3].T + to_camera[:, 2, 3]
        for focal, depth in zip(arguments["Ks"], depths.T):
            focal[:2, :2] /= depth[depth > 0].median()
    return arguments


def lenses(arguments):
    import gsplat  # pylint: disable=import-outside-toplevel
    import torch  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    random.seed(1)
    print("| scene | camera model | swiftgs, ms | gsplat, ms | dB between, by view |")
    print("| --- | --- | ---: | ---: | --- |")
    with torch.no_grad():
        for scene in arguments.scenes:
            case = Case(scene, SEEN_IN_FLOAT64, arguments.scale)
            for model in ("pinhole", "ortho", "fisheye"):
                given = seen_through(case, model)
                times = measure({each.__name__: lambda each=each: each.rasterization(**given)
                                 for each in (swiftgs, gsplat)}, arguments.rounds)
                print(f"| {scene} | {model} | {times['swiftgs']:.3f} | {times['gsplat']:.3f} | " +
                      ", ".join(f"{db:.1f}" for db in between(given)) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    building = commands.add_parser("build", help="builds gsplat once")
    building.add_argument("--all", action="store_true", help="all of gsplat, and not what is compared alone")
    running = commands.add_parser("run", help="compares pinholes")
    running.add_argument("--views", type=int, nargs="+", default=[1, 4, 16], help="views of a frame")
    running.add_argument("--small", type=float, default=0.2, help="that of the image in float64, on top")
    seeing = commands.add_parser("lenses", help="compares camera models")
    for one in (running, seeing):
        one.add_argument("scenes", nargs="+", help="builtin, builtin:N, or folders of captures")
        one.add_argument("--scale", type=float, default=1, help="factor of the images' sides")
        one.add_argument("--rounds", type=int, default=50)
    running.add_argument("--json", type=pathlib.Path)
    arguments = parser.parse_args()
    if arguments.command == "build":
        build(not arguments.all)
    else:
        {"run": run, "lenses": lenses}[arguments.command](arguments)


if __name__ == "__main__":
    main()
