# SPDX-License-Identifier: Apache-2.0
"""Scenes: from files, from arrays, to files."""
import ctypes
import os
import signal
import threading
import warnings
from typing import Any, Callable, List, NamedTuple, Optional, Tuple, Union

import numpy as np

from . import _c, _checks
from ._c import Handle, OwnedFloats, lib
from ._camera import Camera, OrbitView
from ._errors import InvalidType, OrderError
from ._gaussians import gaussians_of
from ._model import RenderingModel

Path = Union[str, "os.PathLike[str]"]
Progress = Callable[[float], Optional[bool]]


class _Callbacks:
    """Progress and notes of one call. What Python raises within comes out of `run`, Ctrl-C among it."""

    def __init__(self, progress: Optional[Progress]) -> None:
        if not (progress is None or callable(progress)):
            raise InvalidType(f"progress is {progress!r}, expected a function")
        self.notes: List[str] = []
        self._raised: Optional[BaseException] = None
        self._signals: List[Any] = []

        def on_progress(_context: Any, part: float) -> int:
            try:
                cancelled = progress is not None and progress(part) is False
                return int(cancelled or bool(self._signals))
            except BaseException as raised:  # pylint: disable=broad-except
                self._raised = raised
                return 1

        self.progress = _c.PROGRESS(on_progress)
        self.note = _c.NOTE(lambda _context, sentence: self.notes.append(sentence.decode(errors="replace")))

    def run(self, function: Any, *arguments: Any) -> Any:
        """The handler of SIGINT must not raise within a callback, which nothing could leave: it runs afterwards."""
        handler: Any = signal.getsignal(signal.SIGINT)
        deferred = callable(handler) and threading.current_thread() is threading.main_thread()
        if deferred:
            signal.signal(signal.SIGINT, lambda *received: self._signals.append(received))
        try:
            return function(*arguments)
        except Exception:
            if self._raised is not None:
                raise self._raised from None
            raise
        finally:
            if deferred:
                signal.signal(signal.SIGINT, handler)
                for received in self._signals:
                    handler(*received)


def _axes(spz_axes: str) -> int:
    return _checks.choice(spz_axes, "spz_axes", _c.SPZ_AXES)


class Scene:
    """Gaussians in the host's memory. They never change, and any number of threads may read them.

    `swiftgs.load` reads one from a file, `Scene.from_arrays` makes one of arrays, `Scene.builtin` needs neither.
    Renderers and arrays that were given a scene's memory keep it, so that it may be closed or forgotten at any time.
    """

    def __init__(self, handle: Handle, notes: Tuple[str, ...] = ()) -> None:
        """Use `load`, `from_arrays`, `from_bytes` or `builtin`."""
        self._handle: Optional[Handle] = handle
        self.notes = notes  #: a sentence for each thing that the file has and the scene has not
        self._info = _c.SceneInfo()
        lib.scene_get_info(handle.pointer, ctypes.byref(self._info))
        self._format = (self._info.format or b"").decode()
        camera = _c.Camera()
        lib.scene_get_camera(handle.pointer, ctypes.byref(camera))
        #: of the photograph that the scene was made of, where the file has it
        self.camera: Optional[Camera] = Camera.__new__(Camera)._take(camera, "") if camera.width else None

    @classmethod
    def builtin(cls, count: int = 200_000) -> "Scene":
        """A scene that needs no file: the same picture at any count."""
        return cls(Handle(lib.scene_free, lib.scene_builtin, _checks.whole(count, "count", 0, 2**32)))

    @classmethod
    def from_arrays(cls, means: Any, scales: Any, rotations: Any, opacities: Any, sh0: Any = None, sh_rest: Any = None,
                    *, colours: Any = None, log_scales: bool = False, logit_opacities: bool = False,
                    any_rotations: bool = True, features: Any = None,
                    model: RenderingModel = RenderingModel(), origin: Any = (0, 0, 0)) -> "Scene":
        """Copies arrays of float32 of any library, with gaps or without, on the host or on a CUDA device.

        means [N, 3]; scales [N, 3], standard deviations; rotations [N, 4], quaternions w, x, y, z, normalised unless
        `any_rotations` is False; opacities [N]; and either harmonics, `sh0` [N, 3] and `sh_rest` [N, 3 or 8 or 15, 3],
        or `colours` [N, 3]. `log_scales` and `logit_opacities` are for numbers as training stores them.
        `features` [N, F] are any numbers that frames may draw of Gaussians; files do not hold them. `model` says
        how they were trained to be drawn. `origin` is what was subtracted from positions in the world.
        """
        if (sh0 is None) == (colours is None):
            raise InvalidType("from_arrays takes either sh0 or colours")
        given = gaussians_of(means, scales, rotations, opacities, sh0, sh_rest, colours=colours,
                             log_scales=log_scales, logit_opacities=logit_opacities, any_rotations=any_rotations,
                             model=model, features=features)
        given.struct.origin = tuple(_checks.reals(origin, "origin", (3,)))
        return cls(Handle(lib.scene_free, lib.scene_from_arrays, ctypes.byref(given.struct)))

    @classmethod
    def from_bytes(cls, data: Any, name: str, *, spz_axes: str = "specified",
                   progress: Optional[Progress] = None) -> "Scene":
        """Reads a file that is in memory; `name` stands for it in messages, and its ending names a `.splat`."""
        try:
            view = np.frombuffer(data, np.uint8)
        except (TypeError, ValueError, AttributeError):
            raise InvalidType(f"data is of type {type(data).__name__}, expected bytes") from None
        file = _c.FileBytes(data=view.ctypes.data, count=view.size, name=_checks.path(name))
        return cls._read(lib.scene_read_bytes, ctypes.byref(file), spz_axes, 0, progress)

    @classmethod
    def _read(cls, function, source, spz_axes, level, progress):
        calls = _Callbacks(progress)
        options = _c.ReadOptions(spz_axes=_axes(spz_axes), level=level, progress=calls.progress, note=calls.note)
        handle = calls.run(Handle, lib.scene_free, function, source, ctypes.byref(options))
        return cls(handle, tuple(calls.notes))

    def save(self, path: Path, *, format: Optional[str] = None,  # pylint: disable=redefined-builtin
             spz_version: int = 4, spz_axes: str = "specified", progress: Optional[Progress] = None) -> Tuple[str, ...]:
        """Writes the format that the path's ending or `format` names; docs/formats.md lists them.

        The new file takes the place of an old one when it is whole. Returns a sentence for each thing that the format
        does not carry, and one that says how much rounding changes at most. `progress` is called with the part that is
        done, and cancels by returning False.
        """
        calls = _Callbacks(progress)
        ending = None if format is None else b"." + _checks.text(format, "format").lstrip(b".")
        options = _c.WriteOptions(spz_version=spz_version, spz_axes=_axes(spz_axes), ending=ending,
                                  progress=calls.progress, note=calls.note)
        calls.run(lib.scene_write, self._open(), _checks.path(path), ctypes.byref(options))
        return tuple(calls.notes)

    def _open(self) -> Handle:
        """To be held as long as its memory is used."""
        handle = self._handle
        if handle is None:
            raise OrderError("the scene is closed")
        return handle

    def _array(self, name: str, *shape: int) -> np.ndarray:
        handle, struct = self._open(), _c.Gaussians()
        lib.scene_get_arrays(handle, ctypes.byref(struct))
        address = getattr(struct, name).data
        if not address:
            return np.zeros((len(self), *shape), np.float32)
        return np.asarray(OwnedFloats(handle, address, (len(self), *shape)))

    @property
    def means(self) -> np.ndarray:
        """[N, 3] in the world, less `origin`. This and the arrays below are the scene's own memory: read them only."""
        return self._array("means", 3)

    @property
    def scales(self) -> np.ndarray:
        """[N, 3] standard deviations along the local axes."""
        return self._array("scales", 3)

    @property
    def rotations(self) -> np.ndarray:
        """[N, 4] unit quaternions w, x, y, z from local axes to the world."""
        return self._array("rotations", 4)

    @property
    def opacities(self) -> np.ndarray:
        """[N], 0 to 1."""
        return self._array("opacities")

    @property
    def sh0(self) -> np.ndarray:
        """[N, 3] harmonics of band 0, RGB."""
        return self._array("sh0", 3)

    @property
    def sh_rest(self) -> np.ndarray:
        """[N, (sh_degree + 1)^2 - 1, 3] harmonics of bands 1 and up."""
        return self._array("sh_rest", (self.sh_degree + 1) ** 2 - 1, 3)

    @property
    def sh(self) -> np.ndarray:
        """[N, (sh_degree + 1)^2, 3], all bands in one array of its own, as `rasterization` takes them."""
        return np.concatenate([self.sh0[:, None], self.sh_rest], axis=1)

    @property
    def features(self) -> np.ndarray:
        """[N, F], whatever else is drawn of a Gaussian."""
        return self._array("features", self._info.feature_channels)

    @property
    def sh_degree(self) -> int:
        """0 to 3."""
        return self._info.sh_degree

    @property
    def model(self) -> RenderingModel:
        """How the scene was trained to be drawn, which frames follow."""
        return RenderingModel._of(self._info)

    @property
    def bounds(self) -> Tuple[np.ndarray, np.ndarray]:
        """Least and greatest coordinates of all means, less `origin`."""
        return np.array(self._info.lower), np.array(self._info.upper)

    def robust_bounds(self) -> "SceneBounds":
        """Where most of the scene lies, whatever strays about it, less `origin`."""
        found = _c.SceneBounds()
        lib.scene_robust_bounds(self._open(), ctypes.byref(found))
        return SceneBounds(np.array(found.low), np.array(found.high), np.array(found.centre), found.radius)

    def default_view(self, width: int = 1280, height: int = 720, *, up: Any = None) -> OrbitView:
        """Where to start to look at a scene without cameras, less `origin`: at its middle, from where most of it is
        seen and nothing stands in the way. `up` is where up is in the scene's world; without it up is guessed, mostly
        as -y."""
        orbit = _c.Orbit(up=(0, 0, 0) if up is None else tuple(_checks.reals(up, "up", (3,))))
        camera = _c.Camera()
        lib.scene_default_view(self._open(), _checks.whole(width, "width"), _checks.whole(height, "height"),
                               ctypes.byref(camera), ctypes.byref(orbit))
        return OrbitView(Camera.__new__(Camera)._take(camera, ""), np.array(orbit.target), np.array(orbit.up))

    @property
    def origin(self) -> np.ndarray:
        """[3], where the means' zero lies in the world. It is other than 0 in scenes far from the world's zero; draw
        these with `camera.relative_to(scene.origin)` for each camera of the world."""
        return np.array(self._info.origin)

    @property
    def format(self) -> str:
        """Such as "SPZ version 4"; empty if the scene is not from a file."""
        return self._format

    @property
    def stored(self) -> int:
        """Gaussians in the file."""
        return self._info.stored

    @property
    def dropped(self) -> int:
        """Those of them that were left out, as not finite or without a rotation; `notes` say how many of each."""
        return self._info.dropped

    def __len__(self) -> int:
        return self._info.count

    def close(self) -> None:
        """Gives up the memory, as soon as no renderer and no array uses it."""
        self._handle = None

    def __enter__(self) -> "Scene":
        self._open()
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __repr__(self) -> str:
        source = f" from {self._format}" if self._format else ""
        state = ", closed" if self._handle is None else ""
        return f"<swiftgs.Scene of {len(self):,} Gaussians, SH degree {self.sh_degree}{source}{state}>"


class SceneBounds(NamedTuple):
    """Where most of a scene lies, by its solid Gaussians."""

    low: np.ndarray  #: [3], least coordinates of all but the outermost 2 % along each axis
    high: np.ndarray  #: [3], greatest
    centre: np.ndarray  #: [3], the median along each axis
    radius: float  #: half of the Gaussians are as near to the centre


def load(path: Path, *, spz_axes: str = "specified", level: int = 0, progress: Optional[Progress] = None) -> Scene:
    """Reads a scene of any format that the library knows; `path` may also be the folder of a capture.

    `spz_axes` are the world's axes in an SPZ file, `level` is the detail in a streamed SOG. `progress` is called with
    the part that is done, and cancels by returning False. FormatError, FileError or Cancelled; Ctrl-C stops it, too.
    What the scene does not take from the file is in `notes`; Gaussians that cannot be drawn are a warning.
    """
    scene = Scene._read(lib.scene_read, _checks.path(path), spz_axes, level, progress)
    if scene.dropped:
        warnings.warn(f"{os.fspath(path)}: {scene.dropped:,} of {scene.stored:,} Gaussians are not finite or have no "
                      "rotation, and were left out; notes say how many of each", stacklevel=2)
    return scene
