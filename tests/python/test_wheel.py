# SPDX-License-Identifier: Apache-2.0
"""The wheel of this build: what it loads, what it records, and that it draws."""
import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = os.environ.get("SWIFTGS_BUILD")
if not BUILD:
    pytest.skip("SWIFTGS_BUILD names no build", allow_module_level=True)
for program in ("patchelf", "readelf", "dpkg"):
    if not shutil.which(program):
        pytest.skip(f"no {program} here", allow_module_level=True)
# What a system has whose glibc is new enough.
SYSTEM = {"libc.so.6", "libm.so.6", "libdl.so.2", "librt.so.1", "libpthread.so.0", "libgcc_s.so.1", "libstdc++.so.6",
          "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}


def make(folder):
    done = subprocess.run([sys.executable, ROOT / "backends/bindings/python/wheel.py", BUILD, folder], check=True,
                          stdout=subprocess.PIPE, text=True)
    return pathlib.Path(done.stdout.strip())


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return make(tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def unpacked(wheel, tmp_path_factory):
    folder = tmp_path_factory.mktemp("unpacked")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


def test_it_loads_its_own_libraries_and_those_that_every_system_has(unpacked):
    libraries = {path.name: path for path in unpacked.rglob("*.so*")}
    assert len(libraries) > 5
    for path in libraries.values():
        said = subprocess.run(["readelf", "-d", path], check=True, stdout=subprocess.PIPE, text=True).stdout
        assert set(re.findall(r"\(NEEDED\).*\[(.*)\]", said)) <= SYSTEM | set(libraries), path.name
        assert all(where.startswith("$ORIGIN") for where in re.findall(r"R(?:UN)?PATH\).*\[(.*)\]", said)), path.name


def test_its_record_is_that_of_its_files(unpacked):
    info = next(unpacked.glob("*.dist-info"))
    recorded = dict(line.split(",", 1) for line in (info / "RECORD").read_text().splitlines())
    files = {path.relative_to(unpacked).as_posix(): path for path in unpacked.rglob("*") if path.is_file()}
    assert set(files) == set(recorded)
    for name, path in files.items():
        if path.name != "RECORD":
            digest = base64.urlsafe_b64encode(hashlib.sha256(path.read_bytes()).digest()).rstrip(b"=").decode()
            assert recorded[name] == f"sha256={digest},{path.stat().st_size}"
    assert "libtbb12 (bundled): Apache-2.0" in (info / "third-party-licences.txt").read_text()


def test_it_draws_with_them(unpacked):
    program = ("import swiftgs; frame = swiftgs.Renderer('cpu', scene=swiftgs.Scene.builtin(1000))"
               ".render(swiftgs.Camera.builtin(64, 36)); assert frame.colour.mean() > 0.1; "
               "print(*{line.split()[-1] for line in open('/proc/self/maps') if '.so' in line})")
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(unpacked), "PYTHONDONTWRITEBYTECODE": "1"}
    loaded = subprocess.run([sys.executable, "-c", program], env=environment, check=True, stdout=subprocess.PIPE,
                            text=True).stdout.split()
    for name in ("libtbb", "libpng16", "libzip"):
        assert [pathlib.Path(path).parent.name for path in loaded if name in path] == ["swiftgs.libs"]


def test_pip_makes_it(wheel, tmp_path):
    pip = [sys.executable, "-m", "pip"]
    if subprocess.run([*pip, "--version"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode:
        pytest.skip("no pip here (package python3-pip)")
    subprocess.run([*pip, "wheel", ROOT / "backends/bindings/python", "--no-deps", "--no-index", f"--config-settings=build={BUILD}",
                    "-w", tmp_path], check=True, stdout=subprocess.DEVNULL)
    assert (tmp_path / wheel.name).read_bytes() == wheel.read_bytes()


def test_it_is_the_same_each_time(wheel, tmp_path):
    assert make(tmp_path).read_bytes() == wheel.read_bytes()
