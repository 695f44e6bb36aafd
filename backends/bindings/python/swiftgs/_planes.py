# SPDX-License-Identifier: Apache-2.0
"""Planes: arrays that hold images."""
import functools
from typing import Any, List, NamedTuple, Optional, Tuple

from . import _arrays, _dlpack
from ._c import PLANES
from ._errors import InvalidArgument, InvalidType
from ._gaussians import check_device


class _Format(NamedTuple):
    number: int
    kind: str
    channels: int


FORMATS = {"rgb": _Format(0, "f4", 3), "rgba": _Format(1, "f4", 4), "rgba-half": _Format(2, "f2", 4),
           "rgba8": _Format(3, "u1", 4)}


class _Layout(NamedTuple):
    """What a view says of a plane."""

    images: Tuple[int, ...]  # the shape without channels
    channels: int
    format: int  # of a plane of colour
    pitch: int  # bytes from a row to the next
    step: int  # bytes from an image to the next


class Plane(NamedTuple):
    name: str
    memory: _arrays.Memory
    layout: _Layout


def read_planes(**arrays: Any) -> List[Plane]:
    """Where they lie. Planes of one frame have images of one size on one device."""
    planes: List[Plane] = []
    for name, array in arrays.items():
        if array is None:
            continue
        if name != "occluder" and _arrays.library_of(array) == "jax":
            raise InvalidType(f"{name} is an array of JAX, which cannot be written to, expected one of PyTorch, CuPy "
                              "or NumPy, or a swiftgs.DeviceArray, which jax.dlpack.from_dlpack takes")
        memory = _arrays.read(array, name, None)  # a frame is ordered when it is drawn
        if name != "occluder" and not memory.writable:
            raise InvalidArgument(f"{name} is read-only, expected memory to write to")
        images = planes[0].layout.images if planes else None
        layout = _layout_of(name, memory.kind, memory.shape, memory.strides, images)
        if memory.address % int(memory.kind[1:]):
            raise InvalidArgument(f"{name} begins at the address {memory.address}, expected multiples of "
                                  f"{memory.kind[1:]}")
        if not planes:
            check_device(memory.device, name)
        elif layout.images != images:
            raise InvalidArgument(f"{name} has images of the shape {layout.images}, expected {images}, that of the "
                                  "other planes")
        elif memory.device != planes[0].memory.device:
            raise InvalidArgument(f"{name} lies on {memory.place}, expected all planes on one")
        planes.append(Plane(name, memory, layout))
    if not planes:
        raise InvalidArgument(f"a frame without planes, expected one of colour, {', '.join(PLANES)}")
    return planes


@functools.lru_cache(maxsize=256)
def _layout_of(name: str, kind: str, shape: Tuple[int, ...], strides: Tuple[int, ...],
               expected: Optional[Tuple[int, ...]]) -> _Layout:
    """Of a plane beside others whose images have the shape `expected`."""
    if name == "colour":
        formats = [f for f in FORMATS.values() if (f.kind, f.channels) == (kind, shape[-1] if shape else 0)]
        if len(shape) not in (3, 4) or not formats:
            raise InvalidArgument(f"colour has the shape {shape} of type {kind}, expected ([C,] H, W, 3) of f4, or "
                                  "([C,] H, W, 4) of f4, f2 or u1")
        chosen, images = formats[0], shape[:-1]
    else:
        plane = PLANES["depth" if name == "occluder" else name]
        if plane.channels == 1:
            images = shape[:-1] if len(shape) in (3, 4) and shape[-1] == 1 and shape != expected else shape
            chosen, shapes = _Format(0, kind, 1), "([C,] H, W) or ([C,] H, W, 1)"
        else:
            images = shape[:-1]
            chosen, shapes = _Format(0, kind, shape[-1] if shape else 0), f"([C,] H, W, {plane.channels or 'F'})"
        if len(images) not in (2, 3) or kind != plane.kind or plane.channels not in (None, chosen.channels):
            raise InvalidArgument(f"{name} has the shape {shape} of type {kind}, expected {shapes} of {plane.kind}")
    if not all(0 < side < 2**31 for side in (*images, chosen.channels)):
        raise InvalidArgument(f"{name} has the shape {shape}, expected no side of 0 and none of 2^31 or more")
    item = int(kind[1:])
    if any(stride % item for stride in strides):
        raise InvalidArgument(f"{name} has the strides {strides} bytes, expected multiples of {item}")
    rows, width = len(images) - 2, images[-1]
    pixels = _dlpack.dense_strides((width, chosen.channels), item)
    found = strides[rows + 1:rows + 2] + (strides[rows + 2:] or (item,))
    if any(side > 1 and stride != wanted for side, stride, wanted in zip((width, chosen.channels), found, pixels)):
        raise InvalidArgument(f"{name} has the strides {strides} bytes, expected pixels of a row side by side, "
                              f"{pixels} at the end")
    step = strides[0] if len(images) == 3 and images[0] > 1 else 0
    if step == 0 and len(images) == 3 and images[0] > 1 and name != "occluder":
        raise InvalidArgument(f"{name} has its {images[0]} images in one place, expected a place for each")
    pitch = strides[rows] if images[rows] > 1 else pixels[0] * width
    return _Layout(images, chosen.channels, chosen.number, pitch, step)
