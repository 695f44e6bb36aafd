# SPDX-License-Identifier: Apache-2.0
"""What the tests of the package have in common.

A run whose tests were all skipped ends with 77 and a line 'skipped: REASON', which ctest reports as skipped.
"""
import os
import pathlib
import re
import subprocess
import sys
import threading

import numpy as np
import pytest

import swiftgs

WIDTH, HEIGHT = 80, 48
ARRAYS = ("means", "scales", "rotations", "opacities", "sh0", "sh_rest")  # of a scene
OF_GAUSSIANS = ("means", "quats", "scales", "opacities", "colors")  # arguments of `rasterization`
OF_ALL = (*OF_GAUSSIANS, "viewmats", "Ks")
ROOT = pathlib.Path(__file__).parents[2]
reasons = []


@pytest.fixture(scope="session")
def scene():
    return swiftgs.Scene.builtin(2000)


@pytest.fixture(scope="session")
def camera():
    return swiftgs.Camera.builtin(WIDTH, HEIGHT)


@pytest.fixture
def renderer(scene):
    return swiftgs.Renderer("cpu", scene=scene)


@pytest.fixture(scope="session")
def expected(scene, camera):
    """The image of `camera`, with all planes."""
    return swiftgs.Renderer("cpu", scene=scene).render(camera, alpha=True, depth=True)


@pytest.fixture
def arrays(scene):
    """Arguments of `set_gaussians` and `Scene.from_arrays`."""
    return arrays_of(scene)


@pytest.fixture
def gsplat_arguments(scene, camera):
    """Arguments of `rasterization`, by name, in arrays of NumPy."""
    return {"means": scene.means, "quats": scene.rotations, "scales": scene.scales, "opacities": scene.opacities,
            "colors": scene.sh, "viewmats": camera.viewmat[None].astype(np.float32),
            "Ks": camera.K[None].astype(np.float32), "width": WIDTH, "height": HEIGHT, "sh_degree": 3}


@pytest.fixture(scope="session")
def fox():
    """The folder of a capture."""
    folder = pathlib.Path(os.environ.get("SWIFTGS_SCENES", "nowhere")) / "fox"
    if not folder.is_dir():
        pytest.skip(f"no scene at {folder}")
    return folder


def arrays_of(scene, chosen=slice(None)):
    """Arrays of some of a scene's Gaussians."""
    return {name: getattr(scene, name)[chosen] for name in ARRAYS}


def listed(kind, columns):
    """Lines of a list in tests/support, which all interfaces read: its words, and numbers where they are numbers."""
    def number(word):
        try:
            return int(word)
        except ValueError:
            return float(word) if re.fullmatch(r"[-\d.e]+|NAN|INFINITY", word) else word

    lines = re.findall(r"^(\w+)\((.*)\)$", (ROOT / "tests/support" / kind).read_text(), re.MULTILINE)
    return [(macro, *(number(word.strip(' "')) for word in words.split(",", columns - 1))) for macro, words in lines]


def seen_from(*eye):
    """A camera that looks at the built-in scene from elsewhere."""
    return swiftgs.Camera.look_at(eye, (0, 0, 0), width=WIDTH, height=HEIGHT, vertical_fov=0.9)


def has_device():
    return any(entry.usable and entry.on_device for entry in swiftgs.list_renderers())


def need_device():
    if not has_device():
        pytest.skip("no CUDA device that the kernels of this build run on")


def decibels(found, wanted):
    """PSNR for a peak of 1."""
    squared = np.mean((np.asarray(found, np.float64) - np.asarray(wanted, np.float64)) ** 2)
    return np.inf if squared == 0 else -10 * np.log10(squared)


def run_script(folder, script, *arguments, **environment):
    """What a Python script prints that runs in `folder`."""
    variables = {name: value for name, value in os.environ.items() if name != "SCENE"}
    return subprocess.run([sys.executable, script, *arguments], cwd=folder, check=True, text=True,
                          stdout=subprocess.PIPE, env={**variables, **environment}).stdout


def side_by_side(*works):
    """Runs functions in threads until all have ended."""
    threads = [threading.Thread(target=work) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


class Lent:
    """An array that shows nothing but DLPack, and counts who holds it."""

    def __init__(self, array):
        self.array, self.asked = array, []

    def __dlpack__(self, stream=None):
        self.asked.append(stream)
        return self.array.__dlpack__()

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()


def _note(report):
    if report.skipped:
        reasons.append(str(report.longrepr[-1]).replace("Skipped: ", ""))


pytest_runtest_logreport = pytest_collectreport = _note


def pytest_sessionfinish(session, exitstatus):
    nothing_ran = exitstatus == 5 or exitstatus == 0 and len(reasons) >= session.testscollected
    if reasons and nothing_ran:
        print(f"\nskipped: {reasons[0]}")
        session.exitstatus = 77
