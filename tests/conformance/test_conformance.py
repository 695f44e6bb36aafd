# SPDX-License-Identifier: Apache-2.0
"""The conformance set is what its script makes, two renderers agree on it, and the judge tells canvases apart."""
import io
import json
import pathlib
import shutil
import subprocess
import sys
import unittest
from contextlib import redirect_stdout
from tempfile import TemporaryDirectory

try:
    import numpy as np
except ModuleNotFoundError:
    print("skipped: no NumPy here (package python3-numpy)")
    sys.exit(77)

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import judge  # noqa: E402
import make_set  # noqa: E402
import reference  # noqa: E402

SET = HERE / "set"
MANIFEST = json.loads((SET / "manifest.json").read_bytes())
CLAUSES = {clause["name"]: clause for clause in MANIFEST["clauses"]}


def drawn(clause, preset, **conventions):
    scene, camera = reference.read_scene(SET / clause["scene"]), reference.read_camera(SET / clause["cameras"])
    return reference.render(scene, camera, {**reference.PRESETS[preset], **conventions},
                            clause.get("background", (0, 0, 0)))[0]


def judged(canvases, *arguments, preset="gsplat"):
    """The exit code of the judge, and its rows, of canvases {file: bytes or floats}."""
    with TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name, values in canvases.items():
            if name.endswith(".npy"):
                np.save(folder / name, values)
            else:
                (folder / name).write_bytes(values)
        with redirect_stdout(io.StringIO()):
            code = judge.main([str(SET), str(folder), "--preset", preset, "--json", str(folder / "rows"), *arguments])
        return code, {row["clause"]: row for row in json.loads((folder / "rows").read_bytes())}


def in_bytes(image):
    return np.round(255 * image.clip(0, 1)).astype(np.uint8)


class Set(unittest.TestCase):
    def test_scenes_and_manifest_are_those_of_the_script(self):
        rows, files = make_set.made(MANIFEST["side"])
        for path, content in files.items():
            self.assertEqual(content, (SET / path).read_bytes(), path)
        presets = {name: clause["presets"] for name, clause in CLAUSES.items()}
        self.assertEqual(make_set.manifest_of(rows, make_set.layers_of(SET, rows), presets, MANIFEST["side"]).decode(),
                         (SET / "manifest.json").read_text(encoding="utf-8"))

    def test_it_has_no_other_files_and_is_small(self):
        named = {path for clause in CLAUSES.values()
                 for path in (clause["scene"], clause["cameras"], *clause["presets"].values())}
        found = {str(path.relative_to(SET)): path.stat().st_size for path in SET.rglob("*") if path.is_file()}
        self.assertEqual(set(found) - named, {"LICENSE", "manifest.json", "sheet.png"})
        self.assertLess(sum(found.values()), 3e6)
        self.assertEqual(len(CLAUSES), 46)

    def test_the_second_renderer_draws_every_image_to_a_billionth(self):
        for name, clause in CLAUSES.items():
            for preset, path in clause["presets"].items():
                with self.subTest(clause=name, preset=preset):
                    stored = np.load(SET / path)
                    sure = stored["ambiguous"] == 0
                    self.assertGreater(sure.mean(), 0.99)
                    error = np.abs(drawn(clause, preset) - stored["rgba"])[sure].max()
                    self.assertLess(error, 1e-9 * max(1, np.abs(stored["rgba"]).max()))


class Judge(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.perfect = {name: np.load(SET / clause["presets"]["gsplat"])["rgba"] for name, clause in CLAUSES.items()}

    def test_perfect_canvases_are_right(self):
        for canvases in ({f"{name}.rgba": in_bytes(image).tobytes() for name, image in self.perfect.items()},
                         {f"{name}.npy": image.astype(np.float32) for name, image in self.perfect.items()}):
            code, rows = judged(canvases)
            self.assertEqual({row["verdict"] for row in rows.values()}, {"right"})
            self.assertEqual(code, 0)

    def test_pictures_are_read(self):
        opaque = in_bytes(self.perfect["rotated"])[..., :3]
        _, rows = judged({"rotated.png": make_set.png_of(opaque)})
        self.assertEqual(rows["rotated"]["verdict"], "right")

    def test_canvases_that_are_not_there_are_named(self):
        code, rows = judged({"blur.rgba": in_bytes(self.perfect["blur"]).tobytes()})
        self.assertEqual([name for name, row in rows.items() if row["verdict"] != "not drawn"], ["blur"])
        self.assertEqual(code, 1)

    def test_what_a_renderer_does_otherwise_is_named(self):
        for name, conventions, expected in (
                ("blur", {"blur": 0.075}, ["blur 0.075"]), ("order-z", {"order": "distance"}, ["order by distance"]),
                ("opacity-1", {"alpha_max": 1.0}, ["alphas to 1"]), ("linear", {"colours": "srgb"}, ["sRGB colours"]),
                ("clamp-image", {"clamp": "around_centre"}, ["clamp around the centre"]),
                ("covariance-0", {"leaves_out_level": True}, ["level splats left out"]),
                ("colour-above-1", {"most_colour": 1.0}, ["colours cut at 1"]),
                ("harmonics-posed", {"most_degree": 1}, ["harmonics to degree 1"]),
                ("three-sigma", {"footprint": "root_eight_ellipse"}, ["ends at 2.83 sigmas"]),
                ("needle", {"blur": 0.1, "antialiased": True}, ["blur 0.1", "compensation"])):
            with self.subTest(clause=name, conventions=conventions):
                _, rows = judged({f"{name}.rgba": in_bytes(drawn(CLAUSES[name], "gsplat", **conventions)).tobytes()})
                row = rows[name]
                self.assertEqual((row["verdict"], row["explained"], sorted(row["nearest"])), ("differs", True, expected))
                self.assertGreater(row["nearest_db"], row["db"] + 10)

    def test_an_alpha_that_is_wrong_alone_is_named(self):
        image = in_bytes(self.perfect["rotated"])
        image[..., 3] //= 2
        row = judged({"rotated.rgba": image.tobytes()})[1]["rotated"]
        self.assertEqual((row["verdict"], row["nearest"], row["explained"]), ("differs", ["alpha of the canvas"], True))

    def test_straight_colours_and_layers_are_options(self):
        image = self.perfect["rotated"]
        straight = np.dstack([image[..., :3] / np.maximum(image[..., 3:], 1e-9), image[..., 3]])
        self.assertEqual(judged({"rotated.npy": straight}, "--straight")[1]["rotated"]["verdict"], "right")
        rough = np.minimum(in_bytes(image).astype(int) + 1, 255).astype(np.uint8).tobytes()
        verdicts = [judged({"rotated.rgba": rough}, *given)[1]["rotated"]["verdict"]
                    for given in ((), ("--blends-in-bytes",))]
        self.assertEqual(verdicts, ["differs", "right"])

    def test_it_runs_with_two_files_alone(self):
        with TemporaryDirectory() as folder:
            for name in ("judge.py", "reference.py"):
                shutil.copy(HERE / name, folder)
            found = subprocess.run([sys.executable, "-B", f"{folder}/judge.py", str(SET), folder], capture_output=True,
                                   text=True, check=False)
        self.assertEqual((found.returncode, found.stdout.splitlines()[-1]), (1, "0 of 46 clauses right by gsplat"))


if __name__ == "__main__":
    unittest.main()
