# SPDX-License-Identifier: Apache-2.0
"""Simulates many worlds, and draws all their cameras in one frame a step. simulator.png shows two worlds, a time a row.

    python3 16_simulator.py --worlds 64 --steps 250

A world is a room, the same in all of them, with three objects that move about. PyTorch or CuPy compute poses on a GPU,
where the renderer reads them, and under PyTorch a CUDA graph holds the whole step. Without them NumPy does on the host.
"""
import argparse
import functools
import importlib.util
import time

import numpy as np

import swiftgs

# Objects are boxes of the built-in scene, from low to high, and stand on the floor with a scale. y points down.
OBJECTS = [((-0.7, -1.9, -0.7), (0.7, -0.57, 0.7), 0.6), ((-2, -2.1, -0.1), (-0.7, -0.02, 1), 0.7),
           ((0.7, -0.85, -0.95), (1.75, -0.03, 0.1), 0.9)]
EYES = [(0.5, -1.7, -4.6), (4.3, -2, 1.8), (-3.6, -3.4, 2.4)]  # a world's cameras
SECONDS, ROWS = 0.05, 4  # of a step, of the picture


def arrays_library():
    """PyTorch or CuPy if they and swiftgs reach a GPU, or else NumPy."""
    if any(entry.usable and entry.on_device for entry in swiftgs.list_renderers()):
        for name in filter(importlib.util.find_spec, ("torch", "cupy")):
            library = importlib.import_module(name)
            if library.cuda.is_available():
                return library
    return np


def cut(scene, chosen, middle=(0, 0, 0)):
    """A scene of the chosen Gaussians, with its zero at `middle`."""
    others = (scene.scales, scene.rotations, scene.opacities, scene.sh0, scene.sh_rest)
    return swiftgs.Scene.from_arrays(scene.means[chosen] - np.float32(middle), *(array[chosen] for array in others))


def move(xp, position, velocity, rotations, translations):
    """A step of all objects, in place: they circle about the middle of the room, push each other away, and look where
    they go. Positions and velocities are [worlds, objects, x and z]."""
    apart = position[:, :, None] - position[:, None]
    push = (apart / ((apart ** 2).sum(-1) + 0.05)[..., None]).sum(2)
    radius = ((position ** 2).sum(-1) ** 0.5)[..., None]
    velocity += SECONDS * (push + 6 * (1.2 / radius - 1) * position)
    position += SECONDS * velocity
    angle = xp.arctan2(velocity[..., 0], velocity[..., 1])
    rotations[..., 0, 0], rotations[..., 0, 2] = xp.cos(angle), xp.sin(angle)
    rotations[..., 2, 0], rotations[..., 2, 2] = -xp.sin(angle), xp.cos(angle)
    translations[..., 0], translations[..., 2] = position[..., 0], position[..., 1]


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--worlds", type=int, default=8, help="number of worlds [8]")
parser.add_argument("--steps", type=int, default=8, help="from one row of the picture to the next [8]")
parser.add_argument("--size", type=int, default=128, help="of the images' sides [128]")
options = parser.parse_args()
size, worlds, placed = options.size, options.worlds, 1 + len(OBJECTS)

xp = arrays_library()
torch = xp if xp.__name__ == "torch" else None
array = functools.partial(torch.as_tensor, device="cuda") if torch else xp.asarray
stream = torch.cuda.Stream() if torch else None  # not the default one, for the graph
if torch:
    torch.cuda.set_stream(stream)
renderer = swiftgs.Renderer("cpu" if xp is np else "cuda", stream=stream)
whole = swiftgs.Scene.builtin(40_000)
inside = [((whole.means > np.float32(low)) & (whole.means < np.float32(high))).all(1) for low, high, _ in OBJECTS]
renderer.add_scene(cut(whole, ~np.any(inside, axis=0)))
for (low, high, _), chosen in zip(OBJECTS, inside):
    renderer.add_scene(cut(whole, chosen, ((low[0] + high[0]) / 2, high[1], (low[2] + high[2]) / 2)))
# An image shows one range of placements, so each world places the room anew. No Gaussian is copied.
renderer.place([swiftgs.Placement(number, np.diag([scale, scale, scale, 1])) for _ in range(worlds)
                for number, scale in enumerate([1] + [scale for *_, scale in OBJECTS])])
cameras = worlds * [swiftgs.Camera.look_at(eye, (0, -0.6, 0), width=size, height=size, vertical_fov=0.8)
                    for eye in EYES]
images = array(np.empty((len(cameras), size, size, 3), np.float32))
frame = swiftgs.Frame(images, shows=[range(w * placed, (w + 1) * placed) for w in range(worlds) for _ in EYES])
renderer.reserve(cameras, frame)
renderer.record()
needed = renderer.report  # other steps may need more
renderer.reserve(cameras, frame, splats=2 * needed.visible, intersections=2 * needed.intersections)
rotations, translations = (array(numbers).reshape(worlds, placed, *numbers.shape[1:])[:, 1:]  # those of objects
                           for numbers in (renderer.recorded_scenes.rotations, renderer.recorded_scenes.translations))
random = np.random.default_rng(1)
angles = random.uniform(0, 7, (worlds, 1)) + 2 * np.pi * np.arange(len(OBJECTS)) / len(OBJECTS)
out = np.stack([np.sin(angles), np.cos(angles)], axis=2)
state = array(1.5 * out), array(random.uniform(1, 3, (worlds, 1, 1)) * out[..., ::-1] * [1, -1])


def step():
    move(xp, *state, rotations, translations)
    renderer.record()


step()  # outside of the capture first: PyTorch takes memory
if torch:
    graph = torch.cuda.CUDAGraph()
    with torch.cuda.graph(graph, stream=stream):
        step()
    step = graph.replay
rows, seconds = [], 0
for _ in range(ROWS):
    begun = time.perf_counter()
    for _ in range(options.steps):
        step()
    renderer.wait()
    seconds += time.perf_counter() - begun
    if renderer.report.overflowed or renderer.refused_scenes:
        raise SystemExit(f"not drawn: {renderer.report}, placements {renderer.refused_scenes}")
    shown = images[:2 * len(EYES)]
    rows.append(np.hstack(shown.cpu().numpy() if torch else shown.get() if xp is not np else shown))
swiftgs.Frame(np.vstack(rows)).save("simulator.png")
print(f"{len(cameras)} images a step on {renderer.device_name}, poses by {xp.__name__}: "
      f"{ROWS * options.steps * len(cameras) / seconds:,.0f} images a second")
