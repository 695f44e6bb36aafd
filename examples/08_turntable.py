# SPDX-License-Identifier: Apache-2.0
"""Walks around a scene: a folder of images, numbered for a video.

    python3 08_turntable.py                       the built-in scene
    python3 08_turntable.py garden/ --frames 120  a capture, on the path of its cameras
    python3 08_turntable.py garden.spz            a file, around the middle of its Gaussians
"""
import argparse
import pathlib

import numpy as np

import swiftgs


def middle_of(cameras):
    """The point that the cameras look at: nearest to all their axes. The built-in camera looks at the terrace."""
    if len(cameras) == 1:
        return np.array([0, -0.5, 0])
    axes, eyes = (np.stack([getattr(camera, name) for camera in cameras]) for name in ("rotation", "position"))
    across = np.eye(3) - axes[:, 2, :, None] * axes[:, 2, None, :]
    return np.linalg.solve(across.sum(axis=0), (across @ eyes[:, :, None]).sum(axis=0))[:, 0]


def swing(middle, start, up, cameras, frames):
    """Angles of a full turn, or to and fro where the cameras leave more than a sixth of it out."""
    out = start - middle - up * ((start - middle) @ up)
    right = np.cross(up, out)
    across = np.stack([camera.position for camera in cameras]) - middle
    angles = np.sort(np.arctan2(across @ right, across @ out))
    gaps = np.diff(angles, append=angles[0] + 2 * np.pi)
    widest = np.argmax(gaps)
    turn = np.linspace(0, 2 * np.pi, frames, endpoint=False)
    if gaps[widest] < np.pi / 3:
        return turn
    first, wide = angles[(widest + 1) % len(angles)], 2 * np.pi - gaps[widest]
    return first + wide * (0.5 - 0.5 * np.cos(turn))


def path_around(scene, cameras, up, frames, width, height):
    """Cameras on a circle: that of a capture's cameras, or one from which most Gaussians are in view."""
    turn = np.linspace(0, 2 * np.pi, frames, endpoint=False)
    if cameras:
        middle, fov = middle_of(cameras), 2 * np.arctan(cameras[0].height / (2 * cameras[0].fy))
        up = -np.mean([camera.rotation[1] for camera in cameras], axis=0)
        up /= np.linalg.norm(up)
        outs = np.stack([camera.position for camera in cameras]) - middle
        start = middle + outs[0] * np.median(np.linalg.norm(outs, axis=1)) / np.linalg.norm(outs[0])
        if len(cameras) > 1:
            turn = swing(middle, start, up, cameras, frames)
        view = swiftgs.OrbitView(swiftgs.Camera.look_at(start, middle, up=up, width=width, height=height,
                                                        vertical_fov=fov), middle, up)
    else:
        view = scene.default_view(width, height, up=up)
        view = view._replace(camera=view.orbit(0, distance=2))  # stands back, to go around what is there
    return [view.orbit(angle) for angle in turn]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="?", type=pathlib.Path, help="a file or the folder of a capture")
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--size", type=int, nargs=2, default=(640, 360), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--up", type=float, nargs=3, default=(0, -1, 0), metavar=("X", "Y", "Z"),
                        help="points up, in the world of a file without cameras")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("turntable"))
    arguments = parser.parse_args()

    if arguments.scene is None:
        scene, cameras = swiftgs.Scene.builtin(), [swiftgs.Camera.builtin()]
    else:
        scene = swiftgs.load(arguments.scene)
        cameras = swiftgs.load_cameras(arguments.scene) if arguments.scene.is_dir() else []
        cameras = [camera.relative_to(scene.origin) for camera in cameras]
    path = path_around(scene, cameras, arguments.up, arguments.frames, *arguments.size)

    arguments.out.mkdir(parents=True, exist_ok=True)
    with swiftgs.Renderer(scene=scene) as renderer:
        print(scene, renderer, sep="\n")
        image = swiftgs.Frame.empty(*arguments.size)
        for number, camera in enumerate(path):
            renderer.render(camera, out=image, times=True)  # the same memory again and again
            image.save(arguments.out / f"{number:04}.png")
        print(f"the last of {len(path)} frames took {renderer.times.total:.1f} ms; images in {arguments.out}")


if __name__ == "__main__":
    main()
