# SPDX-License-Identifier: Apache-2.0
"""Frames: memory of images, and the rules that they are drawn by."""
import ctypes
import os
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from . import _arrays, _c, _dlpack
from ._c import Handle, OwnedFloats, lib
from ._camera import Camera, Conventions, check_cameras, conventions_of
from ._gaussians import check_device


class _Format(NamedTuple):
    number: int
    kind: str
    channels: int


FORMATS = {"rgb": _Format(0, "f4", 3), "rgba": _Format(1, "f4", 4), "rgba-half": _Format(2, "f2", 4),
           "rgba8": _Format(3, "u1", 4)}
_VIEW, _CAMERA = np.dtype(_c.View), np.dtype(_c.Camera)


class Frame:
    """Where one image goes, or a batch of images of one size, and how it is drawn.

    `Renderer.render` makes one and returns it. Make one yourself to draw into your own arrays, or into the same memory
    again and again: `renderer.render(camera, out=frame)`. An array of any library will do, on the host or on a device;
    no pixel is copied.

    colour [H, W, 3 or 4] or [C, H, W, 3 or 4]: float32 RGB, or RGBA in float32, float16 or uint8, where colours are
    premultiplied by alpha. alpha, depth [(C,) H, W] or [(C,) H, W, 1]: float32. Pixels of a row lie side by side; rows
    may have gaps and go up. Depth is the mean z of what contributed, 0 where nothing did.
    """

    def __init__(self, colour: Any = None, alpha: Any = None, depth: Any = None, *, occluder: Any = None,
                 over: bool = False, background: Any = (0, 0, 0), conventions: Union[str, Conventions] = "gsplat",
                 first_pixel: Optional[Tuple[int, int]] = None) -> None:
        """`occluder` is a depth buffer, only read: a splat at its depth or behind is not drawn. `over` keeps what
        `colour` holds behind the splats, in place of `background` [3] or [C, 3]. With `first_pixel` the frame is a
        part of the camera's image, which begins with that column and row, multiples of 16."""
        self.colour, self.alpha, self.depth = colour, alpha, depth
        planes = {name: array for name, array in
                  (("colour", colour), ("alpha", alpha), ("depth", depth), ("occluder", occluder)) if array is not None}
        if not planes:
            raise ValueError("a frame without planes, expected colour, alpha or depth")
        images: Optional[Tuple[int, ...]] = None
        self._views: Any = None
        self._memory: List[_arrays.Memory] = []
        # One array of each library tells of its stream; each DeviceArray has its own.
        self._sources = list({array if isinstance(array, _arrays.DeviceArray) else _arrays.library_of(array): array
                              for array in planes.values()}.values())
        for name, array in planes.items():
            if name != "occluder" and _arrays.library_of(array) == "jax":
                raise TypeError(f"{name} is an array of JAX, which cannot be written to, expected one of PyTorch, CuPy "
                                "or NumPy, or a swiftgs.DeviceArray, which jax.dlpack.from_dlpack takes")
            memory = _arrays.read(array, name, None)  # a frame is ordered when it is drawn
            if name != "occluder" and not memory.writable:
                raise ValueError(f"{name} is read-only, expected memory to write to")
            shape, channels = _split(name, memory, images)
            if images is None:
                images = shape
                self._views = np.zeros(shape[0] if len(shape) == 3 else 1, _VIEW)
                self.device = memory.device
                check_device(self.device, name)
            if shape != images:
                raise ValueError(f"{name} has images of the shape {shape}, expected {images}, that of the other planes")
            if memory.device != self.device:
                raise ValueError(f"{name} lies on {memory.place}, expected all planes on one")
            self._memory.append(memory)
            self._add(name, memory, channels, len(images) == 3)
        assert images is not None
        self.batched = len(images) == 3  #: whether the arrays have an index of the image first
        self.height, self.width = images[-2:]
        views = self._views
        views["size"], views["width"], views["height"] = _VIEW.itemsize, self.width, self.height
        self._is_part = first_pixel is not None
        views["over"], (views["left"], views["top"]) = over, first_pixel or (0, 0)
        self._conventions = conventions_of(conventions)
        views["conventions"] = ctypes.addressof(self._conventions)
        self.background = background
        self._struct = _c.Frame(views=views.ctypes.data, count=len(views))
        self._argument = ctypes.c_void_p(ctypes.addressof(self._struct))
        self._measure = 0
        self._cameras = np.zeros(len(views), _CAMERA)  # copies, so that a camera may go while a frame is drawn
        self._camera_bytes = self._cameras.view(np.uint8).data
        views["camera"] = self._cameras.ctypes.data + np.arange(len(views)) * _CAMERA.itemsize
        # Of the one camera that is copied without another look; none in frames of parts or batches.
        self._one_size = (self.width, self.height) if len(views) == 1 and not self._is_part else None

    def _add(self, name: str, memory: _arrays.Memory, channels: int, batched: bool) -> None:
        pixel = int(memory.kind[1:]) * channels
        rows = memory.strides[int(batched)] if memory.shape[int(batched)] > 1 else pixel * memory.shape[batched + 1]
        if name == "colour":
            self._views["format"] = next(f.number for f in FORMATS.values() if f[1:] == (memory.kind, channels))
        first = memory.strides[0] if batched and memory.shape[0] > 1 else 0
        if first == 0 and len(self._views) > 1 and name != "occluder":
            raise ValueError(f"{name} has its {len(self._views)} images in one place, expected a place for each")
        self._views[name]["data"] = memory.address + np.arange(len(self._views)) * first
        self._views[name]["pitch"] = rows

    @classmethod
    def empty(cls, width: int, height: int, count: Optional[int] = None, *,
              format: str = "rgb",  # pylint: disable=redefined-builtin
              colour: bool = True, alpha: bool = False, depth: bool = False, **rules: Any) -> "Frame":
        """A frame in arrays of NumPy: `count` images, or one without an index of the image. `rules` are those of the
        constructor."""
        if format not in FORMATS:
            raise ValueError(f"format is '{format}', expected one of {', '.join(FORMATS)}")
        if rules.get("over"):
            raise ValueError("over: a new frame holds no colour to draw over, expected a Frame of yours")
        chosen = FORMATS[format]
        images = (height, width) if count is None else (count, height, width)
        return cls(np.empty((*images, chosen.channels), chosen.kind) if colour else None,
                   np.empty(images, np.float32) if alpha else None,
                   np.empty(images, np.float32) if depth else None, **rules)

    @property
    def background(self) -> np.ndarray:
        """[C, 3] in the scene's own values. It may be set."""
        return self._views["background"].copy()

    @background.setter
    def background(self, value: Any) -> None:
        found = np.asarray(value, np.float32)
        if found.shape not in ((3,), (len(self._views), 3)):
            raise ValueError(f"background has the shape {found.shape}, expected (3,) or ({len(self._views)}, 3)")
        self._views["background"] = found

    def __len__(self) -> int:
        """How many images there are."""
        return len(self._views)

    def _aim(self, cameras: Union[Camera, Sequence[Camera]], measure: int) -> None:
        """Sets the cameras of the next frame, and what it measures."""
        if measure != self._measure:
            self._struct.measure = self._measure = measure
        if type(cameras) is Camera and cameras._size == self._one_size:
            self._camera_bytes[:] = cameras._bytes
            return
        found = check_cameras(cameras)
        if len(found) != len(self._views):
            raise ValueError(f"{len(found)} cameras for a frame of {len(self._views)} images, expected as many")
        for camera in found:
            if not self._is_part and camera._size != (self.width, self.height):
                raise ValueError(f"the camera has {camera.width}x{camera.height} pixels and the frame {self.width}x"
                                 f"{self.height}, expected as many, or first_pixel for a part of the image")
        self._camera_bytes[:] = b"".join(camera._bytes for camera in found)

    def save(self, path: Union[str, "os.PathLike[str]"], index: int = 0) -> None:
        """Writes image `index` of a frame on the host as its ending says: `.png`, `.pfm`, or `.exr`, which has alpha
        and depth too. Values are written as they are, without gamma."""
        if self.device is not None or self.colour is None:
            raise ValueError("save: expected a frame on the host with colour")
        at = range(len(self))[index]
        colour = np.asarray(self.colour).reshape(len(self), self.height, self.width, -1)[at]
        scale = 255 if colour.dtype == np.uint8 else 1
        rgb = np.ascontiguousarray(colour[..., :3], np.float32) / np.float32(scale)
        image = _c.Image(width=self.width, height=self.height)
        kept = {"colour": rgb}
        for name in ("alpha", "depth"):
            array = getattr(self, name)
            if array is not None:
                kept[name] = np.ascontiguousarray(np.asarray(array).reshape(len(self), self.height, self.width)[at])
        for name, array in kept.items():
            setattr(image, name, _c.Plane(array.ctypes.data, array.strides[0]))
        lib.image_write(os.fsencode(path), ctypes.byref(image))

    def __repr__(self) -> str:
        planes = [name for name in ("colour", "alpha", "depth") if getattr(self, name) is not None]
        number = f"{len(self)} x " if self.batched else ""
        place = self._memory[0].place
        return f"<swiftgs.Frame of {number}{self.width}x{self.height}, {', '.join(planes)}, on {place}>"


def _split(name: str, memory: _arrays.Memory, expected: Optional[Tuple[int, ...]]) -> Tuple[Tuple[int, ...], int]:
    """The shape without channels, and how many of those there are."""
    shape = memory.shape
    if name == "colour":
        allowed = {(f.kind, f.channels) for f in FORMATS.values()}
        if len(shape) not in (3, 4) or (memory.kind, shape[-1]) not in allowed:
            raise ValueError(f"colour has the shape {shape} of type {memory.kind}, expected ([C,] H, W, 3) of f4, or "
                             "([C,] H, W, 4) of f4, f2 or u1")
        images, channels = shape[:-1], shape[-1]
    else:
        images = shape[:-1] if len(shape) in (3, 4) and shape[-1] == 1 and shape != expected else shape
        if len(images) not in (2, 3) or memory.kind != "f4":
            raise ValueError(f"{name} has the shape {shape} of type {memory.kind}, expected ([C,] H, W) or "
                             "([C,] H, W, 1) of f4")
        channels = 1
    if 0 in images:
        raise ValueError(f"{name} has the shape {shape}, expected no side of 0")
    item = int(memory.kind[1:])
    if any(place % item for place in (memory.address, *memory.strides)):
        raise ValueError(f"{name} begins at the address {memory.address} with the strides {memory.strides} bytes, "
                         f"expected multiples of {item}")
    pixels = _dlpack.dense_strides((shape[len(images) - 1], channels), item)
    found = memory.strides[len(images) - 1:len(images)] + (memory.strides[len(images):] or (item,))
    sides = (shape[len(images) - 1], channels)
    if any(side > 1 and stride != wanted for side, stride, wanted in zip(sides, found, pixels)):
        raise ValueError(f"{name} has the strides {memory.strides} bytes, expected pixels of a row side by side, "
                         f"{pixels} at the end")
    return images, channels


def load_image(path: Union[str, "os.PathLike[str]"]) -> np.ndarray:
    """[height, width, channels] of a PNG, a JPEG, a PFM or an EXR, in float32, from 0 to 1 if the file has integers.

    Values are those of the file, without gamma. FormatError or FileError.
    """
    picture = Handle(lib.picture_free, lib.picture_read, os.fsencode(path))
    pixels = _c.Pixels()
    lib.picture_get(picture.pointer, ctypes.byref(pixels))
    return np.asarray(OwnedFloats(picture, pixels.data, (pixels.height, pixels.width, pixels.channels)))
