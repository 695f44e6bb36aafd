# SPDX-License-Identifier: Apache-2.0
"""Frames a second from Python against C++, in one run on one machine.

    PYTHONPATH=backends/python SWIFTGS_LIBRARY=build/release/backends/c/libswiftgs_c.so \
        python3 benchmarks/python_overhead.py build/release/examples/swiftgs builtin:200000 [--json FILE]

C++ is `swiftgs bench` with the same renderer, scene, view and size. The languages take turns. Each time is given twice,
as the median and as what 10 % of a round's frames stay below (p10), which other programs disturb less; both are medians
over the rounds. Frames from Python come one after the other, each complete before the next:

  out       `render(camera, out=frame)`, the same memory again
  new       `render(camera)`, an array of NumPy for each frame
  arrays    `rasterization(...)`, which takes the Gaussians with each call
  nothing   as `out`, ten Gaussians in 16 x 9 pixels, where the call is nearly all there is

`outside` are microseconds of a frame outside of its stages: the wall clock's median, or p10, less that of the backend's
own clock (`times`).
What Python adds to a frame is at most the difference of `outside` between the languages, which also has what Python
takes to read the clock. A frame of the CPU leaves cold caches, so this is more than the same difference of `nothing`,
whose caches are warm. On a device `out` is a DeviceArray, each frame is waited for, `new` copies to the host, and
`arrays` are tensors of PyTorch.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import time

import numpy as np

import swiftgs

NOTHING = ("builtin:10", 0.0125)


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


def measure(backend, cpp, name, scale, rounds, least):
    case, small = Case(backend, name, scale), Case(backend, *NOTHING)
    found = {call: [] for call in (*case.calls, "nothing")}
    in_cpp, nothing_in_cpp, outside = [], [], []
    for _ in range(rounds):
        in_cpp.append(cpp.bench(name, case.renderer.name, scale))
        nothing_in_cpp.append(cpp.bench(NOTHING[0], case.renderer.name, NOTHING[1]))
        for call, work in (*case.calls.items(), ("nothing", small.calls["out"])):
            found[call].append(both(milliseconds(work, least / rounds)))
        outside.append(case.outside(max(10, int(least / rounds / found["out"][-1]["median"] * 1e3))))

    def of_rounds(runs):
        return {of: float(np.median([run[of] for run in runs])) for of in runs[0]}

    def part(runs, index):
        return [{of: run[of][index] for of in run} for run in runs]

    return {"renderer": case.renderer.name, "device": case.renderer.device_name, "scene": name,
            "gaussians": len(case.scene), "size": [case.camera.width, case.camera.height],
            "cpp_ms": of_rounds(part(in_cpp, 0)),
            "python_ms": {call: of_rounds(runs) for call, runs in found.items()},
            "cpp_nothing_ms": of_rounds(part(nothing_in_cpp, 0)),
            "cpp_outside_us": of_rounds(part(in_cpp, 1)), "python_outside_us": of_rounds(outside)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tool", help="swiftgs, of the same build as the library")
    parser.add_argument("scenes", nargs="+", help="builtin, builtin:N, or folders of captures")
    parser.add_argument("--scale", type=float, default=1)
    parser.add_argument("--seconds", type=float, default=2, help="for each way of calling")
    parser.add_argument("--rounds", type=int, default=5, help="how often the languages take turns")
    parser.add_argument("--json", help="a file for the results; - for standard output")
    arguments = parser.parse_args()
    usable = {entry.name.partition("/")[0] for entry in swiftgs.list_renderers() if entry.usable} - {"serial"}
    cpp = Cpp(arguments.tool)
    rows = [measure(backend, cpp, scene, arguments.scale, arguments.rounds, arguments.seconds)
            for scene in arguments.scenes for backend in sorted(usable)]
    if arguments.json:
        scenes = [scene if scene.startswith("builtin") else pathlib.Path(scene).name for scene in arguments.scenes]
        command = f"benchmarks/python_overhead.py swiftgs {' '.join(scenes)} --scale {arguments.scale:g} " \
                  f"--seconds {arguments.seconds:g} --rounds {arguments.rounds} --json FILE"
        results = {"format": "swiftgs-python", "version": 1, "machine": cpp.machine, "command": command,
                   "python": sys.version.split()[0], "numpy": np.__version__,
                   "rows": [dict(row, scene=name) for row, name in
                            zip(rows, (scene for scene in scenes for _ in usable))]}
        text = json.dumps(results, indent=1)
        pathlib.Path(arguments.json).write_text(text + "\n") if arguments.json != "-" else print(text)
    if arguments.json != "-":
        print("| backend | scene | | C++, ms | out, ms | new, ms | arrays, ms | outside in C++, us | in Python, us | "
              "nothing in C++, us | in Python, us |\n| --- | --- | --- |" + 8 * " ---: |")
        for row in rows:
            ms = row["python_ms"]
            for of in ("median", "p10"):
                print(f"| {row['renderer'].partition('/')[0]} | {row['scene']} | {of} | {row['cpp_ms'][of]:.3f} | "
                      f"{ms['out'][of]:.3f} | {ms['new'][of]:.3f} | "
                      f"{format(ms['arrays'][of], '.3f') if 'arrays' in ms else ''} | "
                      f"{row['cpp_outside_us'][of]:.1f} | {row['python_outside_us'][of]:.1f} | "
                      f"{row['cpp_nothing_ms'][of] * 1e3:.1f} | {ms['nothing'][of] * 1e3:.1f} |")


if __name__ == "__main__":
    main()
