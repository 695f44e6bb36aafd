# SPDX-License-Identifier: Apache-2.0

# %% [markdown]
# # What is in a scene
#
# Cells of a notebook: an editor that knows percent cells runs them one by one, and `python3 10_notebook.py` all. Set
# SCENE to a file or the folder of a capture; without one it is the built-in scene.

# %%
import os

import numpy as np

import swiftgs

PATH = os.environ.get("SCENE")
scene = swiftgs.load(PATH) if PATH else swiftgs.Scene.builtin(50_000)
camera = swiftgs.load_cameras(PATH)[0].scaled(0.5) if PATH and os.path.isdir(PATH) else swiftgs.Camera.builtin(640, 360)
camera = camera.relative_to(scene.origin)  # which is other than 0 in scenes far from the world's zero
print(scene, camera, sep="\n")

# %% [markdown]
# The scene's arrays are its own memory, without a copy.

# %%
print("opacities:", np.percentile(scene.opacities, (5, 25, 50, 75, 95)).round(3))
print("largest side over smallest:", np.median(scene.scales.max(1) / np.maximum(scene.scales.min(1), 1e-12)).round(1))

# %% [markdown]
# One frame, with depth. What was measured comes with it.

# %%
renderer = swiftgs.Renderer(scene=scene)
frame = renderer.render(camera, alpha=True, depth=True, times=True, counts=True)
print(renderer.times, renderer.statistics, sep="\n")

# %% [markdown]
# Depth as a picture: near is bright.

# %%
nearness = 1 / np.maximum(frame.depth, 1e-6)
low, high = np.percentile(nearness[frame.alpha > 0.5], (2, 98))
brightness = np.clip((nearness - low) / max(high - low, 1e-9), 0, 1) * frame.alpha
depth_image = np.repeat(brightness[..., None], 3, axis=2).astype(np.float32)

# %% [markdown]
# The same scene without its faint half, and how far that is from the whole one.

# %%
strong = scene.opacities >= np.median(scene.opacities)
renderer.set_gaussians(*(array[strong] for array in (scene.means, scene.scales, scene.rotations, scene.opacities,
                                                     scene.sh0, scene.sh_rest)), model=scene.model)
half = renderer.render(camera)
error = np.mean((half.colour - frame.colour) ** 2, dtype=np.float64)
print(f"{strong.sum():,} of {len(scene):,} Gaussians: {-10 * np.log10(error):.1f} dB from all of them")

# %% [markdown]
# Side by side: the image, its depth, and what is left of it.

# %%
together = np.concatenate([frame.colour, depth_image, half.colour], axis=1)
swiftgs.Frame(together).save("notebook.png")
print("notebook.png")
