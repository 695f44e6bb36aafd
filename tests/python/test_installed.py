# SPDX-License-Identifier: Apache-2.0
"""The package where it was installed, with its own library."""
import os
import pathlib
import re
import shutil
import subprocess

import pytest

import swiftgs

PREFIX = os.environ.get("SWIFTGS_INSTALLED")
if not PREFIX:
    pytest.skip("SWIFTGS_INSTALLED names no installation", allow_module_level=True)


def test_the_package_is_the_installed_one_with_its_own_library():
    assert "SWIFTGS_LIBRARY" not in os.environ
    package = pathlib.Path(swiftgs.__file__).parent
    assert pathlib.Path(PREFIX).resolve() in package.resolve().parents
    names = {path.name for path in package.iterdir()} - {"__pycache__"}
    assert {"__init__.py", "py.typed", "LICENSE", "libswiftgs_c.so.2"} <= names
    sources = {path.name for path in (pathlib.Path(__file__).parents[2] / "backends/bindings/python/swiftgs").glob("*.py")}
    assert {name for name in names if name.endswith(".py")} == sources
    maps = pathlib.Path("/proc/self/maps").read_text()
    assert str((package / "libswiftgs_c.so.2").resolve()) in maps


def test_its_version_is_that_of_the_header():
    """Which the library states, through the C interface."""
    header = (pathlib.Path(PREFIX) / "include/swiftgs/version.hpp").read_text()
    assert re.search(r'version = "([0-9.]+)"', header)[1] == swiftgs.__version__


def test_its_library_is_not_searched_for_in_the_working_directory():
    if not shutil.which("readelf"):
        pytest.skip("no readelf")
    said = subprocess.run(["readelf", "-d", pathlib.Path(swiftgs.__file__).with_name("libswiftgs_c.so.2")], check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    assert "(NEEDED)" in said
    for path in re.findall(r"R(?:UN)?PATH\).*\[(.*)\]", said):
        assert all(part.startswith(("/", "$ORIGIN")) for part in path.split(":")), path


def test_it_draws(camera, renderer, expected):
    assert (renderer.render(camera).colour == expected.colour).all()
