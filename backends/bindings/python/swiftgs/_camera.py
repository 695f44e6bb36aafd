# SPDX-License-Identifier: Apache-2.0
"""Cameras and conventions."""
import ctypes
import dataclasses
import functools
import os
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from . import _c, _checks
from ._c import Handle, count_of, lib, text_of
from ._errors import InvalidArgument, InvalidType


class StoredDepth(NamedTuple):
    """How values of a depth buffer stand for depths: value d for (p d + q) / (r d + s)."""
    p: float
    q: float
    r: float
    s: float

    @classmethod
    def perspective(cls, at_0: float, at_1: float) -> "StoredDepth":
        """That of a perspective projection of OpenGL (its window depth), Vulkan or Direct3D, by the depths at the
        values 0 and 1: those of the near and the far plane, or with reversed depth of the far and the near one. Either
        may be infinite."""
        return cls._of(lib.stored_perspective(_checks.real(at_0, "at_0"), _checks.real(at_1, "at_1")))

    @classmethod
    def orthographic(cls, at_0: float, at_1: float) -> "StoredDepth":
        """That of an orthographic projection."""
        return cls._of(lib.stored_orthographic(_checks.real(at_0, "at_0"), _checks.real(at_1, "at_1")))

    @classmethod
    def _of(cls, found: Any) -> "StoredDepth":
        return cls(found.p, found.q, found.r, found.s)


class Camera:
    """A camera with OpenCV's axes: x right, y down, z forward. It never changes. World axes are the scene's own,
    right-handed; in scenes of captures y points down, so that up is about -y.

    A point p of the world is at (x, y, z) = `rotation @ p + translation`. The lens shows it at (u, v), distortion moves
    that, and the image has it at (fx u + cx, fy v + cy). Pixel (column i, row j) is sampled at (i + 0.5, j + 0.5).

    `model` says what (u, v) is:

    - "perspective": (x / z, y / z), for z > 0
    - "fisheye": the angle to the axis in radians times (x, y) / |(x, y)|; distortion-free it is equidistant
    - "orthographic": (x, y), so that focal lengths are in pixels per unit of the scene
    - "equirectangular": azimuth atan2(x, z) and elevation atan2(y, |(x, z)|) in radians

    Distortion, of perspective and fisheye lenses alone, is OpenCV's: `radial` k of 4, `rational` q of 3, `tangential` p
    and `prism` s of 2 numbers, zeros where fewer are given. With r^2 = u^2 + v^2 it moves (u, v) to

        u R + 2 p0 u v + p1 (r^2 + 2 u^2) + s0 r^2,  v R + p0 (r^2 + 2 v^2) + 2 p1 u v + s1 r^2,
        R = (1 + k0 r^2 + k1 r^4 + k2 r^6 + k3 r^8) / (1 + q0 r^2 + q1 r^4 + q2 r^6)

    >>> Camera(640, 480, fx=500)
    <swiftgs.Camera 640x480, f 500, at (0, 0, 0)>
    >>> Camera(640, 640, fx=200, model="fisheye", radial=(0.02, -0.003))
    <swiftgs.Camera 640x640, fisheye, distorted, f 200, at (0, 0, 0)>
    """

    __slots__ = ("_struct", "_bytes", "_size", "name")

    def __init__(self, width: int, height: int, fx: float, fy: Optional[float] = None, cx: Optional[float] = None,
                 cy: Optional[float] = None, *, rotation: Any = None, translation: Any = (0, 0, 0),
                 model: str = "perspective", radial: Sequence[float] = (), rational: Sequence[float] = (),
                 tangential: Sequence[float] = (), prism: Sequence[float] = (), name: str = "") -> None:
        """`fy` is `fx` and the principal point is the centre of the image unless they are given. `rotation` [3, 3]
        turns the world into the camera's axes."""
        turn = np.eye(3) if rotation is None else _checks.reals(rotation, "camera: rotation", (3, 3))
        move = _checks.reals(translation, "camera: translation", (3,))
        width, height = _checks.whole(width, "camera: width"), _checks.whole(height, "camera: height")
        distortion = {"radial": radial, "rational": rational, "tangential": tangential, "prism": prism}
        self._take(_c.Camera(width=width, height=height, rotation=tuple(turn.ravel()), translation=tuple(move),
                             lens=_checks.choice(model, "camera: model", _c.LENSES), fx=fx, fy=fx if fy is None else fy,
                             cx=width / 2 if cx is None else cx, cy=height / 2 if cy is None else cy,
                             **{part: _coefficients(part, given) for part, given in distortion.items()}), name)

    def _take(self, struct: _c.Camera, name: str) -> "Camera":
        lib.camera_scale(ctypes.byref(struct), 1)  # changes nothing, and refuses what is no camera
        self._struct, self._bytes, self.name = struct, bytes(struct), name
        self._size = size_of(struct.width, struct.height)
        return self

    @classmethod
    def from_matrices(cls, viewmat: Any, K: Any, width: int, height: int, *, name: str = "", **lens: Any) -> "Camera":
        """Of a matrix [4, 4] from the world to the camera and one [3, 3] of intrinsics, as `rasterization` takes.
        `model`, `radial` and so on are those of the class."""
        view = _checks.reals(viewmat, "camera: viewmat", (4, 4))
        intrinsics = _checks.reals(K, "camera: K", (3, 3))
        return cls(width, height, intrinsics[0, 0], intrinsics[1, 1], intrinsics[0, 2], intrinsics[1, 2],
                   rotation=view[:3, :3], translation=view[:3, 3], name=name, **lens)

    @classmethod
    def from_projection(cls, view: Any, projection: Any, width: int, height: int, clip_space: str, *,
                        name: str = "") -> Tuple["Camera", StoredDepth]:
        """Of the matrices [4, 4] of a renderer that draws a point of the world at `projection @ view @ point`, and what
        its depth buffer holds, for `Frame`. `clip_space` is "opengl", "vulkan" or "direct3d". Either matrix may be
        right-handed or left-handed, and the projection off-centre, jittered, flipped, reversed or infinite. A matrix
        whose points are rows is the transpose of one of these. InvalidArgument names the row of what is no pinhole."""
        matrices = {what: _checks.reals(given, f"camera: {what}", (4, 4))
                    for what, given in (("view", view), ("projection", projection))}
        given = _c.Matrices(clip_space=_clip_space(clip_space), width=width, height=height,
                            **{what: tuple(matrix.T.ravel()) for what, matrix in matrices.items()})
        struct, depth = _c.Camera(), _c.StoredDepth()
        lib.camera_from_matrices(ctypes.byref(given), ctypes.byref(struct), ctypes.byref(depth))
        return cls.__new__(cls)._take(struct, name), StoredDepth._of(depth)

    def matrices(self, at_0: float, at_1: float, clip_space: str) -> Tuple[np.ndarray, np.ndarray]:
        """View and projection [4, 4] of a renderer that draws as this pinhole sees. The view looks along -z with y up,
        or along z if the rotation's determinant is -1. The depth buffer holds 0 and 1 at the depths `at_0` and `at_1`:
        near and far, or far and near for reversed depth; the far one may be infinite."""
        made = _c.Matrices()
        lib.camera_to_matrices(ctypes.byref(self._struct), _clip_space(clip_space),
                               _checks.real(at_0, "at_0"), _checks.real(at_1, "at_1"), ctypes.byref(made))
        return np.array(made.view).reshape(4, 4).T, np.array(made.projection).reshape(4, 4).T

    @classmethod
    def look_at(cls, eye: Any, target: Any, *, width: int, height: int, vertical_fov: float, up: Any = (0, -1, 0),
                name: str = "") -> "Camera":
        """From `eye` to `target`, which appears in the centre. `up` points up in the image; in captures y often points
        down. `vertical_fov` is the full angle in radians."""
        at = _c.LookAt(width=width, height=height, eye=_vector(eye, "eye"), target=_vector(target, "target"),
                       up=_vector(up, "up"), vertical_fov=vertical_fov)
        struct = _c.Camera()
        lib.camera_look_at(ctypes.byref(at), ctypes.byref(struct))
        return cls.__new__(cls)._take(struct, name)

    @classmethod
    def builtin(cls, width: int = 1280, height: int = 720) -> "Camera":
        """The view that the built-in scene is composed for."""
        struct = _c.Camera()
        lib.camera_builtin(_checks.whole(width, "camera: width"), _checks.whole(height, "camera: height"),
                           ctypes.byref(struct))
        return cls.__new__(cls)._take(struct, "")

    def scaled(self, scale: float) -> "Camera":
        """The same view at `scale` times the size. Sides are rounded to whole pixels."""
        struct = _c.Camera.from_buffer_copy(self._struct)
        lib.camera_scale(ctypes.byref(struct), _checks.real(scale, "camera: scale"))
        return type(self).__new__(type(self))._take(struct, self.name)

    def relative_to(self, origin: Any) -> "Camera":
        """The same camera in a world whose zero lies at `origin` [3] of this one, such as that of a scene."""
        struct = _c.Camera.from_buffer_copy(self._struct)
        struct.translation = tuple(self.translation + self.rotation @ _checks.reals(origin, "origin", (3,)))
        return type(self).__new__(type(self))._take(struct, self.name)

    @property
    def width(self) -> int:
        """Columns of pixels."""
        return self._size[0]

    @property
    def height(self) -> int:
        """Rows of pixels."""
        return self._size[1]

    @property
    def fx(self) -> float:
        """Focal length along x in pixels."""
        return self._struct.fx

    @property
    def fy(self) -> float:
        """Focal length along y in pixels."""
        return self._struct.fy

    @property
    def cx(self) -> float:
        """The principal point's x in pixels; half the width in the centre."""
        return self._struct.cx

    @property
    def cy(self) -> float:
        """The principal point's y in pixels; half the height in the centre."""
        return self._struct.cy

    @property
    def model(self) -> str:
        """The lens: "perspective", "fisheye", "orthographic" or "equirectangular"."""
        return _c.LENSES[self._struct.lens]

    @property
    def radial(self) -> Tuple[float, ...]:
        """Four coefficients of r^2, r^4, r^6 and r^8."""
        return tuple(self._struct.radial)

    @property
    def rational(self) -> Tuple[float, ...]:
        """Three coefficients of r^2, r^4 and r^6 below the fraction."""
        return tuple(self._struct.rational)

    @property
    def tangential(self) -> Tuple[float, ...]:
        """Two coefficients."""
        return tuple(self._struct.tangential)

    @property
    def prism(self) -> Tuple[float, ...]:
        """Two coefficients of r^2, added along x and y."""
        return tuple(self._struct.prism)

    @property
    def is_distorted(self) -> bool:
        """Whether a coefficient is not 0."""
        return any((*self.radial, *self.rational, *self.tangential, *self.prism))

    @property
    def rotation(self) -> np.ndarray:
        """[3, 3] from the world to the camera."""
        return np.array(self._struct.rotation).reshape(3, 3)

    @property
    def translation(self) -> np.ndarray:
        """[3], the world's origin in the camera."""
        return np.array(self._struct.translation)

    @property
    def position(self) -> np.ndarray:
        """[3], where the camera is in the world."""
        return -self.rotation.T @ self.translation

    @property
    def viewmat(self) -> np.ndarray:
        """[4, 4] from the world to the camera."""
        view = np.eye(4)
        view[:3, :3], view[:3, 3] = self.rotation, self.translation
        return view

    @property
    def K(self) -> np.ndarray:  # pylint: disable=invalid-name
        """[3, 3] of intrinsics."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Camera) and self._bytes == other._bytes

    def __hash__(self) -> int:
        return hash(self._bytes)

    def __reduce__(self) -> Any:
        return (_camera_of, (self._bytes, self.name))

    def __repr__(self) -> str:
        named = f" '{self.name}'" if self.name else ""
        lens = f", {self.model}" * (self.model != "perspective") + ", distorted" * self.is_distorted
        focal = f"{self.fx:g}" if self.fx == self.fy else f"{self.fx:g} and {self.fy:g}"
        at = ", ".join(f"{x + 0.0:.3g}" for x in self.position + 0.0)
        return f"<swiftgs.Camera{named} {self.width}x{self.height}{lens}, f {focal}, at ({at})>"


class OrbitView(NamedTuple):
    """A camera and the point that it turns around."""

    camera: Camera
    target: Any  #: [3]
    up: Any = (0, -1, 0)  #: [3] of any length; y points down in the world of most captures

    def orbit(self, turn: float, rise: float = 0, distance: float = 1) -> Camera:
        """The camera moved around the target, which stays where it is in the image: to its right by `turn`
        about the axis `up`, by `rise` towards `up`, never within a degree of the axis, in radians, and to `distance`
        times its distance, by which an orthographic camera's focal lengths are divided."""
        axis, distance = _vector(self.up, "up"), _checks.real(distance, "distance")
        if not any(axis) or not distance:  # zeros have defaults in C
            raise InvalidArgument(f"orbit: up is {axis} and distance {distance}, expected a length and a number above "
                                  "0")
        by = _c.Orbit(target=_vector(self.target, "target"), up=axis, turn=turn, rise=rise, distance=distance)
        struct = _c.Camera.from_buffer_copy(self.camera._struct)
        lib.camera_orbit(ctypes.byref(struct), ctypes.byref(by))
        return Camera.__new__(Camera)._take(struct, self.camera.name)


def _clip_space(name: str) -> int:
    return _checks.choice(name, "camera: clip_space", _c.CLIP_SPACES)


def _vector(given: Any, what: str) -> Tuple[float, ...]:
    return tuple(_checks.reals(given, what, (3,)))


def _coefficients(name: str, given: Any) -> Tuple[float, ...]:
    """As many as the struct has."""
    found, most = _checks.reals(given, f"camera: {name}"), len(getattr(_c.Camera(), name))
    if found.ndim != 1 or len(found) > most:
        raise InvalidArgument(f"camera: {name} has the shape {found.shape}, expected at most {most} numbers")
    return tuple(found) + (0.0,) * (most - len(found))


@functools.lru_cache(maxsize=256)
def size_of(width: int, height: int) -> Tuple[int, int]:
    """A size. Equal ones are mostly the same object, which is quicker to see than that they are equal."""
    return width, height


def _camera_of(struct: bytes, name: str) -> Camera:
    return Camera.__new__(Camera)._take(_c.Camera.from_buffer_copy(struct), name)


class Cameras(List[Camera]):
    """The list of a file's cameras, with notes on the file."""

    notes: Tuple[str, ...] = ()  #: a sentence for each thing of the file that may change a picture and was not read


def load_cameras(path: Union[str, "os.PathLike[str]"]) -> Cameras:
    """The cameras of INRIA's cameras.json, of a transforms.json, of a COLMAP model or of a capture's folder.

    Each has the name of its image. What of the file was not read and may change a picture is in `notes` of the list.
    FormatError, FileError, or InvalidArgument for a folder without cameras.
    """
    cameras = Handle(lib.cameras_free, lib.cameras_read, _checks.path(path))
    found = Cameras()
    found.notes = tuple(text_of(lib.cameras_note, cameras.pointer, index)
                        for index in range(count_of(lib.cameras_note_count, cameras.pointer)))
    for index in range(count_of(lib.cameras_count, cameras.pointer)):
        struct = _c.Camera()
        lib.cameras_get(cameras.pointer, index, ctypes.byref(struct))
        found.append(Camera.__new__(Camera)._take(struct, text_of(lib.cameras_name, cameras.pointer, index)))
    return found


@dataclasses.dataclass(frozen=True)
class Conventions:
    """The numbers that define "the same image". The defaults are those of gsplat.

    `Conventions.named("inria")` and `Conventions.named("khronos")` are the other presets, and `dataclasses.replace` changes single numbers.
    """

    near_plane: float = 0.01  #: a Gaussian nearer than this is culled
    cull_at_near: bool = False  #: so is one exactly on the near plane
    far_plane: float = 1e10  #: a Gaussian further than this is culled
    clamp: str = "around-image"  #: or "around-centre": where the projection is linearised
    #: added to both variances of a splat, in square pixels; None: as the scene was trained
    blur: Optional[float] = None
    antialiased: Optional[bool] = None  #: scale opacity as Mip-Splatting does; None: as the scene was trained
    min_compensation: float = 2.5e-5  #: least ratio of determinants in that
    alpha_min: float = 1 / 255  #: a pixel skips a Gaussian with less alpha
    alpha_max: float = 0.99  #: alpha is cut here
    stop: float = 1e-4  #: a pixel ends before the Gaussian that would bring its transmittance below
    stop_at_equal: bool = True  #: or exactly to `stop`
    #: What is compared with the planes and occluders, and is drawn as depth: "z" along the axis, "distance" from the
    #: camera, or "of-lens": z of perspective and orthographic lenses, distance of the others.
    depth: str = "of-lens"
    first_alpha: float = 0.05  #: a pixel's first depth is of the Gaussian that takes its alpha above
    #: A splat's depth at a pixel, for planes of depth and occluders: "centre", its mean's, or "ray", where the Gaussian
    #: is densest along the pixel's ray.
    depth_at: str = "centre"
    #: What orders splats: "depth", or "distance" from the camera; None: as the scenes were trained, by distance if one
    #: was. Frames with an occluder are ordered by depth.
    order: Optional[str] = None
    #: In which values splats are blended: "srgb" or "linear"; None: as the scene was trained.
    colours: Optional[str] = None

    @classmethod
    def named(cls, name: str) -> "Conventions":
        """The preset "gsplat", "inria" or "khronos"."""
        struct = _c.Conventions()
        lib.conventions_named(_checks.text(name, "conventions"), ctypes.byref(struct))
        values = {field.name: getattr(struct, field.name) for field in dataclasses.fields(cls)}
        # What presets leave to the scene is None by default.
        values = {name: value for name, value in values.items() if value != _c.OF_SCENE}
        values.update({name: words[values[name]] for name, words in {**_WORDS, **_WORDS_OR_OF_SCENE}.items()
                       if name in values})
        return cls(**{name: bool(value) if isinstance(getattr(cls, name), bool) else value
                      for name, value in values.items()})

    def _to_struct(self) -> _c.Conventions:
        values = dict(vars(self))
        for name, words in _WORDS.items():
            values[name] = _checks.choice(values[name], f"conventions: {name}", words)
        if values["blur"] is not None and not _checks.real(values["blur"], "conventions: blur") >= 0:
            raise InvalidArgument(f"conventions: blur is {values['blur']}, expected 0 or more, or None")
        for name, words in _WORDS_OR_OF_SCENE.items():
            if values[name] is not None:
                values[name] = _checks.choice(values[name], f"conventions: {name}", words)
        return _c.Conventions(**{name: _c.OF_SCENE if value is None else value for name, value in values.items()})


#: Members that are words here and numbers in C.
_WORDS = {"clamp": _c.CLAMPS, "depth": _c.DEPTHS, "depth_at": _c.DEPTHS_AT}
_WORDS_OR_OF_SCENE = {"order": _c.ORDERS, "colours": _c.COLOURS, "antialiased": (False, True)}


@functools.lru_cache(maxsize=64)
def _struct_of(given: Union[str, Conventions]) -> _c.Conventions:
    """Shared by all frames of these conventions, and never changed."""
    if isinstance(given, Conventions):
        return given._to_struct()
    struct = _c.Conventions()
    lib.conventions_named(_checks.text(given, "conventions"), ctypes.byref(struct))
    return struct


def conventions_of(given: Union[str, Conventions]) -> _c.Conventions:
    if not isinstance(given, (str, Conventions)):
        raise InvalidType(f"conventions are of type {type(given).__name__}, expected the name of a preset or Conventions")
    try:
        return _struct_of(given)
    except TypeError:  # no number, such as a list, which the cache does not take
        if isinstance(given, str):
            raise
        return given._to_struct()


def check_cameras(cameras: Union[Camera, Sequence[Camera]]) -> List[Camera]:
    """A list of one camera or more."""
    if isinstance(cameras, Camera):
        return [cameras]
    found = _checks.listed(cameras, "cameras")
    for index, camera in enumerate(found):
        _checks.of_type(camera, Camera, f"camera {index}")
    if not found:
        raise InvalidArgument("there is no camera, expected one or more")
    return found
