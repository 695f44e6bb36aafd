#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws docs/images/lens-splats.svg: outlines of balls that span 0.2 of their distance, as a lens shows them and as
their splats do, at angles away from the axis.

    python3 docs/images/lens_splats.py
"""
import math
import pathlib

TWO_SIGMA = 0.2  # of the distance
SCALE, SIDE = 170, 160  # pixels a radian; of a field
ANGLES = (0, 30, 60, 75)


def perspective(p):
    return p[0] / p[2], p[1] / p[2]


def fisheye(p):
    across = math.hypot(p[0], p[1])
    angle = math.atan2(across, p[2])
    return (angle * p[0] / across, angle * p[1] / across) if across else (0.0, 0.0)


def equirectangular(p):
    return math.atan2(p[0], p[2]), math.atan2(p[1], math.hypot(p[0], p[2]))


LENSES = {"perspective": (perspective, 0), "fisheye": (fisheye, 0), "equirectangular, elevation": (equirectangular, 1)}


def outlines(lens, axis, degrees):
    """Points about the shown centre: of the exact outline, and of the linearised one."""
    angle = math.radians(degrees)
    ahead = [0.0, 0.0, math.cos(angle)]
    ahead[axis] = math.sin(angle)
    away = [0.0, 0.0, -math.sin(angle)]
    away[axis] = math.cos(angle)
    side = [float(axis == 1), float(axis == 0), 0.0]
    centre, step = lens(ahead), 1e-5
    exact, linear = [], []
    cone = math.asin(TWO_SIGMA)
    for i in range(73):
        c, s = math.cos(math.radians(5 * i)), math.sin(math.radians(5 * i))
        turned = [c * a + s * b for a, b in zip(away, side)]
        seen = lens([math.cos(cone) * a + math.sin(cone) * t for a, t in zip(ahead, turned)])
        near = lens([a + step * t for a, t in zip(ahead, turned)])
        exact.append([a - b for a, b in zip(seen, centre)])
        linear.append([TWO_SIGMA / step * (a - b) for a, b in zip(near, centre)])
    return exact, linear


def path(points, x, y, style):
    text = " ".join(f"{x + SCALE * u:.1f},{y + SCALE * v:.1f}" for u, v in points)
    return f'<polyline points="{text}" fill="none" {style}/>'


def main():
    rows = []
    for row, (name, (lens, axis)) in enumerate(LENSES.items()):
        y = 30 + SIDE * (row + 0.5)
        rows.append(f'<text x="8" y="{y + 4:.0f}">{name}</text>')
        for column, degrees in enumerate(ANGLES):
            x = 190 + SIDE * (column + 0.5)
            if row == 0:
                rows.append(f'<text x="{x:.0f}" y="20" text-anchor="middle">{degrees}°</text>')
            exact, linear = outlines(lens, axis, degrees)
            if max(abs(p) for point in exact + linear for p in point) * SCALE > 0.5 * SIDE:
                factor = 0.45 * SIDE / SCALE / max(abs(p) for point in exact + linear for p in point)
                exact, linear = ([[factor * p for p in point] for point in line] for line in (exact, linear))
                rows.append(f'<text x="{x:.0f}" y="{y + 0.5 * SIDE - 4:.0f}" text-anchor="middle" '
                            f'font-size="11">at {factor:.2f} of the size</text>')
            rows += [path(exact, x, y, 'stroke="#d1495b" stroke-width="2"'),
                     path(linear, x, y, 'stroke="#30638e" stroke-width="2" stroke-dasharray="5 3"')]
    width, height = 190 + SIDE * len(ANGLES), 60 + SIDE * len(LENSES)
    rows.append(f'<text x="190" y="{height - 10}" fill="#d1495b">as the lens shows the ball</text>'
                f'<text x="400" y="{height - 10}" fill="#30638e">as its splat does</text>')
    body = "\n".join(rows)
    text = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
            f'font-size="14">\n<rect width="{width}" height="{height}" fill="white"/>\n{body}\n</svg>\n')
    pathlib.Path(__file__).with_name("lens-splats.svg").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
