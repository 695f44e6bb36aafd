# SPDX-License-Identifier: Apache-2.0
"""The clauses of the conformance set: what each asks, and the Gaussians and the camera that ask it.

The world's axes are those of most cameras here: x right, y down, z forward. Sizes are such that an image shows 4 units
at depth 4, whatever its side.
"""
import math

WHITE, GREY, RED, GREEN, BLUE, ORANGE = (1, 1, 1), (0.5, 0.5, 0.5), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0.6, 0.2)
KHRONOS, INRIA, GSPLAT = "KHR_gaussian_splatting", "INRIA", "gsplat"


def turn(axis, degrees, length=1):
    """The quaternion (w, x, y, z) of a turn, of any length."""
    half, norm = math.radians(degrees) / 2, math.hypot(*axis)
    return tuple(length * part for part in (math.cos(half), *(math.sin(half) * x / norm for x in axis)))


def gaussian(mean, scale, colour=WHITE, opacity=0.9, rotation=(1, 0, 0, 0), rest=None):
    """`rest`: {(harmonic from 1, channel): coefficient}."""
    scales = scale if isinstance(scale, tuple) else (scale,) * 3
    return {"mean": mean, "scales": scales, "colour": colour, "opacity": opacity, "rotation": rotation,
            "rest": rest or {}}


def layers(count, depth, step, scale, colours, opacity, at=(0.1, 0.05)):
    """Gaussians one behind another, as wide in the image."""
    return [gaussian((at[0] * z / depth, at[1] * z / depth, z), scale * z / depth, colours(k), opacity)
            for k in range(count) for z in [depth + step * k]]


def camera(side, focal=(1, 1), centre=(0.5, 0.5), position=(0, 0, 0), rotation=(1, 0, 0, 0), mirrored=False):
    """INRIA's JSON; `focal` and `centre` are in sides of the image."""
    w, x, y, z = rotation
    axes = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    if mirrored:
        axes = [[-right, down, ahead] for right, down, ahead in axes]
    return {"id": 0, "img_name": "view", "width": side, "height": side, "position": list(position), "rotation": axes,
            "fx": focal[0] * side, "fy": focal[1] * side, "cx": centre[0] * side, "cy": centre[1] * side}


def padding(view):
    """Gaussians that nobody sees: viewers that lose files of a few Gaussians, or divide by the range of depths when
    they sort, then draw the others. They stand where four pixels meet, which hold alphas below 1/255; viewers that leave out
    faint Gaussians when they read a file keep an opacity of 0.006."""
    found = []
    for k in range(8):
        depth, x, y = 1.5 + k, (3, view["width"] - 3)[k % 2], (3, view["height"] - 3)[k // 2 % 2]
        here = ((x - view["cx"]) / view["fx"] * depth, (y - view["cy"]) / view["fy"] * depth, depth)
        found.append(gaussian(tuple(p + sum(a * b for a, b in zip(row, here))
                                    for p, row in zip(view["position"], view["rotation"])), 0.01, (0, 0, 0), 0.006))
    return found


def grid(columns, rows, pitch):
    return [((i - (columns - 1) / 2) * pitch + 0.02, (j - (rows - 1) / 2) * pitch + 0.03)
            for j in range(rows) for i in range(columns)]


def harmonics(degree):
    """Each coefficient of a degree alone, in a Gaussian of its own."""
    first, count = degree * degree, 2 * degree + 1
    places = grid(min(count, 4), (count + 3) // 4, 0.9)
    return [gaussian((*places[k], 4), 0.17, GREY, 0.95,
                     rest={(first + k, 0): 0.6, (first + k, 1): -0.6, (first + k, 2): 0.3}) for k in range(count)]


def mixed(places, depth, scales, rotation=lambda k: (1, 0, 0, 0)):
    """Gaussians with coefficients of several degrees."""
    return [gaussian((*place, depth + 0.2 * k), scales, GREY, 0.95, rotation(k),
                     {(1 + k % 15, 0): 0.5, (1 + (k + 5) % 15, 1): 0.5, (1 + (k + 9) % 15, 2): -0.5, (3, 2): 0.4})
            for k, place in enumerate(places)]


def clauses(side):
    """Rows of (name, meaning, Gaussians, members that are not the default)."""
    def view(**given):
        return camera(side, **given)
    skew, long = turn((1, 2, 3), 50), (0.6, 0.15, 0.05)
    tiny = [gaussian((*place, 4), 0.0005, WHITE, 0.9) for place in grid(6, 6, 0.56 + 1 / 3 / side)]
    ring = [2 * math.pi * k / 8 for k in range(8)]
    close = [gaussian((0.03 * k - 0.14, 0.02 * k - 0.09, 4 + 0.0004 * k), 0.4, (RED, GREEN, BLUE)[k % 3], 0.6)
             for k in range(11, -1, -1)]
    return [
        ("centre", "A mean on the axis lands on the principal point, which lies between four pixels.",
         [gaussian((0, 0, 4), (0.4, 0.2, 0.1), ORANGE, 0.8, turn((1, 2, 3), 40))], {}),
        ("pixel-centres", "Pixels are sampled at their centres: means stand at quarters of a pixel.",
         [gaussian((4 * ((i + 0.5) / 4 + i / 4 / side - 0.5), 4 * ((j + 0.5) / 4 + j / 4 / side - 0.5), 4), 0.01)
          for j in range(4) for i in range(4)], {}),
        ("anisotropic", "Scales along the axes of the world, off the centre.",
         [gaussian((0.5, -0.3, 4), long, ORANGE)], {}),
        ("rotated", "Scales along turned axes.",
         [gaussian((0.5, -0.3, 4), long, ORANGE, 0.9, skew),
          gaussian((-0.8, 0.7, 5), (0.1, 0.5, 0.3), BLUE, 0.9, turn((3, -1, 2), 110))], {}),
        ("covariance-0", "A splat along the axes of the image, whose covariance of x and y is exactly 0.",
         [gaussian((0.8, 0, 4), (0.5, 0.15, 0.1), ORANGE), gaussian((0, -1, 4), (0.15, 0.4, 0.1), BLUE),
          gaussian((-0.9, 0, 4), (0.15, 0.4, 0.1), GREEN)], {}),
        ("isotropic", "A splat that is a circle, with equal variances and covariance 0.",
         [gaussian((0, 0, 4), 0.4, ORANGE), gaussian((1.2, 0.9, 4), 0.3, BLUE)], {}),
        ("quaternion-length", "Quaternions of length 3 and 0.2 are the rotations of those of length 1.",
         [gaussian((0.5, -0.3, 4), long, ORANGE, 0.9, turn((1, 2, 3), 50, 3)),
          gaussian((-0.8, 0.7, 5), (0.1, 0.5, 0.3), BLUE, 0.9, turn((3, -1, 2), 110, 0.2))], {"silent": [KHRONOS]}),
        ("quaternion-negated", "A quaternion and its negative are one rotation.",
         [gaussian((0.5, -0.3, 4), long, ORANGE, 0.9, turn((1, 2, 3), 50, -1)),
          gaussian((-0.8, 0.7, 5), (0.1, 0.5, 0.3), BLUE, 0.9, turn((3, -1, 2), 110, -1))], {}),
        ("harmonics-0", "Colour is 0.28209 times the coefficient, plus a half.",
         [gaussian((*place, 4), 0.16, (k % 3 / 2, k // 3 / 2, 1 - k / 8), 0.95)
          for k, place in enumerate(grid(3, 3, 1.1))], {}),
        ("harmonics-1", "Each coefficient of degree 1 alone: order and signs.", harmonics(1), {}),
        ("harmonics-2", "Each coefficient of degree 2 alone.", harmonics(2), {}),
        ("harmonics-3", "Each coefficient of degree 3 alone.", harmonics(3), {}),
        ("harmonics-posed", "A camera that is moved and turned: directions are the world's, not the camera's.",
         mixed(grid(3, 3, 1.2), 4, (0.4, 0.15, 0.08), lambda k: turn((k, 1, 2), 37 * k)),
         {"camera": view(focal=(0.85, 0.85), position=(1.2, -0.8, -0.6), rotation=turn((0.4, -1, 0.3), 17))}),
        ("harmonics-mean", "One direction a Gaussian, from the camera to its mean: wide splats have one colour.",
         mixed([(-2.6, -2), (2.4, -2.2), (0.3, 0.4), (-2.3, 2.4), (2.7, 2)], 4, 0.6),
         {"camera": view(focal=(0.5, 0.5))}),
        ("colour-below-0", "Colours below 0 count as 0.",
         [gaussian((0.1, 0.1, 4), 0.4, (-1, 0.2, 0.5), 0.9), gaussian((0.1, 0.1, 5), 0.55, GREY)],
         {"silent": [KHRONOS]}),
        ("colour-above-1", "Colours above 1 are not cut before they are blended.",
         [gaussian((0.1, 0.1, 4), 0.4, (2.5, 1.5, 0.5), 0.3), gaussian((0.1, 0.1, 5), 0.55, (0.2, 0.2, 0.2), 0.6)],
         {"silent": [KHRONOS]}),
        ("opacity-limit", "An alpha above 0.99: limited there, or taken as it is.",
         [gaussian((0.1, 0.1, 4), 1.2, BLUE, 0.999), gaussian((0.1, 0.1, 5), 1.5, WHITE, 0.95)], {}),
        ("opacity-1", "An opacity of exactly 1: a hundredth of what is behind shows, or nothing.",
         [gaussian((0.1, 0.1, 4), 1.2, GREEN, 1), gaussian((0.1, 0.1, 5), 1.5, RED, 0.95)], {}),
        ("alpha-min", "Alphas below 1/255 are skipped: a step at the edge of each splat, ten times in one place.",
         layers(10, 4, 0.02, 0.4, lambda k: WHITE, 0.1), {"silent": [KHRONOS]}),
        ("three-sigma", "Where a splat ends: at alpha 1/255, at three standard deviations, or at a square around them.",
         layers(6, 4, 0.02, 0.5, lambda k: WHITE, 0.9, (-0.475, 0.3)), {}),
        ("faint-layers", "80 layers of opacity 0.016: what a kernel cut early leaves out adds up.",
         layers(80, 4, 0.004, 0.35, lambda k: WHITE, 0.016), {"silent": [KHRONOS]}),
        ("blur", "Gaussians far below a pixel: the 0.3 px² added to both variances is all that shows.", tiny,
         {"silent": [KHRONOS]}),
        ("compensation", "The same, whose opacity shrinks as the blur makes them larger; the file says so.",
         [gaussian((x, y, 4), 0.03, WHITE, 0.9) for x, y in grid(6, 6, 0.56 + 1 / 3 / side)],
         {"antialiased": True, "silent": [KHRONOS]}),
        ("needle", "Needles, a thousand times as long as wide, in seven directions.",
         [gaussian((math.cos(a) * 0.6, math.sin(a) * 0.6, 4), (0.8, 0.0008, 0.0008), (WHITE, ORANGE)[k % 2], 0.9,
                   turn((0, 0, 1), math.degrees(a))) for k in range(14) for a in [math.pi * (k + 0.25) / 7]], {}),
        ("early-stop", "A pixel ends before a splat, bright here, that would bring its transmittance below 1e-4.",
         [gaussian((0.1, 0.1, 4), 1.2, (0.1, 0.1, 0.1), 0.93), gaussian((0.1, 0.1, 5), 1.5, (0.1, 0.1, 0.1), 0.93),
          gaussian((0.1, 0.1, 6), 1.8, (4, 2, 1), 0.9999)], {"silent": [KHRONOS]}),
        ("order-z", "Pairs of which one Gaussian is nearer in z and the other in distance.",
         [gaussian((x, y, z), 0.3, colour) for x, y, z, colour in (
             (-1.7, -0.4, 4, RED), (-1.3, -0.4, 4.08, ORANGE), (1.7, 0.6, 4, BLUE), (1.3, 0.6, 4.08, GREEN))], {}),
        ("order-distance", "Equal z and unequal distances, the farthest first in the file.",
         [gaussian((0.35 * k - 0.15, 0.2 * k - 0.2, 4), 0.3, (RED, GREEN, BLUE, WHITE, ORANGE)[k], 0.8)
          for k in range(4, -1, -1)], {}),
        ("order-equal", "Equal z and equal distances: the first in the file is in front.",
         [gaussian((x, y, 4), 0.4, colour, 0.8)
          for (x, y), colour in zip(((-0.25, 0.25), (0.25, 0.25), (0.25, -0.25), (-0.25, -0.25)),
                                    (RED, GREEN, BLUE, WHITE))], {"silent": [KHRONOS]}),
        ("order-close", "Depths that differ by 1e-4 of themselves, the farthest first in the file.", close, {}),
        ("order-close-far", "The same beside a Gaussian at depth 400: keys of 16 bits over the range have one value.",
         close + [gaussian((60, 40, 400), 8, WHITE, 0.5)], {}),
        ("near-0.2", "Gaussians in front of depth 0.2 and behind it.",
         [gaussian((0.3 * z * x, 0.2 * z * x, z), 0.07 * z, colour, 0.8) for z, x, colour in (
             (0.12, -1, RED), (0.18, -0.4, GREEN), (0.23, 0.4, BLUE), (0.5, 1, WHITE))], {"silent": [KHRONOS]}),
        ("near-0.01", "Gaussians in front of depth 0.01 and behind it.",
         [gaussian((0.3 * z * x, 0.2 * z * x, z), 0.07 * z, colour, 0.8) for z, x, colour in (
             (0.004, -1, RED), (0.008, -0.4, GREEN), (0.013, 0.4, BLUE), (0.5, 1, WHITE))], {"silent": [KHRONOS]}),
        ("principal-point", "A principal point far from the centre of the image.",
         [gaussian((0.3, -0.9, 4), (0.5, 0.2, 0.1), ORANGE, 0.9, turn((0, 0, 1), 30)),
          gaussian((1.3, -1.8, 4), 0.25, GREEN)],
         {"camera": view(centre=(0.27, 0.78)), "silent": [INRIA, KHRONOS]}),
        ("focal-lengths", "Unequal focal lengths.",
         [gaussian((0.6, -0.7, 4), (0.6, 0.2, 0.1), ORANGE, 0.9, turn((0, 0, 1), 30)),
          gaussian((-0.7, 0.6, 4), 0.3, GREEN)], {"camera": view(focal=(1.1, 0.7))}),
        ("wide-angle", "A view of 118 degrees: the projection is linear in every Gaussian, which circles show.",
         [gaussian((x, y, 3), 0.45, colour, 0.9) for x, y, colour in (
             (0.2, 0.1, WHITE), (3.5, 0.4, ORANGE), (-3.2, 2.8, GREEN), (-0.5, -3.6, BLUE))],
         {"camera": view(focal=(0.3, 0.3))}),
        ("clamp-image", "A limit of x/z where the projection is linearised, beside a principal point off the centre.",
         [gaussian((-2.6, 0.5, 3), (0.5, 0.3, 0.9), ORANGE), gaussian((4.6, -0.9, 3), (0.8, 0.4, 1), BLUE)],
         {"camera": view(focal=(0.6, 0.6), centre=(0.32, 0.6)), "silent": [KHRONOS]}),
        ("clamp-centre", "The same limit beside a centred principal point.",
         [gaussian((4.3, 0.3, 3), (0.9, 0.4, 0.9), WHITE), gaussian((-3.2, -1, 1.8), (0.5, 0.2, 0.9), (0.3, 0.6, 1))],
         {"camera": view(focal=(0.5, 0.5)), "silent": [KHRONOS]}),
        ("mean-off-screen", "Means outside the image, up to 1.7 half images from its middle, whose splats reach in.",
         [gaussian((2 * x, 2 * y, 4), 0.55, colour, 0.9) for x, y, colour in (
             (1.15, 0.2, RED), (-1.35, -0.3, GREEN), (0.3, 1.5, BLUE), (-0.2, -1.7, ORANGE))], {}),
        ("huge", "A splat larger than the image, and one around the camera.",
         [gaussian((0.3, 0.2, 1.5), 1.5, (0.2, 0.5, 1), 0.5),
          gaussian((0.1, 0.03, 0.5), (3, 0.15, 0.2), (1, 0.5, 0.2), 0.4)], {}),
        ("needle-ahead", "Needles that point at the camera, and past it.",
         [gaussian((0.9, 0.5, 3), (0.05, 0.05, 1), WHITE), gaussian((-0.9, -0.5, 3), (0.05, 0.3, 0.8), (0.4, 0.8, 1)),
          gaussian((0.05, -0.02, 3), (0.05, 0.05, 1.4), ORANGE)], {"camera": view(focal=(0.7, 0.7))}),
        ("background", "A background, of which each pixel shows what its splats let through.",
         [gaussian((-0.4, 0.1, 4), 0.35, RED, 0.7), gaussian((0.5, -0.1, 5), 0.4, (0.1, 0.1, 0.1), 0.9)],
         {"background": [0.25, 0.5, 0.75], "silent": [KHRONOS]}),
        ("srgb-blending", "Colours are blended in the values that displays take.",
         [gaussian((-0.2, 0.1, 4), 0.35, (0.9, 0.2, 0.1), 0.6), gaussian((0.2, 0.1, 5), 0.45, (0.1, 0.8, 0.3), 0.7),
          gaussian((0.1, -0.5, 6), 0.5, (0.2, 0.3, 0.9), 0.8)], {}),
        ("linear", "A file that says that its colours are linear light: pixels are encoded when they are finished.",
         [gaussian((-0.2, 0.1, 4), 0.35, (0.9, 0.2, 0.1), 0.6), gaussian((0.2, 0.1, 5), 0.45, (0.1, 0.8, 0.3), 0.7),
          gaussian((0.1, -0.5, 6), 0.5, (0.2, 0.3, 0.9), 0.8)],
         {"colours": "linear", "silent": [INRIA, GSPLAT]}),
        ("alone", "One Gaussian and nothing else in the file.", [gaussian((0.1, 0.1, 4), 0.3, ORANGE, 0.8)],
         {"padded": False}),
        ("none", "A file without Gaussians: the image is the background.", [],
         {"padded": False, "background": [0.25, 0.5, 0.75], "silent": [INRIA, GSPLAT, KHRONOS]}),
        ("mirrored", "A camera of determinant -1 shows the mirrored world.",
         [gaussian((0.5, -0.3, 4), long, ORANGE, 0.9, skew), gaussian((-0.8, 0.7, 5), 0.3, BLUE)],
         {"camera": view(mirrored=True), "silent": [INRIA, GSPLAT, KHRONOS]}),
    ]
