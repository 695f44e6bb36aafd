# SPDX-License-Identifier: Apache-2.0
"""Frames: memory of images, and the rules that they are drawn by."""
import ctypes
import operator
import os
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _arrays, _c, _checks
from ._c import PLANES, Handle, OwnedFloats, lib
from ._camera import Camera, Conventions, StoredDepth, check_cameras, conventions_of, size_of
from ._errors import InvalidArgument, InvalidType
from ._planes import FORMATS, Plane, read_planes

_VIEW = np.dtype(_c.View)
_BLACK = (0, 0, 0)
_CONVERSIONS = (None, "srgb-to-linear", "linear-to-srgb")


def _column_and_row(first_pixel: Any) -> Tuple[int, int]:
    try:
        column, row = map(operator.index, first_pixel)
    except (TypeError, ValueError):
        raise InvalidType(f"first_pixel is {first_pixel!r}, expected two whole numbers, column and row") from None
    return column, row


class Frame:
    """Where one image goes, or a batch of images of one size, and how it is drawn.

    `Renderer.render` makes one and returns it. Make one yourself to draw into your own arrays, or into the same memory
    again and again: `renderer.render(camera, out=frame)`. An array of any library will do, on the host or on a device;
    no pixel is copied.

    colour [H, W, 3 or 4] or [C, H, W, 3 or 4]: float32 RGB, or RGBA in float32, float16 or uint8, where colours are
    premultiplied by alpha. Other planes are [(C,) H, W] or [(C,) H, W, 1] in float32 unless said otherwise. Pixels of
    a row lie side by side; rows may have gaps and go up.

    A Gaussian's weight in a pixel is alpha times the transmittance in front of it; depths are as the conventions
    measure them. `depth` and `squared_depth` are means by weight, of depths and of their squares, 0 where alpha is 0.
    `first_depth` is that of the Gaussian that takes alpha above `first_alpha` of the conventions, `median_depth` that
    of the one that takes it above 1/2, 0 where none does. `normal` [(C,) H, W, 3] sums weight times normal: a unit
    vector in camera space along the Gaussian's shortest axis, against the ray through its mean. `id`, in uint32, is the
    index of the Gaussian of the largest weight, of equal ones the nearest, and `median_id` that of the Gaussian of
    `median_depth`; `NOTHING` where there is none. `features` [(C,) H, W, F] sums weight times feature, the first F of
    the scene's.
    """

    def __init__(self, colour: Any = None, alpha: Any = None, depth: Any = None, *, squared_depth: Any = None,
                 first_depth: Any = None, median_depth: Any = None, normal: Any = None,
                 id: Any = None, median_id: Any = None,  # pylint: disable=redefined-builtin
                 features: Any = None, occluder: Any = None, stored_depth: Optional[StoredDepth] = None,
                 over: bool = False, background: Any = _BLACK, conventions: Union[str, Conventions] = "gsplat",
                 first_pixel: Optional[Tuple[int, int]] = None, conversion: Optional[str] = None,
                 shows: Any = None) -> None:
        """`occluder` is a depth buffer, only read: a splat at its depth or behind is not drawn. `stored_depth` says
        what its values mean; without it they are depths. `over` keeps what
        `colour` holds behind the splats, in place of `background` [3] or [C, 3]. With `first_pixel` the frame is a
        part of the camera's image, which begins with that column and row, multiples of 16.

        `conversion` makes the colours of a scene with sRGB-encoded values linear light ("srgb-to-linear"), or the other
        way round ("linear-to-srgb"). Straight colours are converted, and multiplied by alpha again; RGB, and what lies
        before a background that is not black, as a whole picture. `over` then takes and leaves converted colours.

        `shows` are the placed scenes that images show, of several in the renderer: a range, such as `range(2, 5)`, or
        one of each image; None for all."""
        self.colour, self.alpha, self.depth, self.squared_depth = colour, alpha, depth, squared_depth
        self.first_depth, self.median_depth, self.normal = first_depth, median_depth, normal
        self.id, self.median_id, self.features = id, median_id, features
        arrays = dict(self._arrays(), occluder=occluder)
        self._planes = read_planes(**arrays)
        images, self.device = self._planes[0].layout.images, self._planes[0].memory.device
        self.batched = len(images) == 3  #: whether the arrays have an index of the image first
        self.height, self.width = images[-2:]
        self._conventions = conventions_of(conventions)
        self._is_part = first_pixel is not None
        self._views: Any = (_c.View * (images[0] if self.batched else 1))()
        if first_pixel is not None:
            left, top = _column_and_row(first_pixel)
            self._views[0] = _c.View(left=left, top=top)
        # Copies of the cameras of the next frame, which may go while it is drawn.
        self._cameras: Any = (_c.Camera * len(self._views))()
        self._camera_bytes = memoryview(self._cameras).cast("B")
        if stored_depth is not None:
            _checks.of_type(stored_depth, StoredDepth, "stored_depth")
            self._views[0].stored_depth = _c.StoredDepth(*stored_depth)
        self._views[0].conversion = _checks.choice(conversion, "conversion", _CONVERSIONS)
        self._fill(over)
        if background is not _BLACK:
            self.background = background
        if shows is not None:
            self.shows = shows
        self._struct: Any = _c.Frame()
        self._struct.views, self._struct.count = ctypes.addressof(self._views), len(self._views)
        self._argument = ctypes.byref(self._struct)
        self._times = self._counts = False  # what the next frame measures
        # The size of cameras that need no other look; none in frames of parts or batches.
        self._one_size = size_of(self.width, self.height) if len(self._views) == 1 and not self._is_part else None
        if self.device is not None:
            self._sources = _arrays.one_of_each_stream(array for array in arrays.values() if array is not None)

    def _let_go(self) -> None:
        """Forgets the arrays and keeps their layouts for `_draw_into`."""
        vars(self).update(dict.fromkeys(("colour", *PLANES)))
        self._planes = [Plane(name, _arrays.NOWHERE, layout) for name, _, layout in self._planes]
        self._sources = {}

    def _draw_into(self, arrays: Dict[str, Any]) -> None:
        """Sets the arrays of the next frame, by name: of `_arrays.empty`, of the same shapes as before `_let_go`. The
        caller keeps them."""
        for name, _, layout in self._planes:
            self._point_to(name, _arrays.address_of(arrays[name]), layout.step)
        if self.device is not None:
            self._sources = _arrays.one_of_each_stream(arrays.values())

    def _arrays(self) -> Dict[str, Any]:
        """All planes that the frame has, by name."""
        planes = {name: getattr(self, name) for name in ("colour", *PLANES)}
        return {name: array for name, array in planes.items() if array is not None}

    def _fill(self, over: bool) -> None:
        """The structs of the views, but for cameras and backgrounds."""
        view = self._views[0]
        view.size, view.width, view.height, view.over = _VIEW.itemsize, self.width, self.height, bool(over)
        view.conventions, view.camera = ctypes.addressof(self._conventions), ctypes.addressof(self._cameras)
        for name, _, layout in self._planes:
            getattr(view, name).pitch = layout.pitch
            if name == "colour":
                view.format = layout.format
            elif name == "features":
                view.feature_channels = layout.channels
        if len(self._views) > 1:
            table = self._table
            table[1:] = table[0]
            table["camera"] = view.camera + np.arange(len(table)) * ctypes.sizeof(_c.Camera)
        for name, memory, layout in self._planes:
            self._point_to(name, memory.address, layout.step)

    def _point_to(self, name: str, address: int, step: int) -> None:
        """Sets where the images of a plane begin."""
        if len(self._views) > 1:
            self._table[name]["data"] = address + np.arange(len(self._views)) * step
        else:
            getattr(self._views[0], name).data = address

    @property
    def _table(self) -> np.ndarray:
        """The structs of all views as an array, which shares their memory."""
        return np.frombuffer(self._views, _VIEW)

    @classmethod
    def empty(cls, width: int, height: int, count: Optional[int] = None, *,
              format: str = "rgb",  # pylint: disable=redefined-builtin
              colour: bool = True, features: int = 0, **options: Any) -> "Frame":
        """A frame in arrays of NumPy: `count` images, or one without an index of the image, with the first `features`
        of the scene's. `options` are `alpha=True`, `depth=True` and so on for other planes, and the rules of the
        constructor."""
        chosen = list(FORMATS.values())[_checks.choice(format, "format", tuple(FORMATS))]
        width, height = _checks.whole(width, "width", 1), _checks.whole(height, "height", 1)
        features = _checks.whole(features, "features", 0)
        if options.get("over"):
            raise InvalidArgument("over: a new frame holds no colour to draw over, expected a Frame of yours")
        images = (height, width) if count is None else (_checks.whole(count, "count", 1), height, width)
        if colour:
            options["colour"] = np.empty((*images, chosen.channels), chosen.kind)
        if features:
            options["features"] = np.empty((*images, features), np.float32)
        for name, (kind, channels) in PLANES.items():
            if options.get(name) is not None and np.ndim(options[name]) == 0:
                shape = images if channels == 1 else (*images, channels)
                options[name] = np.empty(shape, kind) if options[name] else None
        return cls(**options)

    @property
    def background(self) -> np.ndarray:
        """[C, 3] in the scene's own values. It may be set."""
        return self._table["background"].copy()

    @background.setter
    def background(self, value: Any) -> None:
        self._table["background"] = _checks.reals(value, "background", (3,), (len(self._views), 3), dtype=np.float32)

    @property
    def shows(self) -> List[Optional[range]]:
        """The placed scenes that each image shows; None: all. It may be set, to one range for all images as well."""
        ranges = [range(view.first_shown, view.first_shown + view.shown_count) for view in self._views]
        return [found or None for found in ranges]

    @shows.setter
    def shows(self, value: Any) -> None:
        each = [value] * len(self._views) if value is None or isinstance(value, range) else (
            _checks.listed(value, "shows"))
        if len(each) != len(self._views):
            raise InvalidArgument(f"shows has {len(each)} ranges, expected one, or {len(self._views)}, one an image")
        for found in each:
            if found is not None and not (isinstance(found, range) and found and found.step == 1 and
                                          0 <= found.start and found.stop < 2**32):
                raise InvalidArgument(f"shows has {found!r}, expected None or a range of one placed scene or more, "
                                      "such as range(2, 5)")
        for view, found in zip(self._views, each):
            view.first_shown, view.shown_count = (found.start, len(found)) if found else (0, 0)

    def __len__(self) -> int:
        """How many images there are."""
        return len(self._views)

    def _aim(self, cameras: Union[Camera, Sequence[Camera]]) -> None:
        """Sets the cameras of the next frame."""
        found = check_cameras(cameras)
        if len(found) != len(self._views):
            raise InvalidArgument(f"{len(found)} cameras for a frame of {len(self._views)} images, expected as many")
        for camera in found:
            if not self._is_part and camera._size != (self.width, self.height):
                raise InvalidArgument(f"the camera has {camera.width}x{camera.height} pixels and the frame "
                                      f"{self.width}x{self.height}, expected as many, or first_pixel for a part of the "
                                      "image")
        self._camera_bytes[:] = b"".join(camera._bytes for camera in found)

    def _measure(self, times: bool, counts: bool) -> None:
        self._times, self._counts = times, counts
        self._struct.measure = _c.MEASURE_TIMES * bool(times) + _c.MEASURE_COUNTS * bool(counts)

    def save(self, path: Union[str, "os.PathLike[str]"], index: Optional[int] = None) -> None:
        """Writes an image of a frame on the host as its ending says: `.png`, `.pfm`, or `.exr`, which has all planes.
        Values are written as they are, without gamma. A PNG of RGBA, or of a frame with the plane `alpha`, has alpha
        and straight colours. It is opaque before a background that is not black, and of RGB over a picture.

        Of a frame of several images `index` says which; without it InvalidArgument names the files for all.
        """
        if index is None and len(self) > 1:
            stem, ending = os.path.splitext(os.fsdecode(_checks.path(path)))
            raise InvalidArgument(f"save: index is None in a frame of {len(self)} images, expected one from 0 to "
                                  f"{len(self) - 1}, such as '{stem}_0{ending}' with index 0 up to "
                                  f"'{stem}_{len(self) - 1}{ending}' with index {len(self) - 1}")
        at = _checks.whole(0 if index is None else index, "save: index", -len(self), len(self))
        lib.image_write(_checks.path(path), ctypes.byref(self._image(at % len(self))))

    def _repr_png_(self) -> Optional[bytes]:
        """How notebooks show a frame: the PNG of its image. One of several images, on a device or without colour is
        shown as text."""
        if self.device is not None or self.colour is None or len(self) > 1:
            return None
        pieces: List[bytes] = []
        take = _c.TAKE_BYTES(lambda _context, address, count: pieces.append(ctypes.string_at(address, count)))
        lib.png_encode(ctypes.byref(self._image(0)), take, None)
        return b"".join(pieces)

    def _image(self, index: int) -> _c.Image:
        """The struct of image `index`, whose memory is the frame's own."""
        if self.device is not None or self.colour is None:
            raise InvalidArgument("save: expected a frame on the host with colour")
        view = self._views[index]
        image = _c.Image(width=self.width, height=self.height, format=view.format, over=view.over,
                         background=view.background, feature_channels=view.feature_channels)
        for name, memory, layout in self._planes:
            if name != "occluder":
                setattr(image, name, _c.Plane(memory.address + index * layout.step, layout.pitch))
        return image

    def __repr__(self) -> str:
        number = f"{len(self)} x " if self.batched else ""
        place = self._planes[0].memory.place
        return f"<swiftgs.Frame of {number}{self.width}x{self.height}, {', '.join(self._arrays())}, on {place}>"


def load_image(path: Union[str, "os.PathLike[str]"]) -> np.ndarray:
    """[height, width, channels] of a PNG, a JPEG, a PFM or an EXR, in float32, from 0 to 1 if the file has integers.

    Values are those of the file, without gamma. FormatError or FileError.
    """
    picture = Handle(lib.picture_free, lib.picture_read, _checks.path(path))
    pixels = _c.Pixels()
    lib.picture_get(picture.pointer, ctypes.byref(pixels))
    return np.asarray(OwnedFloats(picture, pixels.data, (pixels.height, pixels.width, pixels.channels)))
