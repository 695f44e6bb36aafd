# SPDX-License-Identifier: Apache-2.0
"""Frames a second from Python against C++, in one run on one machine.

    PYTHONPATH=backends/bindings/python SWIFTGS_LIBRARY=build/release/backends/bindings/c/libswiftgs_c.so \
        python3 benchmarks/python_overhead.py build/release/examples/swiftgs builtin:200000 --json FILE

C++ is `swiftgs bench` with the same renderer, scene, view and size. The languages take turns. Each time is given twice,
as the median and as what 10 % of a round's frames stay below (p10), which other programs disturb less; both are medians
over the rounds. Frames from Python come one after the other, each complete before the next:

  out       `render(camera, out=frame)`, the same memory again
  new       `render(camera)`, an array of NumPy for each frame
  arrays    `rasterization(...)`, which takes the Gaussians with each call

`outside_us` is what a frame takes outside of its stages: the wall clock's median, or p10, less that of the backend's
own clock (`times`). What Python adds to a frame is at most the difference of `outside_us` between the languages, which
also has what Python takes to read the clock. On a device `out` is a DeviceArray, each frame is waited for, `new` copies
to the host, and `arrays` are tensors of PyTorch.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import time

import numpy as np

import swiftgs


def both(samples):
    """The two numbers of a time."""
    return {"p10": float(np.percentile(samples, 10)), "median": float(np.median(samples))}


def milliseconds(work, least):
    """Of calls, over as many as fit into `least` seconds."""
    work(), work()
    found, until = [], time.perf_counter() + least
    while time.perf_counter() < until or len(found) < 10:
        begun = time.perf_counter()
        work()
        found.append((time.perf_counter() - begun) * 1e3)
    return found


class Cpp:
    """Frames in C++."""

    def __init__(self, tool):
        self.tool, self.machine = tool, None

    def bench(self, scene, renderer, scale):
        """Of one run: milliseconds of a frame by the wall clock, and microseconds outside of the stages."""
        command = [self.tool, "bench", scene, "--renderers", renderer, "--views", "0", "--scales", str(scale),
                   "--errors", "none", "--json", "-"]
        done = subprocess.run(command, check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            raise SystemExit(done.stderr)
        results = json.loads(done.stdout)
        self.machine = self.machine or results["machine"]
        ms = results["rows"][0]["ms"]
        return {of: (ms["wall"][of], (ms["wall"][of] - ms["total"][of]) * 1e3) for of in ("p10", "median")}


def tensors_of(arrays, on_device):
    """On a device as tensors of PyTorch, without it none."""
    if not on_device:
        return arrays
    try:
        import torch  # pylint: disable=import-outside-toplevel
    except ImportError:
        return None
    return [torch.tensor(array, device="cuda") for array in arrays]


class Case:
    """One scene on one backend."""

    def __init__(self, backend, name, scale):
        count = int(name.partition(":")[2] or 200_000) if name.startswith("builtin") else None
        scene = swiftgs.Scene.builtin(count) if count else swiftgs.load(name)
        camera = (swiftgs.Camera.builtin() if count else swiftgs.load_cameras(name)[0]).scaled(scale)
        renderer = swiftgs.Renderer(backend, scene=scene)
        self.scene, self.camera, self.renderer = scene, camera, renderer
        self.wait = renderer.wait if renderer.on_device else lambda: None
        self.out = swiftgs.Frame(swiftgs.DeviceArray((camera.height, camera.width, 3))) if renderer.on_device else \
            swiftgs.Frame.empty(camera.width, camera.height)
        self.calls = {"out": lambda: (renderer.render(camera, out=self.out), self.wait()),
                      "new": lambda: renderer.render(camera)}
        arrays = tensors_of([scene.means, scene.rotations, scene.scales, scene.opacities, scene.sh],
                            renderer.on_device)
        if arrays:
            view = (camera.viewmat[None], camera.K[None], camera.width, camera.height)
            self.calls["arrays"] = lambda: (swiftgs.rasterization(*arrays, *view, sh_degree=scene.sh_degree,
                                                                  renderer=renderer), self.wait())

    def outside(self, frames):
        """Microseconds of a frame outside of its stages, as `Cpp.bench` has them."""
        render, camera, out, clock = self.renderer.render, self.camera, self.out, time.perf_counter_ns
        wait, wall, stages = self.renderer.wait if self.renderer.on_device else None, [], []
        for _ in range(frames):
            begun = clock()
            render(camera, out=out, times=True)
            if wait:
                wait()
            wall.append((clock() - begun) / 1e3)
            stages.append(self.renderer.times.total * 1e3)
        of_wall, of_stages = both(wall), both(stages)
        return {of: of_wall[of] - of_stages[of] for of in of_wall}


def measure(backend, cpp, name, arguments):
    """A row of each way of calling."""
    case, least = Case(backend, name, arguments.scale), arguments.seconds / arguments.rounds
    found, in_cpp, outside = {call: [] for call in case.calls}, [], []
    for _ in range(arguments.rounds):
        in_cpp.append(cpp.bench(name, case.renderer.name, arguments.scale))
        for call, work in case.calls.items():
            found[call].append(both(milliseconds(work, least)))
        outside.append(case.outside(max(10, int(least / found["out"][-1]["median"] * 1e3))))

    def of_rounds(runs):
        return {of: float(np.median([run[of] for run in runs])) for of in runs[0]}

    def part(index):
        return of_rounds([{of: run[of][index] for of in run} for run in in_cpp])

    row = {"scene": name if name.startswith("builtin") else pathlib.Path(name).name, "gaussians": len(case.scene),
           "width": case.camera.width, "height": case.camera.height, "renderer": case.renderer.name}
    outsides = {"C++": part(1), "out": of_rounds(outside)}
    times = {"C++": part(0), **{call: of_rounds(runs) for call, runs in found.items()}}
    return [{**row, "call": call, "ms": {"wall": ms}} | ({"outside_us": outsides[call]} if call in outsides else {})
            for call, ms in times.items()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tool", help="swiftgs, of the same build as the library")
    parser.add_argument("scenes", nargs="+", help="builtin, builtin:N, or folders of captures")
    parser.add_argument("--scale", type=float, default=1)
    parser.add_argument("--seconds", type=float, default=2, help="for each way of calling")
    parser.add_argument("--rounds", type=int, default=5, help="how often the languages take turns")
    parser.add_argument("--json", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    usable = {entry.name.partition("/")[0] for entry in swiftgs.list_renderers() if entry.usable} - {"serial"}
    cpp = Cpp(arguments.tool)
    rows = [row for scene in arguments.scenes for backend in sorted(usable)
            for row in measure(backend, cpp, scene, arguments)]
    results = {"format": "swiftgs-bench", "version": 1, "machine": cpp.machine,
               "command": " ".join(os.path.basename(word) for word in sys.argv),
               "notes": [f"Python {sys.version.split()[0]}, NumPy {np.__version__}"], "scenes": [], "views": [],
               "rows": rows}
    arguments.json.write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
