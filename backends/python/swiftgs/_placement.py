# SPDX-License-Identifier: Apache-2.0
"""Placed scenes: where scenes stand in a frame, and what of them shows."""
import dataclasses
import math
import operator
from typing import Any, NamedTuple, Optional

import numpy as np

from . import _arrays, _c

_MAX_HALF_SPACES = 6
_SAME = 1e-4  # what matrices of single precision keep to


def _floats(value: Any, shape: Any, what: str) -> np.ndarray:
    try:
        found = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{what} is {value!r}, expected numbers") from None
    if found.shape != shape:
        raise ValueError(f"{what} has the shape {found.shape}, expected {shape}")
    if not np.isfinite(found).all():
        raise ValueError(f"{what} is {found.tolist()}, expected finite numbers")
    return found


@dataclasses.dataclass(frozen=True, eq=False)
class Clip:
    """Which Gaussians of a scene show: those whose means lie in all half-spaces and in the sphere. It is in the scene's
    own space, and moves with it."""

    half_spaces: Any = ()  #: [0 to 6, 4], x, y, z, w each: points p with (x, y, z) . p + w >= 0
    centre: Any = (0, 0, 0)  #: of the sphere
    radius: float = math.inf  #: above 0; infinite: no sphere

    @classmethod
    def box(cls, low: Any, high: Any) -> "Clip":
        """From the least to the greatest coordinates."""
        low, high = _floats(low, (3,), "low"), _floats(high, (3,), "high")
        return cls(np.vstack([np.column_stack([np.eye(3), -low]), np.column_stack([-np.eye(3), high])]))

    @classmethod
    def sphere(cls, centre: Any, radius: float) -> "Clip":
        """Around a point."""
        return cls(centre=centre, radius=radius)

    def _fill(self, struct: Any) -> None:
        count = len(self.half_spaces)
        if count > _MAX_HALF_SPACES:
            raise ValueError(f"half_spaces are {count}, expected {_MAX_HALF_SPACES} at most")
        if count:
            found = _floats(self.half_spaces, (count, 4), "half_spaces")
            struct.half_space_count, struct.half_spaces[:4 * count] = count, found.ravel().tolist()
        if not self.radius > 0:
            raise ValueError(f"radius is {self.radius}, expected more than 0")
        struct.centre[:] = _floats(self.centre, (3,), "centre").tolist()
        struct.radius = 0 if self.radius == math.inf else self.radius


@dataclasses.dataclass(frozen=True, eq=False)
class Tint:
    """A colour that is mixed into those of a scene's Gaussians, such as a highlight."""

    colour: Any = (1, 1, 1)  #: RGB, in the scene's own values, 0 or more
    amount: float = 0  #: 0 to 1: 0 leaves the Gaussians' colours, 1 shows `colour` in their place

    def _fill(self, struct: Any) -> None:
        colour = _floats(self.colour, (3,), "colour")
        if not (colour >= 0).all():
            raise ValueError(f"colour is {colour.tolist()}, expected 0 or more")
        if not 0 <= self.amount <= 1:
            raise ValueError(f"amount is {self.amount}, expected 0 to 1")
        struct.tint[:], struct.tint_amount = colour.tolist(), float(self.amount)


@dataclasses.dataclass(frozen=True, eq=False)
class Placement:
    """How a frame shows one of a renderer's scenes, or a range of its Gaussians.

    >>> where = np.eye(4)
    >>> where[:3, 3] = 0, 0, 2
    >>> renderer.place([Placement(), Placement(renderer.add_scene(chair), where)])
    """

    scene: int = 0  #: its number, as `Renderer.add_scene` returns it
    #: [4, 4], a rotation times one scale, and a translation; None: where the scene stands by itself. Add a scene's
    #: origin to the translation.
    world_from_scene: Any = None
    opacity: float = 1  #: what the opacities of its Gaussians are multiplied by, 0 to 1
    clip: Clip = Clip()  #: by default all shows
    first: int = 0  #: number of the first Gaussian that shows; multiples of 128 are drawn fastest
    count: Optional[int] = None  #: how many Gaussians show, 1 or more; None: all from `first` on
    tint: Tint = Tint()  #: by default colours stay as they are

    def _struct(self) -> Any:
        scene = operator.index(self.scene)
        if scene < 0:
            raise ValueError(f"scene is number {scene}, expected 0 or more")
        if not 0 <= self.opacity <= 1:
            raise ValueError(f"opacity is {self.opacity}, expected 0 to 1")
        if not isinstance(self.clip, Clip):
            raise TypeError(f"clip is of type {type(self.clip).__name__}, expected swiftgs.Clip")
        if not isinstance(self.tint, Tint):
            raise TypeError(f"tint is of type {type(self.tint).__name__}, expected swiftgs.Tint")
        first, count = operator.index(self.first), 0 if self.count is None else operator.index(self.count)
        if first < 0 or count < (self.count is not None):
            raise ValueError(f"first is {first} and count is {self.count}, expected first of 0 or more and count of 1 "
                             "or more, or None")
        struct = _c.Placement(scene=scene, transparency=1 - float(self.opacity), first=first, count=count)
        self.clip._fill(struct)
        self.tint._fill(struct)
        if self.world_from_scene is not None:
            self._fill_pose(struct)
        return struct

    def _fill_pose(self, struct: Any) -> None:
        matrix = _floats(self.world_from_scene, (4, 4), "world_from_scene")
        if np.abs(matrix[3] - (0, 0, 0, 1)).max() > 0:
            raise ValueError(f"world_from_scene has the last row {matrix[3].tolist()}, expected [0, 0, 0, 1]")
        left, scales, right = np.linalg.svd(matrix[:3, :3])
        rotation, scale = left @ right, scales.mean()
        if not scales[0] - scales[2] <= _SAME * scales[0] or scale <= 0:
            raise ValueError(f"world_from_scene stretches scenes by {scales[2]:g} to {scales[0]:g}, expected a "
                             "rotation times one scale above 0")
        if np.linalg.det(rotation) < 0:
            raise ValueError("world_from_scene mirrors scenes, expected a rotation times one scale above 0")
        struct.rotation[:], struct.scale = rotation.ravel().tolist(), float(scale)
        struct.translation[:] = matrix[:3, 3].tolist()


class RecordedScenes(NamedTuple):
    """Numbers of the placed scenes that recorded frames show, where the renderer reads them: arrays of NumPy on the
    host, of `LentArray` on a device. Each is in the order of the placements."""

    rotations: Any  #: [N, 3, 3] in float64, scene to world: row, column; orthonormal
    scales: Any  #: [N] in float64, above 0
    translations: Any  #: [N, 3] in float64, world position of the scene's zero
    opacities: Any  #: [N] in float32, what opacities are multiplied by, 0 to 1
    tints: Any  #: [N, 4] in float32, RGB that is mixed into colours, 0 or more, and its amount, 0 to 1

    @classmethod
    def _of(cls, struct: Any, handle: _c.Handle, device: Optional[int], stream: int) -> "RecordedScenes":
        def lent(address: int, kind: str, shape: Any = (), strides: Any = ()) -> Any:
            array = _arrays.LentArray(handle, address, (struct.count, *shape), (struct.stride, *strides), kind, device,
                                      stream)
            return np.asarray(array) if device is None else array

        # Columns lie one after the other.
        return cls(lent(struct.rotation, "f8", (3, 3), (8, 24)), lent(struct.scale, "f8"),
                   lent(struct.translation, "f8", (3,), (8,)), lent(struct.opacity, "f4"),
                   lent(struct.tint, "f4", (4,), (4,)))
