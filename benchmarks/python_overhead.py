# SPDX-License-Identifier: Apache-2.0
"""Frames a second from Python against C++, in one run on one machine.

    PYTHONPATH=backends/python SWIFTGS_LIBRARY=build/release/backends/c/libswiftgs_c.so \
        python3 benchmarks/python_overhead.py build/release/examples/swiftgs builtin:200000 [--json FILE]

C++ is `swiftgs bench` with the same renderer, scene, view and size: the median of a frame by the wall clock. From
Python it is the wall clock over frames one behind the other, each complete before the next, in four ways of calling:

  nothing   a frame of ten Gaussians and 16 x 16 pixels, where the call is nearly all there is
  out       `render(camera, out=frame)`, the same memory again
  new       `render(camera)`, an array of NumPy for each frame
  arrays    `rasterization(...)`, which takes the Gaussians with each call

`overhead_us` is the wall clock of a frame less what the backend's own clock takes for it (`times`), so that it holds
all that is outside of the stages; `cpp_overhead_us` is the same in C++. A frame of the CPU leaves its caches cold,
which is most of what is measured then: `nothing` is a whole frame in warm ones. On a device `out` is a DeviceArray,
each frame is waited for, `new` copies to the host, and `arrays` are tensors of PyTorch.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import time

import swiftgs


def seconds(work, least):
    """Median of the time of a call, over as many as fit into `least` seconds."""
    work(), work()
    found, until = [], time.perf_counter() + least
    while time.perf_counter() < until or len(found) < 20:
        begun = time.perf_counter()
        work()
        found.append(time.perf_counter() - begun)
    return statistics.median(found)


def of_cpp(tool, scene, renderer, scale):
    """Milliseconds of a frame in C++, by the wall clock, and how much of it is outside of the stages."""
    command = [tool, "bench", scene, "--renderers", renderer, "--views", "0", "--scales", str(scale), "--errors",
               "none", "--json", "-"]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    results, _ = json.JSONDecoder().raw_decode(done.stdout)  # a table follows
    ms = results["rows"][0]["ms"]
    return ms["wall"]["median"], ms["wall"]["median"] - ms["total"]["median"]


def tensors_of(arrays, on_device):
    """On a device as tensors of PyTorch, without it none."""
    if not on_device:
        return arrays
    try:
        import torch  # pylint: disable=import-outside-toplevel
    except ImportError:
        return None
    return [torch.tensor(array, device="cuda") for array in arrays]


def frame_for(renderer, camera):
    if not renderer.on_device:
        return swiftgs.Frame.empty(camera.width, camera.height)
    return swiftgs.Frame(swiftgs.DeviceArray((camera.height, camera.width, 3)))


def measure(backend, tool, name, scale, least):
    count = int(name.partition(":")[2] or 200_000) if name.startswith("builtin") else None
    scene = swiftgs.Scene.builtin(count) if count else swiftgs.load(name)
    camera = (swiftgs.Camera.builtin() if count else swiftgs.load_cameras(name)[0]).scaled(scale)
    renderer = swiftgs.Renderer(backend, scene=scene)
    out, wait = frame_for(renderer, camera), renderer.wait if renderer.on_device else lambda: None

    small = swiftgs.Renderer(backend, scene=swiftgs.Scene.builtin(10))
    tiny = swiftgs.Camera.builtin(16, 16)
    tiny_out, own = frame_for(small, tiny), []

    def difference():
        begun = time.perf_counter()
        renderer.render(camera, out=out, times=True)
        wait()
        wall = time.perf_counter() - begun
        own.append(renderer.times.total)
        return wall * 1e6 - own[-1] * 1e3

    overhead_us = statistics.median(difference() for _ in range(200))
    arrays = tensors_of([scene.means, scene.rotations, scene.scales, scene.opacities, scene.sh], renderer.on_device)
    view = (camera.viewmat[None], camera.K[None], camera.width, camera.height)
    calls = {"nothing": lambda: (small.render(tiny, out=tiny_out), small.wait() if small.on_device else None),
             "out": lambda: (renderer.render(camera, out=out), wait()),
             "new": lambda: renderer.render(camera)}
    if arrays:
        calls["arrays"] = lambda: (swiftgs.rasterization(*arrays, *view, sh_degree=scene.sh_degree, renderer=renderer),
                                   wait())
    found = {call: seconds(work, least) * 1e3 for call, work in calls.items()}
    own_ms = statistics.median(own)
    cpp_ms, outside_ms = of_cpp(tool, name, renderer.name, scale)
    return {"renderer": renderer.name, "device": renderer.device_name, "scene": name, "gaussians": len(scene),
            "size": [camera.width, camera.height], "cpp_ms": cpp_ms, "cpp_overhead_us": outside_ms * 1e3,
            "python_clock_ms": own_ms, "python_ms": found, "overhead_us": overhead_us,
            "frames_per_second": {call: 1e3 / ms for call, ms in found.items()}}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tool", help="swiftgs, of the same build as the library")
    parser.add_argument("scenes", nargs="+", help="builtin, builtin:N, or folders of captures")
    parser.add_argument("--scale", type=float, default=1)
    parser.add_argument("--seconds", type=float, default=1, help="for each way of calling")
    parser.add_argument("--json", help="a file for the results; - for standard output")
    arguments = parser.parse_args()
    usable = {entry.name.partition("/")[0] for entry in swiftgs.list_renderers() if entry.usable} - {"serial"}
    rows = [measure(backend, arguments.tool, scene, arguments.scale, arguments.seconds) for scene in arguments.scenes
            for backend in sorted(usable)]
    if arguments.json:
        text = json.dumps({"version": swiftgs.__version__, "python": sys.version.split()[0], "results": rows}, indent=1)
        pathlib.Path(arguments.json).write_text(text + "\n") if arguments.json != "-" else print(text)
    if arguments.json != "-":
        print("| backend | scene | C++, ms | Python: the same clock, ms | out, ms | new, ms | arrays, ms | "
              "overhead, us | the same in C++, us | nothing, us |\n| --- | --- |" + 8 * " ---: |")
        for row in rows:
            ms = row["python_ms"]
            print(f"| {row['renderer'].partition('/')[0]} | {row['scene']} | {row['cpp_ms']:.3f} | "
                  f"{row['python_clock_ms']:.3f} | {ms['out']:.3f} | {ms['new']:.3f} | "
                  f"{format(ms['arrays'], '.3f') if 'arrays' in ms else ''} | {row['overhead_us']:.1f} | "
                  f"{row['cpp_overhead_us']:.1f} | "
                  f"{ms['nothing'] * 1e3:.1f} |")


if __name__ == "__main__":
    main()
