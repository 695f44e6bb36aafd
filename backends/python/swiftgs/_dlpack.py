# SPDX-License-Identifier: Apache-2.0
"""DLPack, read and offered without a library. See https://dmlc.github.io/dlpack for the structs."""
import ctypes
import functools
from ctypes import c_int32, c_int64, c_uint8, c_uint16, c_uint64, c_void_p
from typing import Any, Dict

CPU, CUDA, CUDA_HOST, CUDA_MANAGED = 1, 2, 3, 13
_KINDS = {0: "i", 1: "u", 2: "f", 4: "bf", 5: "c", 6: "b"}


class _Tensor(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("device_type", c_int32), ("device_id", c_int32), ("ndim", c_int32),
                ("code", c_uint8), ("bits", c_uint8), ("lanes", c_uint16), ("shape", ctypes.POINTER(c_int64)),
                ("strides", ctypes.POINTER(c_int64)), ("byte_offset", c_uint64)]


class _Managed(ctypes.Structure):
    _fields_ = [("tensor", _Tensor), ("context", c_void_p), ("deleter", c_void_p)]


def _python_function(name, result, *arguments):
    """By address alone, where the object may be one that is being destroyed."""
    return ctypes.PYFUNCTYPE(result, *arguments)((name, ctypes.pythonapi))


_pointer_of = _python_function("PyCapsule_GetPointer", c_void_p, ctypes.py_object, ctypes.c_char_p)
_pointer_of_dying = _python_function("PyCapsule_GetPointer", c_void_p, c_void_p, ctypes.c_char_p)
_is_valid_dying = _python_function("PyCapsule_IsValid", ctypes.c_int, c_void_p, ctypes.c_char_p)
_new_capsule = _python_function("PyCapsule_New", ctypes.py_object, c_void_p, ctypes.c_char_p, c_void_p)


def read(capsule):
    """(address, shape, strides in bytes, kind with bytes such as "f4", device type, device) of a capsule. It keeps the
    memory: hold it as long as the address is used."""
    tensor = _Managed.from_address(_pointer_of(capsule, b"dltensor")).tensor
    shape = tuple(tensor.shape[:tensor.ndim])
    item = tensor.bits * tensor.lanes // 8
    if tensor.strides:
        strides = tuple(stride * item for stride in tensor.strides[:tensor.ndim])
    else:
        strides = dense_strides(shape, item)
    kind = f"{_KINDS.get(tensor.code, '?')}{item}"
    return (tensor.data or 0) + tensor.byte_offset, shape, strides, kind, tensor.device_type, tensor.device_id


@functools.lru_cache(maxsize=256)
def dense_strides(shape, item):
    """Strides in bytes of an array without gaps, the last index the quickest."""
    strides = []
    for side in reversed(shape):
        strides.append(item)
        item *= side
    return tuple(reversed(strides))


# What was offered and not yet given back, by address.
_offered: Dict[int, Any] = {}


@ctypes.CFUNCTYPE(None, c_void_p)
def _delete(address):
    _offered.pop(address, None)


@ctypes.PYFUNCTYPE(None, c_void_p)
def _destroy(capsule):
    if _is_valid_dying(capsule, b"dltensor"):  # nobody took it
        _offered.pop(_pointer_of_dying(capsule, b"dltensor"), None)


def offer(owner, address, shape, device):
    """A capsule of float32 without gaps on a CUDA device. `owner` lives until it is given back."""
    sides = (c_int64 * len(shape))(*shape)
    strides = (c_int64 * len(shape))(*(stride // 4 for stride in dense_strides(shape, 4)))
    managed = _Managed(_Tensor(address, CUDA, device, len(shape), 2, 32, 1, sides, strides, 0), None,
                       ctypes.cast(_delete, c_void_p))
    place = ctypes.addressof(managed)
    _offered[place] = (managed, sides, strides, owner)
    return _new_capsule(place, b"dltensor", ctypes.cast(_destroy, c_void_p))
