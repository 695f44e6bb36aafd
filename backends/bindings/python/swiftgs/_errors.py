# SPDX-License-Identifier: Apache-2.0
"""Exceptions. Each is also the exception of Python that says the same."""
from typing import Dict, Type


class Error(Exception):
    """What the library refused, in one line: what, where and what was expected. `code` is the number that the
    interfaces of C and C++ give it."""

    code = 10
    __str__ = Exception.__str__  # a KeyError's own is the text's `repr`


class InvalidArgument(Error, ValueError):
    """An argument that a function does not take."""

    code = 1


class InvalidType(InvalidArgument, TypeError):
    """An argument of another type than a function takes."""


class NotOffered(InvalidArgument, NotImplementedError):
    """An argument that gsplat takes and `rasterization` does not."""


class NotLent(InvalidArgument, BufferError):
    """An array lies elsewhere than DLPack was asked for."""


class NoSuchResult(Error, KeyError):
    """What gsplat returns in `meta` and `rasterization` does not."""

    code = 1


class FormatError(Error, ValueError):
    """A file is invalid; the text has its name and the byte."""

    code = 2


class Cancelled(Error):
    """A `progress` asked to stop."""

    code = 3


class FileError(Error, OSError):
    """The system refused, such as a file that is not there."""

    code = 4


class DeviceError(Error, RuntimeError):
    """A call to a device failed; the text has the call and the device's own text."""

    code = 5


class CapacityError(Error, RuntimeError):
    """A frame exceeds a limit or the device's memory; the renderer stays usable."""

    code = 6


class OrderError(Error, RuntimeError, ValueError):
    """A call out of turn, such as a frame before a scene, or of what is closed, for which Python's files raise a
    ValueError."""

    code = 7


class OutOfMemory(Error, MemoryError):
    """Memory of the host ran out; the renderer stays usable."""

    code = 8


class Unavailable(Error, RuntimeError):
    """This machine or this build cannot do it."""

    code = 9


class InternalError(Error, RuntimeError):
    """A defect of the library."""


_BY_CODE: Dict[int, Type[Error]] = {kind.code: kind for kind in (
    InvalidArgument, FormatError, Cancelled, FileError, DeviceError, CapacityError, OrderError, OutOfMemory, Unavailable)}


def exception_of(status: int, text: str) -> Error:
    """The exception of a status of the C interface."""
    return _BY_CODE.get(status, InternalError)(text)
