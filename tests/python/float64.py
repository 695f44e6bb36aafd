# SPDX-License-Identifier: Apache-2.0
"""A plain renderer in float64 with the conventions of gsplat: what float renderers of these conventions approximate.

It is written from docs/conventions.md, apart from the library's own reference, and slow.
"""
import collections
import concurrent.futures
import os

import numpy as np

# What rounding alone changes of a pixel stays below this. More of it is a decision of float32 that falls out the other
# way: whether a splat reaches ALPHA_MIN, or transmittance STOP.
DECIDED = 1e-5

NEAR, BLUR, ALPHA_MIN, STOP, MARGIN, TILE = 0.01, 0.3, 1 / 255, 1e-4, 0.3, 16

# How renderers blend otherwise: the largest alpha, and whether the splat is drawn that takes transmittance below STOP.
Rules = collections.namedtuple("Rules", "alpha_max draws_last")
GSPLAT, UNCLAMPED = RULES = Rules(0.99, False), Rules(1, True)


def distance(found, wanted):
    """How far an image is from that of `render`: decibels, how many of its pixels decide otherwise, and decibels of
    the others, which tell how well a renderer rounds."""
    off = np.abs(np.asarray(found, np.float64) - wanted)
    otherwise = off.max(axis=-1) > DECIDED
    of_all, of_others = np.mean(off ** 2), np.mean(off[~otherwise] ** 2)
    return {"db": float(-10 * np.log10(of_all)), "otherwise": int(otherwise.sum()),
            "db_of_others": float(-10 * np.log10(of_others))}


def basis(d):
    """[N, 16] real harmonics of unit directions."""
    x, y, z = d.T
    xx, yy, zz = x * x, y * y, z * z
    return np.stack([
        np.full_like(x, 0.28209479177387814), -0.4886025119029199 * y, 0.4886025119029199 * z,
        -0.4886025119029199 * x, 1.0925484305920792 * x * y, -1.0925484305920792 * y * z,
        0.31539156525252005 * (2 * zz - xx - yy), -1.0925484305920792 * x * z, 0.5462742152960396 * (xx - yy),
        -0.5900435899266435 * y * (3 * xx - yy), 2.890611442640554 * x * y * z,
        -0.4570457994644658 * y * (4 * zz - xx - yy), 0.3731763325901154 * z * (2 * zz - 3 * xx - 3 * yy),
        -0.4570457994644658 * x * (4 * zz - xx - yy), 1.445305721320277 * z * (xx - yy),
        -0.5900435899266435 * x * (xx - 3 * yy)], axis=-1)


def seen_by(scene, turn, move):
    """What a camera sees: positions [N, 3] and half axes [N, 3, 3] in camera space, opacities and colours."""
    means, quats, scales, opacities, sh = (np.asarray(a, np.float64) for a in scene)
    at = means @ turn.T + move
    seen = (at[:, 2] >= NEAR) & (opacities >= ALPHA_MIN)
    quats, scales, opacities, sh, at = (a[seen] for a in (quats, scales, opacities, sh, at))

    w, x, y, z = (quats / np.linalg.norm(quats, axis=1, keepdims=True)).T
    rotation = np.stack([
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z),
        1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x),
        1 - 2 * (x * x + y * y)], axis=-1).reshape(-1, 3, 3)
    direction = at @ turn  # of the scene
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    colour = np.maximum((basis(direction)[:, :sh.shape[1], None] * sh).sum(axis=1) + 0.5, 0)
    return at, turn @ (rotation * scales[:, None, :]), opacities, colour


def render(means, quats, scales, opacities, sh, viewmat, K, width, height, rules=(GSPLAT,)):
    """[height, width, 3] in float64, on black, or one such image for each of several rules."""
    viewmat, K = (np.asarray(a, np.float64) for a in (viewmat, K))
    at, axes, opacities, colour = seen_by((means, quats, scales, opacities, sh), viewmat[:3, :3], viewmat[:3, 3])

    # Covariances in the image: J A A' J' of half axes A, with x/z and y/z cut where they lie far beside the image.
    fx, fy, cx, cy = K[0, 0], K[1, 1], K[0, 2], K[1, 2]
    depth = at[:, 2]
    cut = []
    for axis, focal, centre, side in ((0, fx, cx, width), (1, fy, cy, height)):
        beyond = MARGIN * 0.5 * side / focal
        cut.append(np.clip(at[:, axis] / depth, -centre / focal - beyond, (side - centre) / focal + beyond))
    zero = np.zeros_like(depth)
    jacobian = np.stack([fx / depth, zero, -fx * cut[0] / depth, zero, fy / depth, -fy * cut[1] / depth],
                        axis=-1).reshape(-1, 2, 3)
    half = jacobian @ axes
    a, b, c = (half[:, 0] ** 2).sum(1) + BLUR, (half[:, 0] * half[:, 1]).sum(1), (half[:, 1] ** 2).sum(1) + BLUR
    determinant = a * c - b * b
    centre = np.stack([fx * at[:, 0] / depth + cx, fy * at[:, 1] / depth + cy], axis=-1)

    order = np.argsort(depth.astype(np.float32), kind="stable")
    a, b, c, determinant, opacities, colour, centre = (
        each[order] for each in (a, b, c, determinant, opacities, colour, centre))
    reach = np.sqrt(2 * np.log(opacities / ALPHA_MIN))
    extent = np.stack([reach * np.sqrt(a), reach * np.sqrt(c)], axis=-1)

    def band(top):
        pixels = np.zeros((len(rules), min(TILE, height - top), width, 3))
        row = np.flatnonzero((centre[:, 1] + extent[:, 1] >= top) & (centre[:, 1] - extent[:, 1] <= top + TILE))
        for left in range(0, width, TILE):
            here = row[(centre[row, 0] + extent[row, 0] >= left) & (centre[row, 0] - extent[row, 0] <= left + TILE)]
            ys, xs = np.mgrid[top:min(top + TILE, height), left:min(left + TILE, width)] + 0.5
            dx, dy = xs.reshape(-1, 1) - centre[here, 0], ys.reshape(-1, 1) - centre[here, 1]
            sigma = (c[here] * dx * dx + a[here] * dy * dy - 2 * b[here] * dx * dy) / (2 * determinant[here])
            alpha = opacities[here] * np.exp(-sigma)
            alpha[alpha < ALPHA_MIN] = 0
            for image, (alpha_max, draws_last) in zip(pixels, rules):
                alphas = np.minimum(alpha_max, alpha)
                after = np.cumprod(1 - alphas, axis=1)
                before = np.concatenate([np.ones((len(after), 1)), after[:, :-1]], axis=1)
                drawn = before >= STOP if draws_last else after > STOP  # both fall, so that nothing comes behind
                image[:, left:left + TILE] = (np.where(drawn, alphas * before, 0) @ colour[here]).reshape(*xs.shape, 3)
        return pixels

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        images = np.concatenate(list(pool.map(band, range(0, height, TILE))), axis=1)
    return images if len(rules) > 1 else images[0]


def render_first(arguments, **options):
    """The first view of what `rasterization` is given: the same floats, so that rounding them is nobody's error."""
    names = ("means", "quats", "scales", "opacities", "colors", "viewmats", "Ks")
    means, quats, scales, opacities, sh, viewmats, matrices = (
        arguments[name].cpu().numpy() if hasattr(arguments[name], "cpu") else arguments[name] for name in names)
    return render(means, quats, scales, opacities, sh, viewmats[0], matrices[0], arguments["width"],
                  arguments["height"], **options)
