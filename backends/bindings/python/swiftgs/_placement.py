# SPDX-License-Identifier: Apache-2.0
"""Placed scenes: where scenes stand in a frame, and what of them shows."""
import dataclasses
import math
from typing import Any, NamedTuple, Optional

import numpy as np

from . import _arrays, _c, _checks
from ._errors import InvalidArgument

_MAX_HALF_SPACES = 6
_SAME = 1e-4  # what matrices of single precision keep to


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
        low, high = _checks.finite(low, "low", (3,)), _checks.finite(high, "high", (3,))
        return cls(np.vstack([np.column_stack([np.eye(3), -low]), np.column_stack([-np.eye(3), high])]))

    @classmethod
    def sphere(cls, centre: Any, radius: float) -> "Clip":
        """Around a point."""
        return cls(centre=centre, radius=radius)

    def _fill(self, struct: Any) -> None:
        count = len(_checks.listed(self.half_spaces, "half_spaces"))
        if count > _MAX_HALF_SPACES:
            raise InvalidArgument(f"half_spaces are {count}, expected {_MAX_HALF_SPACES} at most")
        if count:
            found = _checks.finite(self.half_spaces, "half_spaces", (count, 4))
            struct.half_space_count, struct.half_spaces[:4 * count] = count, found.ravel().tolist()
        radius = _checks.real(self.radius, "radius")
        if not radius > 0:
            raise InvalidArgument(f"radius is {radius:g}, expected more than 0")
        struct.centre[:] = _checks.finite(self.centre, "centre", (3,)).tolist()
        struct.radius = 0 if radius == math.inf else radius


@dataclasses.dataclass(frozen=True, eq=False)
class Tint:
    """A colour that is mixed into those of a scene's Gaussians, such as a highlight."""

    colour: Any = (1, 1, 1)  #: RGB, in the scene's own values, 0 or more
    amount: float = 0  #: 0 to 1: 0 leaves the Gaussians' colours, 1 shows `colour` in their place

    def _fill(self, struct: Any) -> None:
        colour, amount = _checks.finite(self.colour, "colour", (3,)), _checks.real(self.amount, "amount")
        if not (colour >= 0).all():
            raise InvalidArgument(f"colour is {colour.tolist()}, expected 0 or more")
        if not 0 <= amount <= 1:
            raise InvalidArgument(f"amount is {amount}, expected 0 to 1")
        struct.tint[:], struct.tint_amount = colour.tolist(), amount


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
        opacity = _checks.real(self.opacity, "opacity")
        if not 0 <= opacity <= 1:
            raise InvalidArgument(f"opacity is {opacity}, expected 0 to 1")
        _checks.of_type(self.clip, Clip, "clip")
        _checks.of_type(self.tint, Tint, "tint")
        struct = _c.Placement(scene=_checks.whole(self.scene, "scene", 0, 2**64), transparency=1 - opacity,
                              first=_checks.whole(self.first, "first", 0, 2**64),
                              count=0 if self.count is None else _checks.whole(self.count, "count", 1, 2**64))
        self.clip._fill(struct)
        self.tint._fill(struct)
        if self.world_from_scene is not None:
            self._fill_pose(struct)
        return struct

    def _fill_pose(self, struct: Any) -> None:
        matrix = _checks.finite(self.world_from_scene, "world_from_scene", (4, 4))
        if np.abs(matrix[3] - (0, 0, 0, 1)).max() > 0:
            raise InvalidArgument(f"world_from_scene has the last row {matrix[3].tolist()}, expected [0, 0, 0, 1]")
        left, scales, right = np.linalg.svd(matrix[:3, :3])
        rotation, scale = left @ right, scales.mean()
        if not scales[0] - scales[2] <= _SAME * scales[0] or scale <= 0:
            raise InvalidArgument(f"world_from_scene stretches scenes by {scales[2]:g} to {scales[0]:g}, expected a "
                                  "rotation times one scale above 0")
        if np.linalg.det(rotation) < 0:
            raise InvalidArgument("world_from_scene mirrors scenes, expected a rotation times one scale above 0")
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
