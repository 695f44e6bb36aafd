# SPDX-License-Identifier: Apache-2.0
"""The examples, run as a reader runs them."""
import re

import numpy as np
import pytest

import swiftgs
from conftest import ROOT, run_script

EXAMPLES = ROOT / "examples"


def test_the_evaluation_finds_the_photographs_again(fox, tmp_path):
    said = run_script(tmp_path, EXAMPLES / "09_evaluation.py", fox, "--batch", "3", "--worst", "worst.png")
    of_views = [float(value) for value in re.findall(r"^\S+\.jpg +([0-9.]+) dB$", said, re.MULTILINE)]
    mean = float(re.search(r"mean of (\d+) views +([0-9.]+) dB", said)[2])
    assert len(of_views) == len(list((fox / "photos").iterdir())) and mean == pytest.approx(np.mean(of_views), abs=0.01)
    assert mean > 28
    worst = swiftgs.load_image(tmp_path / "worst.png")
    camera = swiftgs.load_cameras(fox)[0]
    assert worst.shape == (camera.height, 2 * camera.width, 3)


def test_the_turntable_goes_where_the_cameras_were(fox, tmp_path):
    run_script(tmp_path, EXAMPLES / "08_turntable.py", fox, "--frames", "4", "--size", "60", "80", "--out", "turn")
    images = [swiftgs.load_image(path) for path in sorted((tmp_path / "turn").glob("*.png"))]
    assert len(images) == 4 and all(image.shape == (80, 60, 3) for image in images)
    assert not np.array_equal(images[0], images[2])
    # Every image looks at the fox and the wall, not at nothing.
    assert all(np.mean(image.max(axis=2) > 0.1) > 0.9 for image in images)


def test_the_notebook_runs_on_a_capture(fox, tmp_path):
    said = run_script(tmp_path, EXAMPLES / "10_notebook.py", SCENE=str(fox))
    left = float(re.search(r"Gaussians: ([0-9.]+) dB from all", said)[1])
    assert 15 < left < 60 and swiftgs.load_image(tmp_path / "notebook.png").std() > 0.1
