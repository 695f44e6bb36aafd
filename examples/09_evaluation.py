# SPDX-License-Identifier: Apache-2.0
"""The evaluation of a training loop: PSNR over the photographs that were held out, in batches of views.

    python3 09_evaluation.py fox/           the capture's scene, as a trained model
    python3 09_evaluation.py fox/ --worst worst.png

A trainer has its parameters in tensors, as they are before activation. `set_gaussians` takes them as they are: on a GPU
tensors of PyTorch go to the renderer within the device.
"""
import argparse
import itertools
import pathlib

import numpy as np

import swiftgs


def as_parameters(scene):
    """What a trainer would hold of this scene: scales in logarithms, opacities before the sigmoid."""
    opacities = np.clip(scene.opacities, 1e-6, 1 - 1e-6)
    return {"means": scene.means, "scales": np.log(np.maximum(scene.scales, 1e-20)), "rotations": scene.rotations,
            "opacities": np.log(opacities / (1 - opacities)), "sh0": scene.sh0, "sh_rest": scene.sh_rest}


def psnr(image, photograph):
    return -10 * np.log10(np.mean((np.clip(image, 0, 1) - photograph) ** 2, dtype=np.float64))


def batches(items, size):
    items = iter(items)
    return iter(lambda: list(itertools.islice(items, size)), [])


def evaluate(renderer, parameters, held_out, photographs, rules, batch):
    """(PSNR, name, image) of each view."""
    renderer.set_gaussians(**parameters, log_scales=True, logit_opacities=True)
    results = []
    for cameras in batches(held_out, batch):
        frame = renderer.render(cameras, conventions=rules)  # one frame of several views
        for camera, image in zip(cameras, frame.colour):
            results.append((psnr(image, photographs[camera.name]), camera.name, image))
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("capture", type=pathlib.Path, help="a folder with a scene, its cameras and photos/")
    parser.add_argument("--batch", type=int, default=4, help="views of a frame")
    parser.add_argument("--worst", type=pathlib.Path, help="where to put the worst view beside its photograph")
    arguments = parser.parse_args()

    scene, cameras = swiftgs.load(arguments.capture), swiftgs.load_cameras(arguments.capture)
    found = {path.name: path for path in sorted((arguments.capture / "photos").iterdir())}
    held_out = [camera.relative_to(scene.origin) for camera in cameras if camera.name in found]
    photographs = {camera.name: swiftgs.load_image(found[camera.name])[..., :3] for camera in held_out}
    if not held_out:
        raise SystemExit(f"{arguments.capture / 'photos'}: expected photographs with the names of cameras")
    rules = swiftgs.Conventions(blur=scene.model.blur, antialiased=scene.model.antialiased)

    with swiftgs.Renderer() as renderer:
        results = evaluate(renderer, as_parameters(scene), held_out, photographs, rules, arguments.batch)
        for decibels, name, _ in results:
            print(f"{name}  {decibels:6.2f} dB")
        print(f"mean of {len(results)} views  {np.mean([r[0] for r in results]):6.2f} dB, by {renderer.name}")
    if arguments.worst:
        _, name, image = min(results, key=lambda result: result[0])
        both = np.ascontiguousarray(np.concatenate([image, photographs[name]], axis=1))
        swiftgs.Frame(both).save(arguments.worst)


if __name__ == "__main__":
    main()
