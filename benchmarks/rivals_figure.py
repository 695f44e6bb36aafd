#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws docs/images/rivals.svg: time against error of this library, gsplat and HiGS, from `beside-gsplat.json`.

    python3 benchmarks/rivals_figure.py
"""
import html
import math
import pathlib

from tables.gsplat import NAME, rivals_of
from tables.source import Source

WIDTH, HEIGHT, LEFT, BOTTOM = 700, 330, 60, 60
COLOURS = {"gsplat": "#8d99ae", "HiGS, gsplat's path for inference": "#d1495b", "**SwiftGS**": "#30638e"}
MARKS = ("circle", "square", "triangle")


def mark(kind, x, y, colour):
    if kind == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="{colour}"/>'
    if kind == "square":
        return f'<rect x="{x - 6:.1f}" y="{y - 6:.1f}" width="12" height="12" fill="{colour}"/>'
    return f'<path d="M{x:.1f} {y - 7:.1f}l7 13h-14z" fill="{colour}"/>'


def draw(found):
    """The figure: time grows to the right, error downwards."""
    times = [ms for each in found.values() for _, ms, _ in each]
    low, high = math.floor(math.log2(min(times)) * 2) / 2, math.ceil(math.log2(max(times)) * 2) / 2
    across = lambda ms: LEFT + (math.log2(ms) - low) / (high - low) * (WIDTH - LEFT - 20)
    up = lambda db: HEIGHT - BOTTOM - (db - 50) / 70 * (HEIGHT - BOTTOM - 30)
    parts = []
    for db in range(50, 121, 10):
        parts.append(f'<path d="M{LEFT} {up(db):.1f}H{WIDTH - 20}" stroke="#ddd"/>'
                     f'<text x="{LEFT - 8}" y="{up(db) + 4:.1f}" text-anchor="end">{db}</text>')
    for tick in (2 ** k for k in range(math.ceil(low), math.floor(high) + 1)):
        parts.append(f'<path d="M{across(tick):.1f} 30V{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                     f'<text x="{across(tick):.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{tick:g}</text>')
    for kind, (scene, each) in zip(MARKS, found.items()):
        for name, ms, db in each:
            parts.append(mark(kind, across(ms), up(db), COLOURS[name]))
    x = LEFT
    for name, colour in COLOURS.items():
        text = html.escape(name.strip("*"))
        parts.append(f'<text x="{x}" y="18" fill="{colour}" font-weight="bold">{text}</text>')
        x += 9 * len(text)
    x = WIDTH - 20 - 75 * len(found)
    for kind, scene in zip(MARKS, found):
        parts.append(mark(kind, x, HEIGHT - 14, "#444") + f'<text x="{x + 12}" y="{HEIGHT - 9}">{html.escape(scene)}</text>')
        x += 75
    parts.append(f'<text x="{LEFT}" y="{HEIGHT - 9}">milliseconds a frame; up: PSNR against float64, dB</text>')
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
            f'font-size="13">\n<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>\n' + "\n".join(parts) + "\n</svg>\n")


def main():
    found = {scene: each for scene, each in rivals_of(Source(), "gpu").items() if not scene.startswith("builtin")}
    path = pathlib.Path(__file__).resolve().parents[1] / "docs/images/rivals.svg"
    path.write_text(draw(found), encoding="utf-8")
    print(f"{path} shows {NAME}: {', '.join(found)}")


if __name__ == "__main__":
    main()
