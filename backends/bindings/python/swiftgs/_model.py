# SPDX-License-Identifier: Apache-2.0
"""How scenes were trained to be drawn."""
import dataclasses
from typing import Any

import numpy as np

from . import _c, _checks
from ._errors import InvalidArgument


@dataclasses.dataclass(frozen=True)
class RenderingModel:
    """How a scene was trained to be drawn. Frames follow it wherever `Conventions` leave it to the scene."""

    blur: float = 0.3  #: added to both variances of a splat, in square pixels
    antialiased: bool = False  #: opacity is scaled as Mip-Splatting does
    order: str = "depth"  #: or "distance": what orders splats
    colours: str = "srgb"  #: or "linear": in which values splats are blended
    kernel: str = "ellipsoid"  #: or "disk": 2D Gaussians, which are drawn as flat 3D ones

    @classmethod
    def _of(cls, struct: Any) -> "RenderingModel":
        # The decimals of the float that C has.
        return cls(float(str(np.float32(struct.blur))), bool(struct.antialiased), _c.ORDERS[struct.order], _c.COLOURS[struct.colours],
                   _c.KERNELS[struct.kernel])

    def _fill(self, struct: Any) -> None:
        blur = _checks.real(self.blur, "model: blur")
        if not blur >= 0:
            raise InvalidArgument(f"model: blur is {blur}, expected 0 or more")
        struct.blur = blur if blur != 0 else -1.0  # in C, 0 stands for the usual blur
        struct.antialiased = _checks.choice(self.antialiased, "model: antialiased", (False, True))
        struct.order = _checks.choice(self.order, "model: order", _c.ORDERS)
        struct.colours = _checks.choice(self.colours, "model: colours", _c.COLOURS)
        struct.kernel = _checks.choice(self.kernel, "model: kernel", _c.KERNELS)
