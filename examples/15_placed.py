# SPDX-License-Identifier: Apache-2.0
"""Moves three objects about a room: a folder of images, each from the front and from behind.

    python3 15_placed.py --frames 48
"""
import argparse
import pathlib

import numpy as np

import swiftgs

# Objects are parts of the room: clips cut them out. Each has a middle, a height above the floor and a scale.
OBJECTS = [(swiftgs.Clip.box((-0.7, -1.9, -0.7), (0.7, -0.57, 0.7)), (0, -1.17, 0), 0.5, 0.5),
           (swiftgs.Clip.box((-1.62, -1.06, 0.1), (-0.94, -0.01, 0.74)), (-1.28, -0.5, 0.42), 0.55, 1.0),
           (swiftgs.Clip([[0, -1, 0, -0.02]], (1.22, -0.335, -0.42), 0.5), (1.22, -0.335, -0.42), 1.4, 0.8)]


def pose(middle, height, scale, angle):
    """Turned by `angle` about the vertical, on a circle around the room's middle. y points down."""
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.diag([scale, scale, scale, 1]) @ [[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]]
    matrix[:3, 3] = (1.9 * s, -height, 1.9 * c) - matrix[:3, :3] @ middle
    return matrix


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--frames", type=int, default=12, help="number of images [12]")
parser.add_argument("--width", type=int, default=640, help="of the images [640]")
options = parser.parse_args()
pathlib.Path("placed").mkdir(exist_ok=True)
front = swiftgs.Camera.builtin().scaled(options.width / 1280)
behind = swiftgs.Camera.look_at((0.9, -1.5, 4), (0, -0.9, 0), width=front.width, height=front.height, vertical_fov=0.76)
renderer = swiftgs.Renderer(scene=swiftgs.Scene.builtin())
for number in range(options.frames):
    turns = 2 * np.pi * (number / options.frames + np.arange(3) / 3)
    renderer.place([swiftgs.Placement()] + [swiftgs.Placement(0, pose(middle, height, scale, turn), clip=clip)
                                            for (clip, middle, height, scale), turn in zip(OBJECTS, turns)])
    frame = renderer.render([front, behind])
    swiftgs.Frame(np.concatenate(frame.colour)).save(f"placed/{number:03}.png")
