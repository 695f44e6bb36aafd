# SPDX-License-Identifier: Apache-2.0
"""Arguments as the library takes them, or a refusal that names them."""
import operator
import os
from typing import Any, Optional, Sequence, Tuple

import numpy as np

from ._errors import InvalidArgument, InvalidType


def whole(value: Any, what: str, least: int = -2**31, below: int = 2**31) -> int:
    """A whole number from `least` on."""
    try:
        found = operator.index(value)
    except TypeError:
        raise InvalidType(f"{what} is {value!r}, expected a whole number") from None
    if not least <= found < below:
        expected = f"{least} or more" if found < least and below >= 2**31 else f"{least} to {below - 1}"
        raise InvalidArgument(f"{what} is {found}, expected {expected}")
    return found


def real(value: Any, what: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise InvalidType(f"{what} is {value!r}, expected a number") from None


def reals(value: Any, what: str, *shapes: Tuple[int, ...], dtype: Any = np.float64) -> np.ndarray:
    """Numbers of one of the shapes, if there are some."""
    try:
        found = np.asarray(value, dtype)
    except (TypeError, ValueError, OverflowError):
        raise InvalidType(f"{what} is {value!r}, expected numbers") from None
    if shapes and found.shape not in shapes:
        raise InvalidArgument(f"{what} has the shape {found.shape}, expected {' or '.join(map(str, shapes))}")
    return found


def finite(value: Any, what: str, *shapes: Tuple[int, ...]) -> np.ndarray:
    found = reals(value, what, *shapes)
    if not np.isfinite(found).all():
        raise InvalidArgument(f"{what} is {found.tolist()}, expected finite numbers")
    return found


def choice(value: Any, what: str, words: Sequence[Optional[str]]) -> int:
    """Where a word is among those that there are."""
    found = [index for index, word in enumerate(words) if type(value) is type(word) and value == word]
    if not found:
        raise InvalidArgument(f"{what} is {value!r}, expected one of {', '.join(map(str, words))}")
    return found[0]


def text(value: Any, what: str) -> bytes:
    if not isinstance(value, str):
        raise InvalidType(f"{what} is {value!r}, expected a text")
    return _whole_text(value.encode(errors="replace"), what)


def path(value: Any) -> bytes:
    try:
        found = os.fsencode(value)
    except TypeError:
        raise InvalidType(f"path is {value!r}, expected a text or an os.PathLike") from None
    return _whole_text(found, "path")


def _whole_text(found: bytes, what: str) -> bytes:
    if b"\0" in found:  # where a text of C ends
        raise InvalidArgument(f"{what} is {found!r}, expected a text without zeros")
    return found


def of_type(value: Any, kind: type, what: str, hint: str = "") -> Any:
    if not isinstance(value, kind):
        raise InvalidType(f"{what} is of type {type(value).__name__}, expected swiftgs.{kind.__name__}{hint}")
    return value


def listed(value: Any, what: str) -> list:
    """The elements of a sequence."""
    try:
        return list(value)
    except TypeError:
        raise InvalidType(f"{what} is {value!r}, expected a sequence") from None
