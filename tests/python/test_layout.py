# SPDX-License-Identifier: Apache-2.0
"""The package declares the binary interface that is recorded, in the oldest Python that it serves."""
import ast
import ctypes
import pathlib
import re

from swiftgs import _c

RECORD = (pathlib.Path(__file__).parents[1] / "c/abi.txt").read_text().splitlines()


def camel(name):
    return "".join(part.capitalize() for part in name.split("_"))


def members(struct):
    return [(name, getattr(struct, name)) for name, *_ in struct._fields_]


def test_structs_have_the_members_and_sizes_of_the_record():
    sizes = dict(re.fullmatch(r"struct swiftgs_(\w+): (\d+) bytes", line).groups()
                 for line in RECORD if line.startswith("struct "))
    recorded = [re.fullmatch(r"member swiftgs_(\w+)\.(\w+): .*, byte (\d+), (\d+) bytes", line).groups()
                for line in RECORD if line.startswith("member ")]
    compared = 0
    for name, size in sizes.items():
        struct = getattr(_c, camel(name))
        assert ctypes.sizeof(struct) == int(size), name
        wanted = [(member, int(at), int(bytes_)) for of, member, at, bytes_ in recorded if of == name]
        assert [(member, field.offset, field.size) for member, field in members(struct)] == wanted, name
        compared += 1
    assert compared >= 17


def test_functions_have_as_many_parameters_as_recorded():
    compared = 0
    for line in RECORD:
        found = re.fullmatch(r"function .*?\bswiftgs_(\w+)\((.*)\)", line)
        if found and hasattr(_c.lib, found[1]):
            count = 0 if found[2] == "void" else found[2].count(",") + 1
            assert len(getattr(_c.lib, found[1]).argtypes) == count, found[1]
            compared += 1
    assert compared >= 41


def test_numbers_are_those_of_the_record():
    values = dict(re.fullmatch(r"value SWIFTGS_(\w+) = (-?\d+)", line).groups() for line in RECORD
                  if line.startswith("value "))
    for name in ("HOST", "DEVICE", "LOG_SCALES", "LOGIT_OPACITIES", "ANY_ROTATIONS", "PLAIN_COLOURS",
                 "MEASURE_COUNTS", "MEASURE_TIMES"):
        assert getattr(_c, name) == int(values[name]), name
    for index, name in enumerate(_c.SPZ_AXES):
        assert int(values[f"SPZ_{name.upper()}"]) == index
    for kind, names in (("CLAMP", _c.CLAMPS), ("FOOTPRINT", _c.FOOTPRINTS), ("DEPTH", _c.DEPTHS),
                        ("LENS", _c.LENSES), ("CLIP", _c.CLIP_SPACES), ("HARMONICS", _c.HARMONICS)):
        for index, name in enumerate(names):
            assert int(values[f"{kind}_{name.upper().replace('-', '_')}"]) == index
    assert f"abi {_c.ABI_MAJOR}.{_c.ABI_MINOR}" in RECORD


def test_sources_are_of_python_3_9():
    sources = list(pathlib.Path(_c.__file__).parent.glob("*.py"))
    assert len(sources) > 10
    for source in sources:
        ast.parse(source.read_text(), source.name, feature_version=(3, 9))
