# SPDX-License-Identifier: Apache-2.0
"""The examples on the built-in scene, and the program of the README."""
import json
import os
import re

import numpy as np
import pytest

import swiftgs
from conftest import ROOT, run_script


def test_worlds_of_the_simulator_share_a_room_and_move_apart(tmp_path):
    printed = run_script(tmp_path, ROOT / "examples/16_simulator.py", "--worlds", "3", "--steps", "2", "--size", "64")
    assert re.fullmatch(r"9 images a step on .+, poses by (numpy|cupy|torch): [\d,]+ images a second\n", printed)
    picture = swiftgs.load_image(tmp_path / "simulator.png")
    assert picture.shape == (4 * 64, 6 * 64, 3)
    times, cameras = picture.reshape(4, 64, 6, 64, 3).transpose(0, 2, 1, 3, 4), slice(0, 3)  # [time, view, ...]

    def changed(some, others):
        """The part of the pixels that differs in each pair of images."""
        return (np.abs(some - others).max(axis=-1) > 0.04).mean(axis=(-2, -1))

    # Objects move between the rows and are elsewhere in the other world. The room stays.
    for found in (changed(times[1:], times[:-1]), changed(times[:, cameras], times[:, 3:])):
        assert 0.01 < found.min() and found.max() < 0.4, found
    assert changed(times[:, 0], times[:, 1]).min() > 0.5  # cameras differ


def test_the_measurement_of_overhead_runs(tmp_path):
    tool = os.environ.get("SWIFTGS_TOOL")
    if not tool:
        pytest.skip("SWIFTGS_TOOL does not name the tool")
    run_script(tmp_path, ROOT / "benchmarks/python_overhead.py", tool, "builtin:500", "--scale", "0.05",
               "--seconds", "0.02", "--rounds", "2", "--json", "results.json")
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["format"] == "swiftgs-bench" and results["machine"]["cores"] > 0
    assert {row["call"] for row in results["rows"]} >= {"C++", "out", "new"}
    for row in results["rows"]:
        assert [row[name] for name in ("scene", "gaussians", "width", "height")] == ["builtin:500", 500, 64, 36]
        assert 0 < row["ms"]["wall"]["p10"] <= row["ms"]["wall"]["median"] < 1000
        for time in row.get("outside_us", {}).values():  # a difference: other programs may make it negative
            assert np.isfinite(time)


def test_the_program_of_the_readme_draws_its_frame(tmp_path):
    program = re.search(r"\n```python\n(.*?)```\n", (ROOT / "README.md").read_text(), re.DOTALL)[1]
    assert len(program.strip().splitlines()) == 6
    (tmp_path / "program.py").write_text(program)
    run_script(tmp_path, "program.py")
    wanted = swiftgs.Renderer(scene=swiftgs.Scene.builtin()).render(swiftgs.Camera.builtin()).colour
    read = swiftgs.load_image(tmp_path / "frame.png")
    assert np.abs(read - np.clip(wanted, 0, 1)).max() <= 0.5 / 255 + 1e-6
