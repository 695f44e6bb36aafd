# SPDX-License-Identifier: Apache-2.0
"""Arrays of Gaussians as the struct that the library takes."""
import functools
from typing import Any, Dict, List, Optional, Tuple

from . import _arrays, _c, _checks, _dlpack
from ._errors import InvalidArgument, InvalidType
from ._model import RenderingModel

# Names of the struct's members, and the shapes of one Gaussian.
_PARTS = {"means": (3,), "scales": (3,), "rotations": (4,), "opacities": (), "sh0": (3,)}


def _rows(array: Any, what: str, count: Optional[int], shape: Tuple[Optional[int], ...],
          stream: int) -> _arrays.Memory:
    """Float32 of `count` Gaussians, the numbers of one side by side. None in a shape stands for any length."""
    memory = _arrays.read(array, what, stream)
    if not _lies_in_rows(what, memory.kind, memory.shape, memory.strides, (count, *shape)):
        return _rows(_copied(array, what), what, count, shape, stream)
    if memory.address % 4 != 0:
        raise InvalidArgument(f"{what} begins at the address {memory.address}, expected a multiple of 4")
    return memory


@functools.lru_cache(maxsize=256)
def _lies_in_rows(what: str, kind: str, shape: Tuple[int, ...], strides: Tuple[int, ...],
                  expected: Tuple[Optional[int], ...]) -> bool:
    """Whether the library can read an array as it lies. An exception if it is not the expected one."""
    if kind != "f4":
        raise InvalidType(f"{what} has numbers of type {kind}, expected float32 (f4)")
    if len(shape) != len(expected) or any(n is not None and n != found for n, found in zip(expected, shape)):
        wanted = ", ".join("N" if n is None else str(n) for n in expected)
        raise InvalidArgument(f"{what} has the shape {shape}, expected ({wanted})")
    dense = _dlpack.dense_strides(shape, 4)
    if any(side != 1 and stride != wanted for side, stride, wanted in zip(shape[1:], strides[1:], dense[1:])):
        return False
    return shape[0] <= 1 or strides[0] >= dense[0] and strides[0] % 4 == 0


def _copied(array: Any, what: str) -> Any:
    try:
        return _arrays.contiguous(array)
    except InvalidArgument as error:
        raise InvalidArgument(f"{what}: {error}") from None


def _array(memory: _arrays.Memory, offset: int = 0) -> _c.Array:
    return _c.Array(memory.address + offset, memory.strides[0] if memory.shape[0] > 1 else 0)


def gaussians_of(means: Any, scales: Any, rotations: Any, opacities: Any, sh0: Any, sh_rest: Any = None, *,
                 sh: Any = None, sh_degree: Optional[int] = None, colours: Any = None, log_scales: bool = False,
                 logit_opacities: bool = False, any_rotations: bool = True,
                 model: RenderingModel = RenderingModel(), features: Any = None, stream: int = 0, some: bool = False,
                 names: Optional[dict] = None) -> Tuple[_c.Gaussians, List[_arrays.Memory]]:
    """The struct, and the memory that it points to, ready on `stream`.

    Colours are `sh0` [N, 3] with `sh_rest` [N, K, 3], or `sh` [N, K, 3] with both, or `colours` [N, 3] without
    harmonics. `some`: arrays that are None are left out. `names` are those of the caller's arguments.
    """
    said = (names or {}).get
    given = {"means": means, "scales": scales, "rotations": rotations, "opacities": opacities}
    if sh is None:
        given["sh0"] = sh0 if colours is None else colours
    count: Optional[int] = None
    memory: Dict[str, _arrays.Memory] = {}
    for name, array in given.items():
        if array is None and some:
            continue
        memory[name] = _rows(array, said(name, name), count, _PARTS[name], stream)
        count = memory[name].shape[0]
    struct = _c.Gaussians()
    _checks.of_type(model, RenderingModel, "model")._fill(struct)
    if sh is not None:
        both = memory["sh"] = _rows(sh, said("sh", "sh"), count, (None, 3), stream)
        struct.sh_degree = _degree(both.shape[1], said("sh", "sh"), 1, sh_degree)
        struct.sh0 = _array(both)
        struct.sh_rest = _array(both, 12)
    elif sh_rest is not None:
        rest = memory["sh_rest"] = _rows(sh_rest, said("sh_rest", "sh_rest"), count, (None, 3), stream)
        struct.sh_degree = _degree(rest.shape[1], said("sh_rest", "sh_rest"), 0, sh_degree)
        struct.sh_rest = _array(rest)
        count = rest.shape[0]
    if features is not None:
        found = memory["features"] = _rows(features, said("features", "features"), count, (None,), stream)
        struct.feature_channels = found.shape[1]
        struct.features = _array(found)
    for name in _PARTS:
        if name in memory:
            setattr(struct, name, _array(memory[name]))
    if not memory:
        raise InvalidType("all arrays are None, expected one or more")
    first_name, first = next(iter(memory.items()))
    for name, found in memory.items():
        if found.device != first.device:
            raise InvalidArgument(f"{said(name, name)} lies on {found.place} and {said(first_name, first_name)} on "
                                  f"{first.place}, expected all on one")
    check_device(first.device, said(first_name, first_name))
    struct.count = first.shape[0]
    struct.memory = _c.HOST if first.device is None else _c.DEVICE
    struct.stream = stream or None
    struct.raw = (_c.LOG_SCALES * bool(log_scales) + _c.LOGIT_OPACITIES * bool(logit_opacities) +
                  _c.ANY_ROTATIONS * bool(any_rotations) + _c.PLAIN_COLOURS * (colours is not None))
    return struct, list(memory.values())


def check_device(device: Optional[int], what: str) -> None:
    """InvalidArgument for memory of a device that is not the current one."""
    if device is not None and device != _arrays.current_device():
        raise InvalidArgument(f"{what} lies on CUDA device {device} and device {_arrays.current_device()} is current, "
                              "expected it on the current one")


def _degree(stored: int, what: str, of_band_0: int, wanted: Optional[int]) -> int:
    """The degree to draw of so many coefficients."""
    degrees = [degree for degree in range(4) if (degree + 1) ** 2 - 1 + of_band_0 == stored]
    if wanted is None:
        if not degrees:
            counts = ", ".join(str((degree + 1) ** 2 - 1 + of_band_0) for degree in range(4))
            raise InvalidArgument(f"{what} has {stored} coefficients, expected {counts} for degree 0, 1, 2, 3")
        return degrees[0]
    wanted = _checks.whole(wanted, "sh_degree", 0, 4)
    if (wanted + 1) ** 2 - 1 + of_band_0 > stored:
        raise InvalidArgument(f"{what} has {stored} coefficients, expected {(wanted + 1) ** 2 - 1 + of_band_0} or more "
                              f"for sh_degree {wanted}")
    return wanted


