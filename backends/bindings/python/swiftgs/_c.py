# SPDX-License-Identifier: Apache-2.0
"""The C interface: its structs, and its functions as those of `lib`.

Names are those of include/swiftgs/c without their prefix. A test compares the layouts with the record of the binary
interface. Every function that returns a status raises the exception of that status.
"""
import ctypes
import os
import pathlib
from ctypes import c_char_p, c_double, c_float, c_int32, c_int64, c_size_t, c_uint32, c_uint64, c_void_p

from typing import Any, NamedTuple, Optional

from ._errors import InvalidArgument, InvalidType, exception_of

ABI_MAJOR, ABI_MINOR = 2, 2

MEASURE_COUNTS, MEASURE_TIMES = 1, 2
HOST, DEVICE = 0, 1
LOG_SCALES, LOGIT_OPACITIES, ANY_ROTATIONS, PLAIN_COLOURS = 1, 2, 4, 8
CLAMPS = ("around-image", "around-centre")
FOOTPRINTS = ("alpha", "three-sigma-square", "three-sigma-ellipse")
DEPTHS = ("of-lens", "z", "distance")
DEPTHS_AT = ("centre", "ray")
OF_SCENE = -1
ORDERS = ("depth", "distance")
COLOURS = ("srgb", "linear")
KERNELS = ("ellipsoid", "disk")
LENSES = ("perspective", "fisheye", "orthographic", "equirectangular")
CLIP_SPACES = ("opengl", "vulkan", "direct3d")
HARMONICS = ("float", "smallest", "half")
NOTHING: int = 0xffffffff  #: in place of the index of a Gaussian: there is none
MAX_PICK_SIDE = 64
SPZ_AXES = ("specified", "rub", "rdf", "luf", "raw")

PROGRESS = ctypes.CFUNCTYPE(c_int32, c_void_p, c_double)
NOTE = ctypes.CFUNCTYPE(None, c_void_p, c_char_p)
TAKE_BYTES = ctypes.CFUNCTYPE(None, c_void_p, c_void_p, c_uint64)


class Plane(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("pitch", c_int64)]


class PlaneKind(NamedTuple):
    """What one pixel of a plane is."""

    kind: str
    channels: Optional[int]  # None: any number


_SCALAR, _ID = PlaneKind("f4", 1), PlaneKind("u4", 1)
#: Planes that a frame may have beside colour, in the order of the structs.
PLANES = {"alpha": _SCALAR, "depth": _SCALAR, "squared_depth": _SCALAR, "first_depth": _SCALAR,
          "median_depth": _SCALAR, "normal": PlaneKind("f4", 3), "id": _ID, "median_id": _ID,
          "features": PlaneKind("f4", None)}
_PLANES = [(name, Plane) for name in PLANES]


class Array(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("stride", c_int64)]


class _Sized(ctypes.Structure):
    """A struct that begins with its size."""

    def __init__(self, **members):
        super().__init__(size=ctypes.sizeof(self))
        for name, given in members.items():
            try:
                setattr(self, name, given)
            except (TypeError, ValueError, OverflowError):
                raise InvalidType(f"{name} is {given!r}, expected what its {type(self).__name__} can hold") from None
            kept = getattr(self, name)
            if isinstance(kept, int) and hasattr(given, "__index__") and kept != given:
                raise InvalidArgument(f"{name} is {given}, expected a number that its {type(self).__name__} can hold")


class Camera(_Sized):
    _fields_ = [("size", c_uint32), ("width", c_int32), ("height", c_int32), ("lens", c_int32),
                ("rotation", c_double * 9), ("translation", c_double * 3), ("fx", c_double), ("fy", c_double),
                ("cx", c_double), ("cy", c_double), ("radial", c_double * 4), ("rational", c_double * 3),
                ("tangential", c_double * 2), ("prism", c_double * 2)]


class LookAt(_Sized):
    _fields_ = [("size", c_uint32), ("width", c_int32), ("height", c_int32), ("reserved", c_uint32),
                ("eye", c_double * 3), ("target", c_double * 3), ("up", c_double * 3), ("vertical_fov", c_double)]


class Matrices(_Sized):
    _fields_ = [("size", c_uint32), ("clip_space", c_int32), ("width", c_int32), ("height", c_int32),
                ("view", c_double * 16), ("projection", c_double * 16)]


class Orbit(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("target", c_double * 3), ("up", c_double * 3),
                ("turn", c_double), ("rise", c_double), ("distance", c_double)]


class Conventions(_Sized):
    _fields_ = [("size", c_uint32), ("near_plane", c_float), ("cull_at_near", c_int32), ("far_plane", c_float),
                ("clamp", c_int32), ("blur", c_float), ("antialiased", c_int32), ("min_compensation", c_float),
                ("alpha_min", c_float), ("alpha_max", c_float), ("stop", c_float), ("stop_at_equal", c_int32),
                ("footprint", c_int32), ("depth", c_int32), ("first_alpha", c_float), ("depth_at", c_int32), ("order", c_int32),
                ("colours", c_int32)]


class StoredDepth(ctypes.Structure):
    _fields_ = [("p", c_double), ("q", c_double), ("r", c_double), ("s", c_double)]


class View(_Sized):
    _fields_ = [("size", c_uint32), ("format", c_int32), ("width", c_int32), ("height", c_int32),
                ("camera", c_void_p), ("conventions", c_void_p), ("colour", Plane), *_PLANES[:2],
                ("occluder", Plane), ("over", c_int32), ("left", c_int32), ("top", c_int32),
                ("background", c_float * 3), ("stored_depth", StoredDepth), *_PLANES[2:],
                ("feature_channels", c_int32), ("conversion", c_int32), ("first_shown", c_uint32),
                ("shown_count", c_uint32)]


class Frame(_Sized):
    _fields_ = [("size", c_uint32), ("measure", c_uint32), ("views", c_void_p), ("count", c_uint64)]


class Image(_Sized):
    _fields_ = [("size", c_uint32), ("width", c_int32), ("height", c_int32), ("feature_channels", c_int32),
                ("colour", Plane), *_PLANES, ("format", c_int32), ("over", c_int32), ("background", c_float * 3),
                ("reserved", c_uint32)]


class Pixels(_Sized):
    _fields_ = [("size", c_uint32), ("width", c_int32), ("height", c_int32), ("channels", c_int32),
                ("data", c_void_p)]


class RendererEntry(_Sized):
    _fields_ = [("size", c_uint32), ("usable", c_int32), ("name", c_char_p), ("on_device", c_int32),
                ("reserved", c_uint32)]


class RendererOptions(_Sized):
    _fields_ = [("size", c_uint32), ("threads", c_int32), ("stream", c_void_p), ("allocate", c_void_p),
                ("release", c_void_p), ("context", c_void_p), ("harmonics", c_int32), ("reserved", c_uint32)]


class Placement(_Sized):
    _fields_ = [("size", c_uint32), ("half_space_count", c_int32), ("scene", c_uint64), ("rotation", c_double * 9),
                ("scale", c_double), ("translation", c_double * 3), ("transparency", c_double),
                ("half_spaces", c_float * 24), ("centre", c_float * 3), ("radius", c_float), ("first", c_uint64),
                ("count", c_uint64), ("tint", c_float * 3), ("tint_amount", c_float)]


class RecordedScenes(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("count", c_uint64), ("stride", c_int64),
                ("rotation", c_void_p), ("scale", c_void_p), ("translation", c_void_p), ("opacity", c_void_p),
                ("tint", c_void_p)]


class Capacity(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("splats", c_uint64), ("intersections", c_uint64)]


class Report(ctypes.Structure):
    _fields_ = [("visible", c_uint64), ("intersections", c_uint64), ("overflowed", c_uint64)]


class Picked(ctypes.Structure):
    _fields_ = [("gaussian", c_uint32), ("weight", c_float), ("depth", c_float), ("median", c_uint32),
                ("median_depth", c_float)]


class Times(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("project", c_double), ("sort", c_double),
                ("raster", c_double), ("total", c_double)]


class Statistics(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("gaussians", c_uint64), ("visible", c_uint64),
                ("intersections", c_uint64), ("intersections_visited", c_uint64), ("rows_visited", c_uint64),
                ("contributing_pairs", c_uint64), ("pixels_stopped", c_uint64),
                ("intersections_hidden", c_uint64)]


class Memory(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("project", c_uint64), ("sort", c_uint64),
                ("raster", c_uint64), ("device_in_use", c_uint64), ("device_total", c_uint64)]


class ReadOptions(_Sized):
    _fields_ = [("size", c_uint32), ("spz_axes", c_int32), ("level", c_int32), ("reserved", c_uint32),
                ("progress", PROGRESS), ("note", NOTE), ("context", c_void_p)]


class WriteOptions(_Sized):
    _fields_ = [("size", c_uint32), ("spz_version", c_int32), ("spz_axes", c_int32), ("reserved", c_uint32),
                ("ending", c_char_p), ("progress", PROGRESS), ("note", NOTE), ("context", c_void_p)]


class FileBytes(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("data", c_void_p), ("count", c_uint64),
                ("name", c_char_p)]


class Gaussians(_Sized):
    _fields_ = [("size", c_uint32), ("sh_degree", c_int32), ("count", c_uint64), ("means", Array),
                ("scales", Array), ("rotations", Array), ("opacities", Array), ("sh0", Array), ("sh_rest", Array),
                ("memory", c_int32), ("raw", c_uint32), ("antialiased", c_int32), ("feature_channels", c_int32),
                ("stream", c_void_p), ("features", Array), ("origin", c_double * 3), ("blur", c_float),
                ("order", c_int32), ("colours", c_int32), ("kernel", c_int32)]


class SceneInfo(_Sized):
    _fields_ = [("size", c_uint32), ("sh_degree", c_int32), ("count", c_uint64), ("stored", c_uint64),
                ("dropped", c_uint64), ("lower", c_float * 3), ("upper", c_float * 3), ("antialiased", c_int32),
                ("feature_channels", c_int32), ("format", c_char_p), ("origin", c_double * 3), ("blur", c_float),
                ("order", c_int32), ("colours", c_int32), ("kernel", c_int32)]


class SceneBounds(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("low", c_double * 3), ("high", c_double * 3),
                ("centre", c_double * 3), ("radius", c_double)]


class PagesInfo(_Sized):
    _fields_ = [("size", c_uint32), ("sh_degree", c_int32), ("gaussians", c_uint64), ("pages", c_uint64),
                ("page_size", c_uint64), ("origin", c_double * 3), ("lower", c_float * 3), ("upper", c_float * 3)]


class PoolOptions(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("bytes", c_uint64), ("upload_per_frame", c_uint64),
                ("waiting", c_uint64), ("estimate", c_uint64)]


class CutGoal(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("pixels", c_double), ("splats", c_uint64),
                ("blend", c_double)]


class Cut(_Sized):
    _fields_ = [("size", c_uint32), ("is_settled", c_int32), ("splats", c_uint64), ("wanted", c_uint64),
                ("missing", c_uint64), ("pixels", c_double), ("resident", c_uint64), ("bytes", c_uint64),
                ("failure", c_char_p), ("scenes", c_uint64), ("estimated_db", c_double)]


class NamedNode(_Sized):
    _fields_ = [("size", c_uint32), ("is_gaussian", c_int32), ("scene", c_uint64), ("page", c_uint32),
                ("number", c_uint32)]


def _load():
    """The library that SWIFTGS_LIBRARY names, or else that of this package, or else that of the system."""
    beside = pathlib.Path(__file__).with_name(f"libswiftgs_c.so.{ABI_MAJOR}")
    path = os.environ.get("SWIFTGS_LIBRARY") or (str(beside) if beside.exists() else beside.name)
    try:
        library = ctypes.CDLL(path)
    except OSError as error:
        raise ImportError(f"swiftgs: the library '{path}' cannot be loaded: {error}. Install the package, or name "
                          "libswiftgs_c in SWIFTGS_LIBRARY") from error
    version = library.swiftgs_abi_version
    version.restype = c_uint32
    found = divmod(version(), 1 << 16)
    if found[0] != ABI_MAJOR or found[1] < ABI_MINOR:
        raise ImportError(f"swiftgs: the library '{path}' has the binary interface {found[0]}.{found[1]}, "
                          f"expected {ABI_MAJOR}.{ABI_MINOR} or a later {ABI_MAJOR}")
    return library


_dll = _load()
_dll.swiftgs_last_error.restype = c_char_p
_dll.swiftgs_last_error.argtypes = []


def check(status):
    if status != 0:
        raise exception_of(status, (_dll.swiftgs_last_error() or b"").decode(errors="replace"))


class _Functions:
    """Functions without their prefix."""

    def __getattr__(self, name: str) -> Any:  # tells type checkers that there are some
        raise AttributeError(f"swiftgs_{name} is not declared")

    def add(self, name: str, result: Any, *arguments: Any) -> None:
        function = getattr(_dll, f"swiftgs_{name}")
        function.restype, function.argtypes = result, arguments
        setattr(self, name, function)


lib = _Functions()
for _name, _arguments in {
        "cameras_read": (c_char_p, c_void_p),
        "cameras_count": (c_void_p, c_void_p),
        "cameras_get": (c_void_p, c_size_t, c_void_p),
        "cameras_name": (c_void_p, c_size_t, c_void_p),
        "cameras_note_count": (c_void_p, c_void_p),
        "cameras_note": (c_void_p, c_size_t, c_void_p),
        "camera_look_at": (c_void_p, c_void_p),
        "camera_scale": (c_void_p, c_double),
        "camera_from_matrices": (c_void_p, c_void_p, c_void_p),
        "camera_to_matrices": (c_void_p, c_int32, c_double, c_double, c_void_p),
        "camera_orbit": (c_void_p, c_void_p),
        "camera_builtin": (c_int32, c_int32, c_void_p),
        "conventions_named": (c_char_p, c_void_p),
        "device_current": (c_void_p,),
        "device_allocate": (c_uint64, c_void_p),
        "device_copy": (c_void_p, c_void_p, c_uint64, c_void_p),
        "device_order": (c_void_p, c_void_p),
        "image_write": (c_char_p, c_void_p),
        "png_encode": (c_void_p, TAKE_BYTES, c_void_p),
        "picture_read": (c_char_p, c_void_p),
        "picture_get": (c_void_p, c_void_p),
        "pages_open": (c_char_p, c_void_p),
        "pages_get_info": (c_void_p, c_void_p),
        "pool_create": (c_void_p, c_void_p, c_size_t, c_void_p, c_void_p),
        "pool_place": (c_void_p, c_void_p, c_size_t),
        "pool_cut": (c_void_p, c_void_p, c_void_p, c_void_p, c_void_p),
        "pool_wait": (c_void_p, c_void_p),
        "pool_named": (c_void_p, c_uint32, c_void_p),
        "renderers_count": (c_void_p,),
        "renderers_get": (c_size_t, c_void_p),
        "renderers_find": (c_char_p, c_void_p),
        "renderer_create": (c_char_p, c_void_p, c_void_p),
        "renderer_device_name": (c_void_p, c_void_p),
        "renderer_set_scene": (c_void_p, c_void_p),
        "renderer_set_gaussians": (c_void_p, c_void_p),
        "renderer_borrow_gaussians": (c_void_p, c_void_p),
        "renderer_update_scene": (c_void_p, c_uint64, c_uint64, c_void_p),
        "renderer_share_scene": (c_void_p, c_void_p),
        "renderer_add_scene": (c_void_p, c_void_p, c_void_p),
        "renderer_place": (c_void_p, c_void_p, c_size_t),
        "renderer_reserve": (c_void_p, c_void_p, c_void_p),
        "renderer_set_views": (c_void_p, c_void_p),
        "renderer_set_recorded_scenes": (c_void_p,),
        "renderer_recorded_scenes": (c_void_p, c_void_p),
        "renderer_refused_scenes": (c_void_p, c_void_p, c_size_t),
        "renderer_record": (c_void_p, c_void_p),
        "renderer_visible_by_scene": (c_void_p, c_void_p, c_size_t),
        "renderer_render": (c_void_p, c_void_p),
        "renderer_render_into": (c_void_p, c_void_p),
        "renderer_wait": (c_void_p,),
        "renderer_trim": (c_void_p,),
        "renderer_pick": (c_void_p, c_uint64, c_int32, c_int32, c_int32, c_int32, c_void_p),
        "renderer_times": (c_void_p, c_void_p),
        "renderer_statistics": (c_void_p, c_void_p),
        "renderer_memory": (c_void_p, c_void_p),
        "scene_read": (c_char_p, c_void_p, c_void_p),
        "scene_read_bytes": (c_void_p, c_void_p, c_void_p),
        "scene_from_arrays": (c_void_p, c_void_p),
        "scene_builtin": (c_uint64, c_void_p),
        "scene_get_info": (c_void_p, c_void_p),
        "scene_get_arrays": (c_void_p, c_void_p),
        "scene_get_camera": (c_void_p, c_void_p),
        "scene_robust_bounds": (c_void_p, c_void_p),
        "scene_default_view": (c_void_p, c_int32, c_int32, c_void_p, c_void_p),
        "scene_write": (c_void_p, c_char_p, c_void_p)}.items():
    lib.add(_name, check, *_arguments)
for _name in ("cameras_free", "pages_free", "picture_free", "pool_free", "renderer_free", "scene_free", "device_free"):
    lib.add(_name, None, c_void_p)
lib.add("version", c_char_p)
for _name in ("stored_perspective", "stored_orthographic"):
    lib.add(_name, StoredDepth, c_double, c_double)

# The call of every frame, without what ctypes would do for it each time: arguments are of c_void_p, and what it returns
# goes to `check` unless it is 0. A frame leaves the processor's caches cold, so that each step costs microseconds.
render = _dll["swiftgs_renderer_render"]
render.restype = c_int32


class Handle:
    """Owns what a function made, and frees it when nothing refers to it any more. A function that is given the handle
    itself keeps it until it returns."""

    __slots__ = ("pointer", "argument", "outlived_by", "_free")

    def __init__(self, free, make, *arguments, outlived_by=None):
        made = c_void_p()
        make(*arguments, ctypes.byref(made))
        self.pointer, self._free = made.value, free
        self.argument = made  #: the pointer as ctypes takes it
        self.outlived_by = outlived_by  #: what must not go before it

    @property
    def _as_parameter_(self):
        return self.pointer

    def __del__(self):
        pointer, self.pointer = getattr(self, "pointer", None), None
        if pointer:
            self._free(pointer)


class OwnedFloats:
    """Floats of a handle for NumPy, which keeps the handle."""

    def __init__(self, handle, address, shape, read_only=True):
        self.handle = handle
        self.__array_interface__ = {"shape": shape, "typestr": "<f4", "data": (address, read_only), "version": 3}


def text_of(function, *arguments):
    """The string that a function writes to its last argument."""
    text = c_char_p()
    function(*arguments, ctypes.byref(text))
    return (text.value or b"").decode(errors="surrogateescape")


def count_of(function, *arguments):
    """The number that a function writes to its last argument."""
    count = c_size_t()
    function(*arguments, ctypes.byref(count))
    return count.value
