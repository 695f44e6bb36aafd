# SPDX-License-Identifier: Apache-2.0
"""Drives the window of `swiftgs view` by mouse and keys: XVFB XDOTOOL SWIFTGS."""
import contextlib
import json
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from display import display, without_display  # noqa: E402
from messages import close, drop  # noqa: E402

XVFB, XDOTOOL, SWIFTGS = sys.argv[1:]
SCENE = "builtin:20000"
EMPTY_PLY = "ply\nformat binary_little_endian 1.0\nelement vertex 0\n" + "".join(
    f"property float {name}\n" for name in "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 "
    "rot_0 rot_1 rot_2 rot_3".split()) + "end_header\n"


def wait_for(what, condition):
    deadline = time.monotonic() + 60
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f"waited for {what} in vain")
        time.sleep(0.05)


class Viewer:
    """A running viewer, and hands on mouse and keys."""

    def __init__(self, folder, environment, process):
        self.folder, self.environment, self.process = folder, environment, process
        self.pictures = 0
        wait_for("the window", lambda: self.window() or process.poll() is not None)
        self.do("windowfocus", "--sync", self.window())

    def window(self):
        found = subprocess.run([XDOTOOL, "search", "--onlyvisible", "--name", "SwiftGS - "], env=self.environment,
                               capture_output=True, text=True, check=False)
        return found.stdout.strip()

    def place(self):
        """Its screen, and the window's number there."""
        return self.environment["DISPLAY"], int(self.window())

    def do(self, *words):
        subprocess.run([XDOTOOL, *words], env=self.environment, check=True, timeout=60)

    def drag(self, button, right, down):
        self.do("mousemove", "800", "400", "mousedown", button)
        for step in range(10):
            self.do("mousemove", str(800 + right * (step + 1) // 10), str(400 + down * (step + 1) // 10))
        self.do("mouseup", button)

    def picture(self):
        """The file that P writes, once the camera stands and the picture is whole."""
        time.sleep(1)
        self.pictures += 1
        file = self.folder / f"swiftgs-{self.pictures}.png"
        self.do("key", "p")
        wait_for(file.name, file.exists)
        return file


def tool(folder, *arguments):
    return subprocess.run([SWIFTGS, *arguments], cwd=folder, capture_output=True, text=True, check=False, timeout=120)


def psnr(one, other):
    """In decibels; infinite for equal pictures."""
    compared = json.loads(tool(one.parent, "compare", str(one), str(other)).stdout)
    return compared["psnr_db"] if compared["psnr_db"] is not None else float("inf")


class View(unittest.TestCase):
    @contextlib.contextmanager
    def viewer(self, folder, *arguments):
        with display(XVFB) as environment, subprocess.Popen(
                [SWIFTGS, "view", *arguments], cwd=folder, env=environment, stdout=subprocess.PIPE,
                stderr=subprocess.PIPE, text=True) as process:
            try:
                viewer = Viewer(folder, environment, process)
                yield viewer
                self.assertIsNone(process.poll())
                close(*viewer.place())
                out, err = process.communicate(timeout=60)
                self.assertEqual((process.returncode, out, err), (0, "", ""))
            finally:
                process.kill()

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def render(self, *arguments):
        ran = tool(self.folder, "render", SCENE, *arguments)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        return self.folder / "renders"

    def test_mouse_and_keys_move_the_camera_of_the_picture_that_render_draws(self):
        renders = self.render("--views", "0,1")
        front, orbit = sorted(renders.iterdir(), key=lambda file: file.name != "front.png")
        with self.viewer(self.folder, SCENE, "--renderer", "cpu") as viewer:
            self.assertEqual(psnr(viewer.picture(), front), float("inf"))
            viewer.drag("1", 120, 40)
            turned = viewer.picture()
            self.assertLess(psnr(turned, front), 30)
            viewer.do("key", "r")
            self.assertEqual(psnr(viewer.picture(), front), float("inf"))
            viewer.do("key", "n")
            self.assertEqual(psnr(viewer.picture(), orbit), float("inf"))
            viewer.do("key", "b", "key", "1")
            pictures = []
            for navigation in "1", "2", "3":
                viewer.do("key", navigation)
                viewer.drag("1", -60, 30)
                viewer.do("keydown", "w", "sleep", "0.3", "keyup", "w")
                pictures.append(viewer.picture())
                viewer.do("key", "r")
            viewer.drag("3", 50, 50)
            pictures += [front, turned, viewer.picture()]
            viewer.do("mousemove", "800", "400", "click", "4", "click", "4")  # the wheel
            pictures.append(viewer.picture())
        for one, other in zip(pictures, pictures[1:]):
            self.assertLess(psnr(one, other), 35)

    def test_a_path_is_recorded_and_played_and_saved_for_render(self):
        path = self.folder / "flight.json"
        with self.viewer(self.folder, SCENE, "--path", "flight.json") as viewer:
            first = viewer.picture()
            viewer.do("key", "k")
            viewer.drag("1", 100, 20)
            last = viewer.picture()
            viewer.do("key", "k", "key", "f")
            wait_for("the path", path.exists)
            viewer.do("key", "space")
            on_the_way = viewer.picture()
            time.sleep(2)
            self.assertGreater(psnr(viewer.picture(), last), 50)
        self.assertLess(psnr(on_the_way, first), 40)
        self.assertLess(psnr(on_the_way, last), 40)
        saved = json.loads(path.read_text(encoding="utf-8"))
        self.assertEqual((len(saved["keyframes"]), saved["seconds"], len(saved["camera_path"])), (2, 2, 49))
        renders = self.render("--cameras", "flight.json", "--views", "0,48")
        self.assertGreater(psnr(renders / "0.png", first), 50)
        self.assertGreater(psnr(renders / "48.png", last), 50)
        with self.viewer(self.folder, SCENE, "--path", "flight.json") as viewer:
            viewer.pictures = 4
            viewer.do("key", "space")
            time.sleep(3)
            self.assertGreater(psnr(viewer.picture(), last), 50)

    def test_dropped_files_are_added_and_what_is_broken_ends_nothing(self):
        ball = self.folder / "ball.ply"
        self.assertEqual(tool(self.folder, "convert", "builtin:3000", str(ball), "--transform", "scale:0.5").stderr, "")
        broken = self.folder / "broken.ply"
        broken.write_text("ply\nformat nonsense\n", encoding="utf-8")
        both = self.render(str(ball), "--place", "--views", "0") / "front.png"
        with self.viewer(self.folder, SCENE, "--renderer", "cpu") as viewer:
            alone = viewer.picture()
            drop(*viewer.place(), [broken])
            drop(*viewer.place(), [ball])
            added = viewer.picture()
        self.assertLess(psnr(added, alone), 40)
        self.assertEqual(psnr(added, both), float("inf"))

    def refusal(self, environment, *arguments):
        ran = subprocess.run([SWIFTGS, "view", *arguments], cwd=self.folder, env=environment, capture_output=True,
                             text=True, check=False, timeout=60)
        self.assertEqual((ran.returncode, ran.stdout), (1, ""))
        self.assertRegex(ran.stderr, r"\Aswiftgs: [^\n]*\n\Z")
        return ran.stderr

    def test_what_cannot_be_shown_is_refused_in_one_line(self):
        self.assertRegex(self.refusal(without_display(), SCENE), "view: .*; expected a display with OpenGL")
        (self.folder / "broken.ply").write_text("ply\nformat nonsense\n", encoding="utf-8")
        (self.folder / "empty.ply").write_text(EMPTY_PLY, encoding="utf-8")
        (self.folder / "broken.json").write_text("{", encoding="utf-8")
        with display(XVFB, "-extension", "GLX") as environment:
            self.assertRegex(self.refusal(environment, SCENE), "view: .*; expected a display with OpenGL")
        with display(XVFB) as environment:
            self.assertIn("broken.ply: byte ", self.refusal(environment, "broken.ply"))
            self.assertIn("empty.ply: expected a Gaussian or more", self.refusal(environment, "empty.ply"))
            self.assertIn("none.ply", self.refusal(environment, "none.ply"))
            self.assertIn("broken.json", self.refusal(environment, SCENE, "--path", "broken.json"))
            self.assertIn("'gpu'", self.refusal(environment, SCENE, "--renderer", "gpu"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
