#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws docs/images/rivals.svg from `rivals.json`: time against error of each renderer on each scene.

    python3 benchmarks/rivals_figure.py
"""
import html
import math
import pathlib
import sys

sys.dont_write_bytecode = True

from tables.blocks import Source  # noqa: E402
from tables.rivals import NAME, RIVALS, reached, rivals_in, scenes_of  # noqa: E402

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 720, 320, 60, 24, 44, 56
COLOURS = dict(zip(RIVALS, ("#6c757d", "#4c956c", "#c8553d", "#1b6ca8")))
LEAST, MOST = 60, 130  # dB
TICKS = (0.125, 0.25, 0.5, 1, 2, 4, 8, 16, 32)  # ms
# Outlines around 0, 0 for one scene each.
MARKS = ("m-6 0a6 6 0 1 0 12 0a6 6 0 1 0-12 0z", "m-5.5-5.5h11v11h-11z", "m0-7l7 13h-14z", "m0-8l7 8l-7 8l-7-8z")


def mark(kind, x, y, colour):
    return f'<path d="M{x:.1f} {y:.1f}{MARKS[kind]}" fill="{colour}" stroke="white"/>'


def text(x, y, words, anchor="middle", more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{more}>{html.escape(words)}</text>'


def draw(found):
    """The figure of {scene: {renderer: Found}}: time grows to the right, error downwards."""
    times = [each.ms for of_scene in found.values() for each in of_scene.values()]
    low, high, right, bottom = math.log2(min(times)) - 0.4, math.log2(max(times)) + 0.4, WIDTH - RIGHT, HEIGHT - BOTTOM

    def across(ms):
        return LEFT + (math.log2(ms) - low) / (high - low) * (right - LEFT)

    def up(db):
        return bottom - (db - LEAST) / (MOST - LEAST) * (bottom - TOP)

    parts = []
    for db in range(LEAST, MOST + 1, 10):
        parts += [f'<path d="M{LEFT} {up(db):.1f}H{right}" stroke="#ddd"/>',
                  text(LEFT - 8, up(db) + 4, f"{db} dB", "end")]
    for tick in (tick for tick in TICKS if low <= math.log2(tick) <= high):
        parts += [f'<path d="M{across(tick):.1f} {TOP}V{bottom}" stroke="#ddd"/>',
                  text(across(tick), bottom + 18, f"{tick:g} ms")]
    for kind, of_scene in enumerate(found.values()):
        parts += [mark(kind, across(each.ms), up(each.db), COLOURS[name]) for name, each in of_scene.items()]
    x = LEFT
    for name in next(iter(found.values())):
        parts.append(text(x, 26, name, "start", f' fill="{COLOURS[name]}" font-weight="bold"'))
        x += 9 * len(name) + 14
    x = right
    for kind, scene in reversed(list(enumerate(found))):
        x -= 8 * len(scene)
        parts += [mark(kind, x - 14, 22, "#444"), text(x, 26, scene, "start")]
        x -= 36
    parts.append(text(LEFT, HEIGHT - 12, "Time of a frame to the right, PSNR against float64 upwards: the best are at "
                      "the top left.", "start"))
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
            f'font-size="13">\n<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>\n'
            + "\n".join(parts) + "\n</svg>\n")


def main():
    _, rows = Source().rows("gpu", NAME)
    found = {scene: {rival: reached(of_scene, rival) for rival in rivals_in(rows)}
             for scene, of_scene in scenes_of(rows).items()}
    path = pathlib.Path(__file__).resolve().parents[1] / "docs/images/rivals.svg"
    path.write_text(draw(found), encoding="utf-8")
    print(f"{path.name} shows {NAME}: {', '.join(found)}")


if __name__ == "__main__":
    main()
