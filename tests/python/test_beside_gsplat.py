# SPDX-License-Identifier: Apache-2.0
"""benchmarks/beside_gsplat.py on the host, with modules in place of PyTorch and gsplat."""
import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "benchmarks/tests"))
from test_schemas import errors_of  # noqa: E402  pylint: disable=wrong-import-position

TORCH = """
import contextlib, os, numpy, types
__version__, no_grad = "0", contextlib.nullcontext
cuda = types.SimpleNamespace(is_available=lambda: "NO_GPU" not in os.environ, synchronize=lambda: None)
def tensor(array, device):
    assert device == "cuda" and array.dtype == numpy.float32
    return numpy.array(array)
"""
# Draws what swiftgs draws, but for a ten-thousandth.
GSPLAT = """
import os, swiftgs
if "NO_GSPLAT" in os.environ:
    raise ImportError("No module named 'gsplat'")
__version__ = "0"
def rasterization(packed=True, **arguments):
    assert not packed
    shapes = {name: array.shape for name, array in arguments.items() if hasattr(array, "shape")}
    assert shapes == {"means": (3, 400, 3), "quats": (3, 400, 4), "scales": (3, 400, 3), "opacities": (3, 400),
                      "colors": (3, 400, 3), "viewmats": (3, 2, 4, 4), "Ks": (3, 2, 3, 3)}, shapes
    images, *others = swiftgs.rasterization(**arguments)
    assert (images[0] != images[1]).any() and (images[:, 0] != images[:, 1]).any() and images.std() > 0.05
    return images[:int(os.environ.get("DRAWN", 3))] + 1e-4, *others
"""


@pytest.fixture
def run(tmp_path):
    """Runs the script on a scene in `tmp_path`."""
    (tmp_path / "torch.py").write_text(TORCH)
    (tmp_path / "gsplat.py").write_text(GSPLAT)
    paths = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])

    def call(scene, **environment):
        return subprocess.run(
            [sys.executable, ROOT / "benchmarks/beside_gsplat.py", scene, "--rounds", "2", "--json", "found.json"],
            cwd=tmp_path, check=False, text=True, capture_output=True,
            env={**os.environ, "PYTHONPATH": paths, "SWIFTGS_RIVALS": str(tmp_path), **environment})
    return call


def test_a_batch_of_worlds_is_compared_alone(run, tmp_path):
    ran = run("worlds:3,400,2,32")
    assert (ran.returncode, ran.stderr) == (0, "")
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["rows"] == [] and found["worlds"] == [json.loads(ran.stdout)]
    row = found["worlds"][0]
    assert [row[name] for name in ("worlds", "gaussians", "views", "size")] == [3, 400, 2, [32, 32]]
    assert set(row["ms"]) == {"swiftgs", "swiftgs, matrices on the host", "gsplat, not packed"}
    assert len(row["between_db"]) == 6 and np.allclose(row["between_db"], 80, atol=0.1)
    assert [line for line in errors_of(found) if not line.startswith("$.machine")] == []  # it may have no GPU


@pytest.mark.parametrize("scene, environment, message", [
    ("worlds:3,400", {}, "'worlds:3,400': expected worlds, or worlds:WORLDS,GAUSSIANS,VIEWS,PIXELS, such as"),
    ("worlds:3,400,0,32", {}, "'worlds:3,400,0,32': expected worlds, or"),
    ("worlds", {"NO_GSPLAT": "1"}, "beside_gsplat: No module named 'gsplat'; expected PyTorch, swiftgs, and gsplat as"),
    ("worlds", {"NO_GPU": "1"}, "beside_gsplat: PyTorch 0 sees no GPU, expected one"),
    ("worlds:3,400,2,32", {"DRAWN": "2"}, r"gsplat 0 drew \(2, 2, 32, 32, 3\), expected \(3, 2, 32, 32, 3\)")])
def test_what_is_missing_is_said_in_one_line(run, scene, environment, message):
    ran = run(scene, **environment)
    assert ran.returncode == 1 and re.fullmatch(f"{message}[^\n]*\n", ran.stderr), ran.stderr
