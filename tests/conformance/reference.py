# SPDX-License-Identifier: Apache-2.0
"""A renderer of Gaussian splats in float64 that is short enough to be read: the second implementation of the set.

`render` follows docs/conventions.md, `read_scene` and `read_camera` the formats of the set's files. Python and NumPy
are all that it needs.
"""
import json
import struct

import numpy as np

GSPLAT = {"near_plane": 0.01, "cull_at_near": False, "far_plane": 1e10, "clamp": "around_image", "alpha_min": 1 / 255,
          "alpha_max": 0.99, "stop": 1e-4, "stop_at_equal": True, "footprint": "alpha", "min_compensation": 2.5e-5}
PRESETS = {
    "gsplat": GSPLAT,
    "inria": {**GSPLAT, "near_plane": 0.2, "cull_at_near": True, "far_plane": np.inf, "clamp": "around_centre",
              "stop_at_equal": False, "footprint": "three_sigma_square"},
    "khronos": {**GSPLAT, "order": "distance", "alpha_min": 2**-24, "alpha_max": 1.0, "stop": 0.0,
                "stop_at_equal": False, "footprint": "three_sigma_ellipse"}}
# Not conventions but departures that renderers show, and `is_left_out` and `falloff` describe.
DEPARTURES = {"most_colour": np.inf, "most_off_screen": np.inf, "least_pixels": 0.0, "leaves_out_level": False,
              "falls_to_0": False, "most_degree": 3}
SIGMAS = {"three_sigma_ellipse": 3.0, "root_eight_ellipse": 8**0.5}


def render(scene, camera, conventions, background=(0, 0, 0)):
    """RGBA @shape{height, width, 4}, premultiplied, colours with the background added, and most layers of a pixel."""
    c = {**DEPARTURES, "blur": 0.3, "antialiased": False, "order": "depth", "colours": "srgb", **scene["model"],
         **conventions}
    c = {name: float(np.float32(value)) if isinstance(value, float) else value for name, value in c.items()}
    size, f, centre, rotation = (camera[name] for name in ("size", "focal", "centre", "rotation"))
    directions = scene["means"] - camera["position"]
    p = directions @ rotation.T  # rows are the camera's axes in the world
    depth = p[:, 2].astype(np.float32)
    drawn = (depth > c["near_plane"] if c["cull_at_near"] else depth >= c["near_plane"]) & (depth <= c["far_plane"])
    order = {"depth": depth, "distance": np.linalg.norm(p, axis=1).astype(np.float32), "first": np.arange(len(p)), "last": -np.arange(len(p))}
    sh = scene["sh"][:, :(c["most_degree"] + 1) ** 2]
    colours = np.einsum("nk,nkc->nc", harmonics(directions, sh.shape[1]), sh) + 0.5
    colours = np.clip(colours, 0, c["most_colour"])
    colours = decoded(colours) if c["colours"] == "decoded" else colours
    half = 0.5 * size / f  # tangents
    least, most = {"around_image": (-centre / f - 0.3 * half, (size - centre) / f + 0.3 * half),
                   "around_centre": (-1.3 * half, 1.3 * half), "none": (-np.inf, np.inf)}[c["clamp"]]
    y, x = np.mgrid[0:size[1], 0:size[0]] + 0.5
    rgb, left, stopped, layers = np.zeros((*x.shape, 3)), np.ones_like(x), x < 0, np.zeros_like(x, int)
    for i in np.argsort(order[c["order"]], kind="stable"):
        if not drawn[i]:
            continue
        tangent = p[i, :2] / p[i, 2]
        mean = f * tangent + centre
        jacobian = np.column_stack([np.diag(f), -f * np.clip(tangent, least, most)]) / p[i, 2]
        axes = jacobian @ rotation @ rotation_of(scene["rotations"][i]) * scene["scales"][i]
        sharp = axes @ axes.T
        cov = sharp + c["blur"] * np.eye(2)
        if is_left_out(c, 2 * mean / size - 1, cov):
            continue
        det, opacity, dx, dy = np.linalg.det(cov), scene["opacities"][i], x - mean[0], y - mean[1]
        if c["antialiased"]:
            opacity *= np.sqrt(max(c["min_compensation"], np.linalg.det(sharp) / det))
        square = (cov[1, 1] * dx * dx - 2 * cov[0, 1] * dx * dy + cov[0, 0] * dy * dy) / det
        alpha = np.minimum(c["alpha_max"], opacity * falloff(c, square))
        kept = (alpha >= c["alpha_min"]) & ~stopped & (square <= SIGMAS.get(c["footprint"], np.inf) ** 2)
        if c["footprint"] == "three_sigma_square":
            kept &= in_inria_square(x - 0.5, mean[0] - 0.5, cov) & in_inria_square(y - 0.5, mean[1] - 0.5, cov)
        behind = left * (1 - alpha)
        ends = kept & (behind <= c["stop"] if c["stop_at_equal"] else behind < c["stop"])
        stopped, kept = stopped | ends, kept & ~ends
        rgb += np.where(kept, alpha * left, 0)[..., None] * colours[i]
        left, layers = np.where(kept, behind, left), layers + kept
    linear = c["colours"] != "srgb"
    rgb += left[..., None] * (decoded(np.array(background)) if linear else np.array(background))
    return np.dstack([encoded(rgb) if linear else rgb, 1 - left]), int(layers.max())


def is_left_out(c, mean, cov):
    """Whether departures leave out a splat: its mean is more half images off the middle, its three standard deviations
    are fewer pixels across, or it lies level in the image."""
    return (np.any(np.abs(mean) > c["most_off_screen"]) or 6 * np.sqrt(cov.max()) < c["least_pixels"]
            or c["leaves_out_level"] and abs(cov[0, 1]) < 1e-9 and cov[0, 0] >= cov[1, 1])


def falloff(c, square):
    """The Gaussian, or one that reaches 0 at the root of 8 standard deviations."""
    edge = np.exp(-4) if c["falls_to_0"] else 0
    return (np.exp(-square / 2) - edge) / (1 - edge)


def in_inria_square(pixel, mean, cov):
    """Which pixels lie along one axis in the 16x16 tiles that INRIA's square of three standard deviations selects."""
    middle = (cov[0, 0] + cov[1, 1]) / 2
    radius = np.ceil(3 * np.sqrt(middle + np.sqrt(max(0.1, middle**2 - np.linalg.det(cov)))))
    first, last = np.trunc((mean - radius) / 16), np.trunc((mean + radius + 15) / 16)
    return (pixel >= 16 * max(0, first)) & (pixel < 16 * max(0, last))


def rotation_of(quaternion):
    """The matrix of (w, x, y, z), as it is stored: of a float that is no exact rotation too."""
    w, x, y, z = quaternion
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def harmonics(directions, count):
    """The first `count` real spherical harmonics of each direction, with the signs of the method's authors."""
    x, y, z = (directions / np.linalg.norm(directions, axis=1, keepdims=True)).T
    xx, yy, zz = x * x, y * y, z * z
    c = [np.sqrt(n / np.pi) / d for n, d in ((1, 2), (3, 2), (15, 2), (5, 4), (15, 4), (17.5, 4), (105, 2), (10.5, 4),
                                             (7, 4), (105, 4))]
    return np.stack([
        c[0] + 0 * x, -c[1] * y, c[1] * z, -c[1] * x,
        c[2] * x * y, -c[2] * y * z, c[3] * (2 * zz - xx - yy), -c[2] * x * z, c[4] * (xx - yy),
        -c[5] * y * (3 * xx - yy), c[6] * x * y * z, -c[7] * y * (4 * zz - xx - yy),
        c[8] * z * (2 * zz - 3 * xx - 3 * yy), -c[7] * x * (4 * zz - xx - yy), c[9] * z * (xx - yy),
        -c[5] * x * (xx - 3 * yy)][:count], axis=1)


def encoded(light):
    """The curve of sRGB, which values above 1 continue."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055)


def decoded(value):
    return np.where(value <= 0.04045, value / 12.92, ((np.maximum(value, 0.04045) + 0.055) / 1.055) ** 2.4)


def read_camera(path):
    """The only camera of INRIA's cameras.json."""
    with open(path, encoding="utf-8") as file:
        (camera,) = json.load(file)
    return {"size": np.array([camera["width"], camera["height"]]), "focal": np.array([camera["fx"], camera["fy"]]),
            "centre": np.array([camera["cx"], camera["cy"]]), "position": np.array(camera["position"], float),
            "rotation": np.array(camera["rotation"], float).T}


def read_scene(path):
    """A scene's arrays in float64, with the floats that trainers make of what is stored, and its rendering model."""
    scene = (read_glb if str(path).endswith(".glb") else read_ply)(path)
    lengths = np.linalg.norm(scene["rotations"], axis=1, keepdims=True)
    scene["rotations"] = (scene["rotations"] / lengths).astype(np.float32)
    return {name: value if name == "model" else value.astype(float) for name, value in scene.items()}


def read_ply(path):
    with open(path, "rb") as file:
        header, _, data = file.read().partition(b"end_header\n")
    lines = header.decode().splitlines()
    names = [line.split()[-1] for line in lines if line.startswith("property float ")]
    rows = np.frombuffer(data, "<f4").reshape(-1, len(names))

    def columns(*wanted):
        return rows[:, [names.index(name) for name in wanted]]
    rest = sum(name.startswith("f_rest_") for name in names)
    sh = columns(*[f"f_dc_{k}" for k in range(3)], *[f"f_rest_{k}" for k in range(rest)])
    sh = np.concatenate([sh[:, None, :3], sh[:, 3:].reshape(len(rows), 3, rest // 3).swapaxes(1, 2)], axis=1)
    exp_logits = np.exp(-columns("opacity")[:, 0].astype(float)).astype(np.float32)
    return {"means": columns("x", "y", "z"), "sh": sh, "opacities": np.float32(1) / (1 + exp_logits),
            "scales": np.exp(columns("scale_0", "scale_1", "scale_2").astype(float)).astype(np.float32),
            "rotations": columns("rot_0", "rot_1", "rot_2", "rot_3").astype(float),
            "model": {"antialiased": True} if "comment SplatRenderMode: mip" in lines else {}}


def read_glb(path):
    """Gaussians of degree 0; glTF's x points left and its y up."""
    with open(path, "rb") as file:
        data = file.read()
    size = struct.unpack_from("<I", data, 12)[0]
    gltf, (primitive,) = json.loads(data[20:20 + size]), json.loads(data[20:20 + size])["meshes"][0]["primitives"]

    def attribute(name):
        accessor = gltf["accessors"][primitive["attributes"][name]]
        view = gltf["bufferViews"][accessor["bufferView"]]
        begin = 28 + size + view["byteOffset"]
        return np.frombuffer(data[begin:begin + view["byteLength"]], "<f4").reshape(accessor["count"], -1)
    khr = "KHR_gaussian_splatting"
    rotations = attribute(f"{khr}:ROTATION").astype(float)
    x, y, z, w = rotations.T  # turned by half a turn about z
    said = primitive["extensions"][khr]
    return {"means": attribute("POSITION") * [-1, -1, 1], "sh": attribute(f"{khr}:SH_DEGREE_0_COEF_0")[:, None],
            "opacities": attribute(f"{khr}:OPACITY")[:, 0], "scales": attribute(f"{khr}:SCALE"),
            "rotations": np.stack([-z, -y, x, w], axis=1),
            "model": {"order": "distance", "colours": "linear" if said["colorSpace"].startswith("lin") else "srgb"}}
