# SPDX-License-Identifier: Apache-2.0
"""Arrays of any library, without a copy and without importing the library.

NumPy arrays are read as they are, usual tensors of PyTorch by their own members, which are quicker than DLPack, others
by DLPack, or else by the interface of CUDA arrays. A library is touched only if an array of it was given, so that it
has been imported already.
"""
import ctypes
import functools
import importlib
import sys
from typing import Any, Dict, Iterable, NamedTuple, Optional, Tuple

import numpy as np

from . import _checks, _dlpack
from ._c import Handle, lib
from ._errors import InvalidArgument, InvalidType, NotLent


# Libraries that are known by name, and touched only where arrays of theirs were given.
LIBRARIES = ("torch", "cupy", "jax")


class Memory(NamedTuple):
    """Where an array lies."""

    address: int
    shape: Tuple[int, ...]
    strides: Tuple[int, ...]  # bytes
    kind: str  # such as "f4"
    device: Optional[int]  # of CUDA; None: the host
    writable: bool
    owner: Any  # keeps the memory

    @property
    def place(self) -> str:
        return "the host" if self.device is None else f"CUDA device {self.device}"


NOWHERE = Memory(0, (), (), "", None, False, None)


def library_of(array: Any) -> str:
    """The library that an array's type belongs to, or is derived from."""
    kind: Any = type(array)
    return _library_of_type(kind)


@functools.lru_cache(maxsize=64)
def _library_of_type(kind: type) -> str:
    for base in kind.__mro__:
        name = base.__module__.partition(".")[0]
        if name in LIBRARIES:
            return name
        if name == "jaxlib":
            return "jax"
    return kind.__module__.partition(".")[0]


def read(array: Any, what: str, stream: Optional[int] = 0) -> Memory:
    """Where `array` lies. On a device it is ready for work on `stream`, unless that is None. InvalidType for what is
    no array."""
    if isinstance(array, np.ndarray):
        return _of_interface(array.__array_interface__, None, array)
    library = library_of(array)
    if library == "torch":
        torch = sys.modules["torch"]
        if array.requires_grad and torch.is_grad_enabled():
            raise InvalidArgument(f"{what} requires gradients, expected none: swiftgs renders forward only. Call it "
                                  "under torch.no_grad(), or give it tensors after detach()")
        usual = _usual_tensor(array.dtype, array.device, array.layout is torch.strided)
        if usual:
            kind, device = usual
            if device is not None and stream is not None:
                _make_ready(array, device, stream)
            return Memory(array.data_ptr(), tuple(array.shape), _in_bytes(array.stride(), kind), kind, device, True,
                          array)
        array = array.detach()
    if hasattr(array, "__dlpack_device__"):
        kind, device = array.__dlpack_device__()
        kind = int(kind)
        if kind not in (_dlpack.CPU, _dlpack.CUDA, _dlpack.CUDA_HOST, _dlpack.CUDA_MANAGED):
            raise InvalidType(f"{what} lies on a device of DLPack's type {kind}, expected the host or a CUDA device")
        on_device = kind in (_dlpack.CUDA, _dlpack.CUDA_MANAGED)
        # DLPack calls the default stream 1, and none -1.
        capsule = array.__dlpack__(stream=-1 if stream is None else stream or 1) if on_device else array.__dlpack__()
        address, shape, strides, code, _, _ = _dlpack.read(capsule)
        return Memory(address, shape, strides, code, int(device) if on_device else None, library != "jax",
                      (capsule, array))
    interface = getattr(array, "__cuda_array_interface__", None)
    if interface is not None:
        ready = interface.get("stream")
        if ready is not None and stream is not None:
            lib.device_order(ready, stream)
        return _of_interface(interface, current_device(), array)
    raise InvalidType(f"{what} is of type {type(array).__name__}, expected an array with DLPack or "
                      "__cuda_array_interface__, or of NumPy")


def _make_ready(array: Any, device: int, stream: int) -> None:
    """Orders later work on `stream` after the current stream of the array's library."""
    ready = stream_of(array, device) or 0
    if ready != stream and device == current_device():  # others are refused
        lib.device_order(ready or None, stream or None)


@functools.lru_cache(maxsize=256)
def _in_bytes(strides: Tuple[int, ...], kind: str) -> Tuple[int, ...]:
    return tuple(int(kind[1:]) * step for step in strides)


@functools.lru_cache(maxsize=64)
def _usual_tensor(dtype: Any, device: Any, strided: bool) -> Optional[Tuple[str, Optional[int]]]:
    """The kind, such as "f4", and the CUDA device of a tensor that its own members describe; None if DLPack has to,
    such as for types that NumPy lacks."""
    try:
        found = np.dtype(str(dtype).rpartition(".")[2])
    except TypeError:
        return None
    if not strided or device.type not in ("cpu", "cuda") or found.kind not in "fiu":
        return None
    return found.str.lstrip("<|="), device.index if device.type == "cuda" else None


def _of_interface(interface, device, owner):
    shape = tuple(interface["shape"])
    kind, item = _kind_of(interface["typestr"])
    strides = interface.get("strides") or _dlpack.dense_strides(shape, item)
    address, read_only = interface["data"]
    return Memory(address or 0, shape, tuple(strides), kind, device, not read_only, owner)


@functools.lru_cache(maxsize=64)
def _kind_of(typestr: str) -> Tuple[str, int]:
    """Such as "f4", and its bytes."""
    kind = "!" + typestr if typestr[0] == ">" else typestr.lstrip("<|=")
    return kind, int("".join(filter(str.isdigit, kind)) or 0)


def device_of(array: Any) -> Optional[int]:
    """The CUDA device where an array lies; None: the host."""
    usual = _usual_tensor(array.dtype, array.device, True) if library_of(array) == "torch" else None
    if usual:
        return usual[1]
    if hasattr(array, "__dlpack_device__"):
        kind, number = array.__dlpack_device__()
        return int(number) if int(kind) in (_dlpack.CUDA, _dlpack.CUDA_MANAGED) else None
    return current_device() if hasattr(array, "__cuda_array_interface__") else None


def current_device() -> int:
    device = ctypes.c_int32()
    lib.device_current(ctypes.byref(device))
    return device.value


def stream_of(array: Any, device: int) -> Optional[int]:
    """The stream that the array's library works on now; None where it does not tell."""
    library = library_of(array)
    if library == "torch":
        return sys.modules["torch"].cuda.current_stream(device).cuda_stream
    if library == "cupy":
        return sys.modules["cupy"].cuda.get_current_stream().ptr
    if isinstance(array, DeviceArray):
        return array.stream
    return None


def whose_stream(array: Any) -> Any:
    """A key of the array's stream: a library has one for all its arrays, each `DeviceArray` its own."""
    return array if isinstance(array, DeviceArray) else library_of(array)


def one_of_each_stream(arrays: Iterable[Any]) -> Dict[Any, Any]:
    """One array for each stream, by `whose_stream`."""
    return {whose_stream(array): array for array in arrays}


def stream_handle(stream: Any) -> int:
    """The `cudaStream_t` of a number, or of a stream of PyTorch, CuPy or any library with `__cuda_stream__`."""
    if stream is None:
        return 0
    if hasattr(stream, "__cuda_stream__"):
        return int(stream.__cuda_stream__()[1])
    for member in ("cuda_stream", "ptr"):
        if hasattr(stream, member):
            return int(getattr(stream, member))
    if isinstance(stream, int):
        return _checks.whole(stream, "stream", 0, 2**64)
    raise InvalidType(f"stream is of type {type(stream).__name__}, expected a stream of PyTorch or CuPy, an object "
                      "with __cuda_stream__, or the number of a cudaStream_t")


def contiguous(array: Any) -> Any:
    """The same numbers without gaps, by the array's own library."""
    library = library_of(array)
    if library == "torch":
        return array.contiguous()
    if library == "cupy":
        return sys.modules["cupy"].ascontiguousarray(array)
    if isinstance(array, np.ndarray):
        return np.ascontiguousarray(array)
    if library == "jax":
        return array
    raise InvalidArgument(f"an array of type {type(array).__name__} has gaps, expected one without")


def host(array: Any, what: str) -> np.ndarray:
    """The numbers as an array of NumPy. Waits for those of a device."""
    if isinstance(array, np.ndarray):
        return array
    if isinstance(array, (list, tuple, float, int)):
        return _checks.reals(array, what)
    found = read(array, what)
    if found.strides != _dlpack.dense_strides(found.shape, int(found.kind[1:])) and np.prod(found.shape) > 1:
        array = contiguous(array)
        found = read(array, what)
    if not found.kind.startswith(("f", "i", "u")):
        raise InvalidType(f"{what} has the type {found.kind}, expected real numbers")
    copy = np.empty(found.shape, np.dtype(found.kind))
    if found.device is None:
        ctypes.memmove(copy.ctypes.data, found.address, copy.nbytes)
    else:
        lib.device_copy(copy.ctypes.data, found.address, copy.nbytes, 0)
    return copy


def empty(like: Any, shape: Tuple[int, ...], device: Optional[int]) -> Any:
    """Memory for float32 beside `like`, by its library where that can be written to."""
    library = library_of(like)
    if library == "torch":
        torch = sys.modules["torch"]
        return torch.empty(shape, dtype=torch.float32, device=like.device)
    if library == "cupy" and device is not None:
        return sys.modules["cupy"].empty(shape, np.float32)
    return np.empty(shape, np.float32) if device is None else DeviceArray(shape, device)


def address_of(array: Any) -> int:
    """Where an array of `empty` begins."""
    library = library_of(array)
    if library == "torch":
        return array.data_ptr()
    if library == "cupy":
        return array.data.ptr
    return array.ctypes.data if isinstance(array, np.ndarray) else array._memory.pointer


def returned(like: Any, array: Any) -> Any:
    """What `empty` made as an array of the library of `like`."""
    if library_of(like) != "jax":
        return array
    jax = sys.modules["jax"]
    if isinstance(array, np.ndarray):
        return jax.device_put(array, next(iter(like.devices())))
    return importlib.import_module("jax.dlpack").from_dlpack(array)


def concatenate(like: Any, arrays: Any) -> Any:
    """Along the last axis, by the library of `like`."""
    library = library_of(like)
    if library == "torch":
        return sys.modules["torch"].cat(arrays, dim=-1)
    if library == "cupy":
        return sys.modules["cupy"].concatenate(arrays, axis=-1)
    if library == "jax":
        return sys.modules["jax"].numpy.concatenate(arrays, axis=-1)
    return np.concatenate(arrays, axis=-1)


class DeviceArray:
    """Float32 in the memory of a CUDA device, for libraries that cannot lend theirs.

    `torch.from_dlpack`, `cupy.from_dlpack`, `jax.dlpack.from_dlpack` and all that know `__cuda_array_interface__` take
    it without a copy.
    """

    def __init__(self, shape: Tuple[int, ...], device: Optional[int] = None) -> None:
        self.shape = tuple(_checks.whole(side, "shape", 0) for side in _checks.listed(shape, "shape"))
        self.device = current_device() if device is None else _checks.whole(device, "device", 0)
        self.stream = 0  # of the work that writes it
        self._stream_owner: Any = None  # keeps the stream
        bytes_ = int(np.prod(self.shape, dtype=np.int64)) * 4
        self._memory = Handle(lib.device_free, lib.device_allocate, max(bytes_, 4))

    @property
    def dtype(self) -> "np.dtype[Any]":
        return np.dtype(np.float32)

    @property
    def __cuda_array_interface__(self) -> Any:
        return {"shape": self.shape, "typestr": "<f4", "data": (self._memory.pointer, False), "strides": None,
                "version": 3, "stream": self.stream or 1}

    def __dlpack_device__(self) -> Tuple[int, int]:
        return _dlpack.CUDA, self.device

    def __dlpack__(self, *, stream: Any = None, max_version: Any = None, dl_device: Any = None,
                   copy: Any = None) -> Any:
        if dl_device not in (None, self.__dlpack_device__()) or copy:
            raise NotLent("a DeviceArray is offered where it lies, expected neither another device nor a copy")
        if stream == 0:
            raise InvalidArgument("stream is 0, expected None, -1, 1, 2 or the number of a cudaStream_t")
        if stream != -1:
            lib.device_order(self.stream, stream or 1)
        return _dlpack.offer(self._memory, self._memory.pointer, self.shape, self.device)

    def numpy(self) -> np.ndarray:
        """A copy on the host. Waits."""
        copy = np.empty(self.shape, np.float32)
        lib.device_copy(copy.ctypes.data, self._memory.pointer, copy.nbytes, self.stream)
        return copy

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        if copy is False:
            raise InvalidArgument("a DeviceArray comes to the host as a copy only, expected copy=None or True")
        found = self.numpy()
        return found if dtype is None else found.astype(dtype)

    def __repr__(self) -> str:
        return f"<swiftgs.DeviceArray of {self.shape}, float32, on CUDA device {self.device}>"


class LentArray:
    """Numbers that lie in a renderer's memory, for libraries of arrays to view: `numpy.asarray` on the host,
    `torch.as_tensor(array, device="cuda")`, `cupy.asarray` and all that know `__cuda_array_interface__` on a device."""

    def __init__(self, handle: Handle, address: int, shape: Tuple[int, ...], strides: Tuple[int, ...], kind: str,
                 device: Optional[int], stream: int) -> None:
        self.shape, self.device = shape, device
        self._handle = handle  # keeps the renderer
        interface = {"shape": shape, "typestr": f"<{kind}", "data": (address, False), "strides": strides, "version": 3}
        if device is None:
            self.__array_interface__ = interface
        else:
            self.__cuda_array_interface__ = {**interface, "stream": stream or 1}
