# SPDX-License-Identifier: Apache-2.0
"""The examples on the built-in scene, and the program of the README."""
import json
import os
import re

import numpy as np
import pytest

import swiftgs
from conftest import ROOT, run_script


def test_the_turntable_goes_round_the_built_in_scene(tmp_path):
    run_script(tmp_path, ROOT / "examples/08_turntable.py", "--frames", "3", "--size", "96", "54")
    images = [swiftgs.load_image(path) for path in sorted((tmp_path / "turntable").glob("*.png"))]
    assert len(images) == 3 and all(image.shape == (54, 96, 3) and image.std() > 0.1 for image in images)
    assert len({image.tobytes() for image in images}) == 3


def test_planes_of_the_built_in_scene_are_pictures(tmp_path):
    run_script(tmp_path, ROOT / "examples/14_planes.py", "--width", "96")
    images = {path.stem: swiftgs.load_image(path) for path in (tmp_path / "planes").glob("*.png")}
    assert images.pop("planes").shape == (3 * 54, 3 * 96, 3)
    assert set(images) == {"colour", "alpha", "depth", "spread", "first_depth", "median_depth", "normal", "id", "feature"}
    assert all(image.shape == (54, 96, 3) for image in images.values())
    assert all(image.std() > (1e-4 if name == "alpha" else 0.01) for name, image in images.items())
    assert len({image.tobytes() for image in images.values()}) == len(images)


def test_objects_move_about_the_built_in_scene(tmp_path):
    run_script(tmp_path, ROOT / "examples/15_placed.py", "--width", "96", "--frames", "3")
    images = [swiftgs.load_image(path) for path in sorted((tmp_path / "placed").glob("*.png"))]
    assert len(images) == 3 and all(image.shape == (108, 96, 3) for image in images)
    still = swiftgs.Renderer(scene=swiftgs.Scene.builtin()).render(swiftgs.Camera.builtin(96, 54)).colour
    moved = [(np.abs(image[:54] - np.clip(still, 0, 1)).max(axis=2) > 0.02).mean() for image in images]
    assert all(0.02 < part < 0.5 for part in moved) and len({image.tobytes() for image in images}) == 3


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


def test_the_notebook_runs(tmp_path):
    run_script(tmp_path, ROOT / "examples/10_notebook.py")
    image = swiftgs.load_image(tmp_path / "notebook.png")
    assert image.shape == (360, 1920, 3) and all(part.std() > 0.1 for part in np.split(image, 3, axis=1))


def test_the_measurement_of_overhead_runs(tmp_path):
    tool = os.environ.get("SWIFTGS_TOOL")
    if not tool:
        pytest.skip("SWIFTGS_TOOL does not name the tool")
    run_script(tmp_path, ROOT / "benchmarks/python_overhead.py", tool, "builtin:500", "--scale", "0.05",
               "--seconds", "0.02", "--rounds", "2", "--json", "results.json")
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["format"] == "swiftgs-python" and results["machine"]["cores"] > 0 and results["rows"]
    for row in results["rows"]:
        assert row["scene"] == "builtin:500" and row["gaussians"] == 500 and row["size"] == [64, 36]
        assert set(row["python_ms"]) >= {"nothing", "out", "new"}
        for time in (row["cpp_ms"], row["cpp_nothing_ms"], *row["python_ms"].values()):
            assert 0 < time["p10"] <= time["median"] < 1000
        for time in (row["cpp_outside_us"], row["python_outside_us"]):  # differences: other programs may make them negative
            assert np.isfinite([time["p10"], time["median"]]).all()


def test_the_program_of_the_readme_draws_its_frame(tmp_path):
    program = re.search(r"\n```python\n(.*?)```\n", (ROOT / "README.md").read_text(), re.DOTALL)[1]
    assert len(program.strip().splitlines()) == 6
    (tmp_path / "program.py").write_text(program)
    run_script(tmp_path, "program.py")
    wanted = swiftgs.Renderer(scene=swiftgs.Scene.builtin()).render(swiftgs.Camera.builtin()).colour
    read = swiftgs.load_image(tmp_path / "frame.png")
    assert np.abs(read - np.clip(wanted, 0, 1)).max() <= 0.5 / 255 + 1e-6
