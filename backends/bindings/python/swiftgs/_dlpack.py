# SPDX-License-Identifier: Apache-2.0
"""DLPack, read and offered without a library. See https://dmlc.github.io/dlpack for the structs."""
import ctypes
import functools
from ctypes import c_int32, c_int64, c_uint8, c_uint16, c_uint64, c_void_p

import numpy as np

from ._c import OwnedFloats

CPU, CUDA, CUDA_HOST, CUDA_MANAGED = 1, 2, 3, 13
_KINDS = {0: "i", 1: "u", 2: "f", 4: "bf", 5: "c", 6: "b"}


class _Tensor(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("device_type", c_int32), ("device_id", c_int32), ("ndim", c_int32),
                ("code", c_uint8), ("bits", c_uint8), ("lanes", c_uint16), ("shape", ctypes.POINTER(c_int64)),
                ("strides", ctypes.POINTER(c_int64)), ("byte_offset", c_uint64)]


class _Managed(ctypes.Structure):
    _fields_ = [("tensor", _Tensor), ("context", c_void_p), ("deleter", c_void_p)]


_pointer_of = ctypes.PYFUNCTYPE(c_void_p, ctypes.py_object, ctypes.c_char_p)(("PyCapsule_GetPointer", ctypes.pythonapi))


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


def offer(owner, address, shape, device):
    """A capsule of float32 without gaps on a CUDA device. `owner` lives until it is given back.

    NumPy makes it, of an array that nobody reads, and then its device is changed. So NumPy's C functions give it back:
    they run on any thread and keep a pending exception, which a callback in Python would lose.
    """
    capsule = np.asarray(OwnedFloats(owner, address, shape, read_only=False)).__dlpack__()
    tensor = _Managed.from_address(_pointer_of(capsule, b"dltensor")).tensor
    tensor.device_type, tensor.device_id = CUDA, device
    return capsule
