# SPDX-License-Identifier: Apache-2.0
"""`swiftgs.rasterization` beside gsplat's own, in one run on one GPU: times, and decibels between both.

    python3 benchmarks/beside_gsplat.py builtin:200000 captures/fox --json results.json
    python3 benchmarks/beside_gsplat.py worlds --json worlds.json

It needs PyTorch with CUDA, the package swiftgs, and gsplat as `build_rivals.py` builds it or installed. Both take the
same tensors on the device, under `no_grad`, and take turns in a random order. A time is that of one call from an idle
device until it is idle again, the median of many. `swiftgs, scene kept` draws a scene that was set before into the same
memory. Pinholes are drawn in frames of 1, 4 and 16 views, gsplat's other camera models in frames of 4.

`worlds` is a batch of scenes: one call draws each for its own cameras. `worlds:64,20000,16,128`, what it is without
numbers, are 64 scenes of 20,000 Gaussians with 16 views each of 128x128 pixels.
"""
import argparse
import json
import os
import pathlib
import random
import statistics
import subprocess
import sys
import time

from build_rivals import PLACES, ROOT

sys.path[:0] = [*PLACES, str(ROOT / "tests/python")]

# (camera model, views of a frame)
FRAMES = (("pinhole", 1), ("pinhole", 4), ("pinhole", 16), ("ortho", 4), ("fisheye", 4))


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


class Worlds:
    """The built-in scene in other sizes, each with as many cameras around it. Colours have no harmonics: with them
    batches end the process in gsplat 1.6.0."""

    def __init__(self, name):
        numbers = name.partition(":")[2] or "64,20000,16,128"
        try:
            self.count, self.gaussians, self.views, self.side = found = [int(number) for number in numbers.split(",")]
            if min(found) < 1:
                raise ValueError
        except ValueError:
            raise SystemExit(f"'{name}': expected worlds, or worlds:WORLDS,GAUSSIANS,VIEWS,PIXELS, such as "
                             "worlds:64,20000,16,128") from None

    def arrays(self):
        """Arguments of `rasterization`, by name, in arrays of NumPy with the worlds' dimension first."""
        import numpy as np  # pylint: disable=import-outside-toplevel
        import swiftgs  # pylint: disable=import-outside-toplevel
        scene, sizes = swiftgs.Scene.builtin(self.gaussians), 1 + 0.01 * np.arange(self.count).reshape(-1, 1, 1)
        angles = 2 * np.pi * np.arange(self.views) / self.views
        cameras = [swiftgs.Camera.look_at((4.4 * np.sin(angle), -1.5, -4.4 * np.cos(angle)), (0, -0.5, 0),
                                          width=self.side, height=self.side, vertical_fov=0.8) for angle in angles]
        found = {"means": sizes * scene.means, "scales": sizes * scene.scales}
        same = {"quats": scene.rotations, "opacities": scene.opacities,
                "colors": 0.5 + 0.2820948 * scene.sh0, "viewmats": [camera.viewmat for camera in cameras],
                "Ks": [camera.K for camera in cameras]}
        found.update({name: np.stack(self.count * [array]) for name, array in same.items()})
        return {name: array.astype(np.float32) for name, array in found.items()} | {
            "width": self.side, "height": self.side}


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


def describe(command):
    """The members of a result file that say what was measured on."""
    import gsplat  # pylint: disable=import-outside-toplevel
    import torch  # pylint: disable=import-outside-toplevel
    found = json.loads(subprocess.run([ROOT / "benchmarks/describe_machine.sh", ROOT / "build/release", command],
                                      check=True, stdout=subprocess.PIPE, text=True).stdout)
    machine = {name: found.get(name) for name in ("date", "gpu", "driver", "cuda", "cpu", "cores", "system", "commit")}
    return {"version": 1, "machine": machine, "command": command, "torch": torch.__version__,
            "gsplat": gsplat.__version__}


def command_of(arguments):
    """As it is shown, without folders."""
    return " ".join(os.path.basename(word) for word in [sys.argv[0], *arguments])


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


def row(case, model, views, rounds):
    import gsplat  # pylint: disable=import-outside-toplevel
    import torch  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    from conftest import decibels  # pylint: disable=import-outside-toplevel
    cameras = [case.cameras[i % len(case.cameras)] for i in range(views)]
    arguments = through(case.tensors(cameras), model)
    calls = calls_of(arguments, arguments["viewmats"].cpu().numpy(), arguments["Ks"].cpu().numpy())
    if model == "pinhole":
        renderer, (width, height) = swiftgs.Renderer("cuda", scene=case.scene), case.size
        frame = swiftgs.Frame(torch.empty(views, height, width, 3, device="cuda"),
                              torch.empty(views, height, width, 1, device="cuda"))
        calls["swiftgs, scene kept"] = lambda: renderer.render(cameras, out=frame)
    pairs = zip(swiftgs.rasterization(**arguments)[0], gsplat.rasterization(**arguments)[0])
    return {"scene": case.name, "gaussians": len(case.scene), "camera_model": model, "views": views,
            "size": list(case.size), "ms": alone(calls, rounds),
            "between_db": [float(decibels(a.cpu(), b.cpu())) for a, b in pairs]}


def row_of_worlds(worlds, rounds):
    import gsplat  # pylint: disable=import-outside-toplevel
    import swiftgs  # pylint: disable=import-outside-toplevel
    from conftest import decibels  # pylint: disable=import-outside-toplevel
    arrays = worlds.arrays()
    arguments = on_device(arrays)
    ours, theirs = swiftgs.rasterization(**arguments)[0], gsplat.rasterization(**arguments, packed=False)[0]
    shape = (worlds.count, worlds.views, worlds.side, worlds.side, 3)
    if tuple(theirs.shape) != shape:
        raise SystemExit(f"gsplat {gsplat.__version__} drew {tuple(theirs.shape)}, expected {shape}: a batch of scenes")
    some = sorted({k * (worlds.count * worlds.views - 1) // 15 for k in range(16)})  # of other worlds, other views
    between = [float(decibels(ours[where].tolist(), theirs[where].tolist()))
               for where in (divmod(image, worlds.views) for image in some)]
    calls = calls_of(arguments, arrays["viewmats"], arrays["Ks"])
    del calls["gsplat"]  # slower, packed, than the other
    return {"worlds": worlds.count, "gaussians": worlds.gaussians, "views": worlds.views,
            "size": [worlds.side, worlds.side],
            "ms": alone(calls, rounds), "between_db": between}


def check_packages():
    """Ends with one line where something is missing."""
    try:
        import torch  # pylint: disable=import-outside-toplevel
        import swiftgs  # noqa: F401 pylint: disable=import-outside-toplevel,unused-import
        import gsplat  # noqa: F401 pylint: disable=import-outside-toplevel,unused-import
    except ImportError as error:
        raise SystemExit(f"beside_gsplat: {error}; expected PyTorch, swiftgs, and gsplat as build_rivals.py builds it "
                         "or installed") from None
    if not torch.cuda.is_available():
        raise SystemExit(f"beside_gsplat: PyTorch {torch.__version__} sees no GPU, expected one")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", help="builtin, builtin:N, folders of captures, or worlds")
    parser.add_argument("--scale", type=float, default=1, help="factor of the images' sides")
    parser.add_argument("--rounds", type=int, default=30)
    parser.add_argument("--json", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    check_packages()
    import torch  # pylint: disable=import-outside-toplevel
    random.seed(1)
    found = {"format": "swiftgs-beside-gsplat", **describe(command_of(sys.argv[1:])), "rows": []}

    def keep(section, measured):
        found.setdefault(section, []).append(measured)
        print(json.dumps(measured), flush=True)
        arguments.json.write_text(json.dumps(found, indent=1) + "\n")

    with torch.no_grad():
        for name in arguments.scenes:
            if name.partition(":")[0] == "worlds":
                keep("worlds", row_of_worlds(Worlds(name), arguments.rounds))
                continue
            case = Case(name, arguments.scale)
            for model, views in FRAMES:
                keep("rows", row(case, model, views, arguments.rounds))


if __name__ == "__main__":
    main()
