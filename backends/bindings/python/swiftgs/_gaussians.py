# SPDX-License-Identifier: Apache-2.0
"""Arrays of Gaussians as the struct that the library takes."""
import functools
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

from . import _arrays, _c, _checks, _dlpack
from ._errors import InvalidArgument, InvalidType
from ._model import RenderingModel

# Names of the struct's members, and of `sh0` with `sh_rest` in one, and the shapes of one Gaussian.
_PARTS: Dict[str, Tuple[Optional[int], ...]] = {
    "means": (3,), "scales": (3,), "rotations": (4,), "opacities": (), "sh0": (3,), "sh": (None, 3),
    "sh_rest": (None, 3), "features": (None,)}


class Given(NamedTuple):
    """Arrays of Gaussians as the library takes them."""

    struct: _c.Gaussians
    memory: List[_arrays.Memory]  # that the struct points to
    sources: Dict[Any, Any]  # an array for each stream, by `whose_stream`
    layout: Any  # equal layouts have equal structs, addresses excepted; None if an array was copied

    @property
    def count(self) -> int:
        return self.memory[0].shape[0]

    @property
    def device(self) -> Optional[int]:
        return self.memory[0].device


def _rows(memory: _arrays.Memory, array: Any, what: str, shape: Tuple[Optional[int], ...],
          stream: int) -> _arrays.Memory:
    """Float32 of this shape, the numbers of one Gaussian side by side: `memory` of `array`, or that of a copy. None in
    a shape stands for any length."""
    if not _lies_in_rows(what, memory.kind, memory.shape, memory.strides, shape):
        copy = _copied(array, what)
        return _rows(_arrays.read(copy, what, stream), copy, what, shape, stream)
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


def _members(struct: _c.Gaussians, name: str) -> List[Tuple[_c.Array, int]]:
    """Members of the struct for the array `name`, and the byte of the array where each begins."""
    return [(struct.sh0, 0), (struct.sh_rest, 12)] if name == "sh" else [(getattr(struct, name), 0)]


def _point_to(struct: _c.Gaussians, memory: Dict[str, _arrays.Memory], said: Any) -> None:
    """Sets the addresses."""
    for name, found in memory.items():
        if found.address % 4 != 0:
            raise InvalidArgument(f"{said(name, name)} begins at the address {found.address}, expected a multiple of 4")
        for member, offset in _members(struct, name):
            member.data = found.address + offset


def gaussians_of(means: Any, scales: Any, rotations: Any, opacities: Any, sh0: Any, sh_rest: Any = None, *,
                 sh: Any = None, sh_degree: Optional[int] = None, colours: Any = None, log_scales: bool = False,
                 logit_opacities: bool = False, any_rotations: bool = True,
                 model: RenderingModel = RenderingModel(), features: Any = None, stream: int = 0, some: bool = False,
                 names: Optional[dict] = None, last: Tuple[Any, Any] = (None, None)) -> Given:
    """The arrays, ready on `stream`.

    Colours are `sh0` [N, 3] with `sh_rest` [N, K, 3], or `sh` [N, K, 3] with both, or `colours` [N, 3] without
    harmonics. `some`: arrays that are None are left out. `names` are those of the caller's arguments. `last` are the
    layout and the struct of an earlier call: arrays of the same layout take its struct.
    """
    said = (names or {}).get
    arrays = {"means": means, "scales": scales, "rotations": rotations, "opacities": opacities}
    if sh is not None:
        arrays["sh"] = sh
    else:
        arrays["sh0"] = sh0 if colours is None else colours
        if sh_rest is not None:
            arrays["sh_rest"] = sh_rest
    if features is not None:
        arrays["features"] = features
    if some:
        arrays = {name: array for name, array in arrays.items() if array is not None}
    memory: Dict[str, _arrays.Memory] = {}
    sources: Dict[Any, Any] = {}
    for name, array in arrays.items():
        source = _arrays.whose_stream(array)
        # One order is enough for all tensors of PyTorch; DLPack makes each array ready by itself.
        is_ready = source == "torch" and source in sources
        memory[name] = _arrays.read(array, said(name, name), None if is_ready else stream)
        sources[source] = array
    _checks.of_type(model, RenderingModel, "model")
    raw = (_c.LOG_SCALES * bool(log_scales) + _c.LOGIT_OPACITIES * bool(logit_opacities) +
           _c.ANY_ROTATIONS * bool(any_rotations) + _c.PLAIN_COLOURS * (colours is not None))
    layout: Any = (*memory, *[found[1:-1] for found in memory.values()], sh_degree, raw, model, stream)
    struct = last[1]
    if layout != last[0]:
        if not memory:
            raise InvalidType("all arrays are None, expected one or more")
        first: Optional[_arrays.Memory] = None
        for name, found in memory.items():
            expected = (first.shape[0] if first else None, *_PARTS[name])
            memory[name] = _rows(found, arrays[name], said(name, name), expected, stream)
            first = first or memory[name]
            if memory[name] is not found:
                layout = None
        struct = _c.Gaussians(raw=raw, stream=stream or None)
        model._fill(struct)
        _fill(struct, memory, said, sh_degree)
    _point_to(struct, memory, said)
    return Given(struct, list(memory.values()), sources, layout)


def _fill(struct: _c.Gaussians, memory: Dict[str, _arrays.Memory], said: Any, sh_degree: Optional[int]) -> None:
    """Sets what `struct` says of the arrays, which lie in rows, but for addresses. They must lie in one place."""
    for name, found in memory.items():
        for member, _ in _members(struct, name):
            member.stride = found.strides[0] if found.shape[0] > 1 else 0
    for name, of_band_0 in (("sh", 1), ("sh_rest", 0)):
        if name in memory:
            struct.sh_degree = _degree(memory[name].shape[1], said(name, name), of_band_0, sh_degree)
    if "features" in memory:
        struct.feature_channels = memory["features"].shape[1]
    first_name, first = next(iter(memory.items()))
    for name, found in memory.items():
        if found.device != first.device:
            raise InvalidArgument(f"{said(name, name)} lies on {found.place} and {said(first_name, first_name)} on "
                                  f"{first.place}, expected all on one")
    check_device(first.device, said(first_name, first_name))
    struct.count = first.shape[0]
    struct.memory = _c.HOST if first.device is None else _c.DEVICE


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


