# SPDX-License-Identifier: Apache-2.0
"""The example on a capture, run as a reader runs it."""
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
