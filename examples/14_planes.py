# SPDX-License-Identifier: Apache-2.0
"""Shows all planes of a view as false colours: a folder of images, and planes.png with all of them.

    python3 14_planes.py                the built-in scene
    python3 14_planes.py garden/ --view 24
"""
import argparse
import pathlib

import numpy as np

import swiftgs


def grey(values):
    """Three equal channels."""
    return np.repeat(values.astype(np.float32)[..., None], 3, axis=2)


def near_is_bright(depths):
    """By the logarithm, between percentiles; black where there is none."""
    seen = depths > 0
    if not seen.any():
        return grey(depths)
    logarithms = np.log(np.where(seen, depths, 1))
    low, high = np.percentile(logarithms[seen], (2, 98))
    return grey(np.where(seen, 0.1 + 0.9 * np.clip((high - logarithms) / max(high - low, 1e-9), 0, 1), 0))


def coloured(ids):
    """A colour of its own for each Gaussian."""
    mixed = ids.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    channels = np.stack([(mixed >> np.uint64(shift)) & np.uint64(255) for shift in (24, 36, 48)], axis=2) / 255
    return np.where(ids[..., None] == swiftgs.NOTHING, 0, channels).astype(np.float32)


def pictures(scene, camera):
    """Every plane as an image, by name."""
    heights = scene.means @ -camera.rotation[1]  # any numbers will do: here how high a Gaussian lies
    low, high = np.percentile(heights, (5, 95))
    features = np.clip((heights - low) / (high - low), 0, 1).astype(np.float32)[:, None]
    scene = swiftgs.Scene.from_arrays(scene.means, scene.scales, scene.rotations, scene.opacities, scene.sh0,
                                      scene.sh_rest if scene.sh_degree else None, features=features)
    frame = swiftgs.Renderer(scene=scene).render(
        camera, alpha=True, depth=True, squared_depth=True, first_depth=True, median_depth=True, normal=True, id=True,
        median_id=True, features=1)
    spread = np.sqrt(np.maximum(frame.squared_depth - frame.depth ** 2, 0)) / np.maximum(frame.depth, 1e-9)
    return {"colour": frame.colour, "alpha": grey(frame.alpha), "depth": near_is_bright(frame.depth),
            "spread": grey(np.clip(spread, 0, 1)), "first_depth": near_is_bright(frame.first_depth),
            "median_depth": near_is_bright(frame.median_depth),
            "normal": (0.5 * frame.alpha[..., None] + 0.5 * frame.normal * [1, -1, -1]).astype(np.float32),
            "id": coloured(frame.id), "feature": grey(frame.features[..., 0])}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="?", help="a scene, or the folder of a capture [the built-in scene]")
    parser.add_argument("--view", type=int, default=0, help="number of the camera [0]")
    parser.add_argument("--width", type=int, default=640, help="of the images [640]")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("planes"), help="folder [planes]")
    options = parser.parse_args()
    scene = swiftgs.load(options.scene) if options.scene else swiftgs.Scene.builtin()
    camera = swiftgs.load_cameras(options.scene)[options.view] if options.scene else swiftgs.Camera.builtin()
    found = pictures(scene, camera.scaled(options.width / camera.width))
    options.out.mkdir(parents=True, exist_ok=True)
    for name, image in found.items():
        swiftgs.Frame(np.ascontiguousarray(image)).save(options.out / f"{name}.png")
    images = list(found.values())
    rows = [np.concatenate(images[k:k + 3], axis=1) for k in range(0, len(images), 3)]
    swiftgs.Frame(np.ascontiguousarray(np.concatenate(rows))).save(options.out / "planes.png")
    print(f"{options.out}: " + ", ".join(found))


if __name__ == "__main__":
    main()
