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
from display import display, screen, without_display  # noqa: E402
from messages import close, drop  # noqa: E402

XVFB, XDOTOOL, SWIFTGS = sys.argv[1:]
SCENE = "builtin:20000"
EMPTY_PLY = "ply\nformat binary_little_endian 1.0\nelement vertex 0\n" + "".join(
    f"property float {name}\n" for name in "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 "
    "rot_0 rot_1 rot_2 rot_3".split()) + "end_header\n"


PLANE = 7  # row of the panel, counted from the first scene's, where there is one scene


def y_of(row):
    return 177 + 23 * row


def distance(pixel, other):
    return max(abs(a - b) for a, b in zip(pixel, other))


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
        self.window = ""
        wait_for("the window", lambda: self.found() or process.poll() is not None)
        self.do("windowfocus", "--sync", self.window)

    def found(self):
        """The number stays, while a search under load may miss the window whose title changes."""
        found = subprocess.run([XDOTOOL, "search", "--onlyvisible", "--name", "SwiftGS - "], env=self.environment,
                               capture_output=True, text=True, check=False)
        self.window = found.stdout.strip()
        return self.window

    def place(self):
        """Its screen, and the window's number there."""
        return self.environment["DISPLAY"], int(self.window)

    def do(self, *words):
        subprocess.run([XDOTOOL, *words], env=self.environment, check=True, timeout=60)

    def drag(self, button, right, down):
        self.do("mousemove", "800", "400", "sleep", "0.5", "mousedown", button)
        for step in range(10):
            self.do("mousemove", str(800 + right * (step + 1) // 10), str(400 + down * (step + 1) // 10))
        self.do("mouseup", button)

    def click(self, x, row):
        self.do("mousemove", str(x), str(y_of(row)), "sleep", "0.5", "mousedown", "1", "sleep", "0.8", "mouseup", "1",
                "sleep", "0.5")

    def type_into(self, x, row, text):
        """In the control there."""
        self.do("keydown", "ctrl", "sleep", "0.3")
        self.click(x, row)
        self.do("keyup", "ctrl", "type", text)
        self.do("sleep", "0.5", "keydown", "Return", "sleep", "1", "keyup", "Return")  # held while a frame is drawn

    def pixels(self, left, right, top, bottom):
        """What the screen shows there."""
        return [[row[4 * x:4 * x + 4] for x in range(left, right)] for row in screen(self.screens)[top:bottom]]

    def legend(self):
        return self.pixels(1180, 1270, 12, 140)

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
        with display(XVFB, "-fbdir", str(self.screens)) as environment, subprocess.Popen(
                [SWIFTGS, "view", *arguments], cwd=folder, env=environment, stdout=subprocess.PIPE,
                stderr=subprocess.PIPE, text=True) as process:
            try:
                viewer = Viewer(folder, environment, process)
                viewer.screens = self.screens
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
        self.folder, self.screens = pathlib.Path(temporary.name) / "here", pathlib.Path(temporary.name) / "screens"
        self.folder.mkdir(), self.screens.mkdir()

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

    def test_a_list_is_edited_and_saved_and_render_draws_the_same_bits(self):
        lists = self.folder / "lists"
        lists.mkdir()
        self.assertEqual(tool(self.folder, "convert", "builtin:500", "ball.ply", "--transform", "scale:0.5").stderr, "")
        scenes = [{"file": "builtin:2000", "clip": {"sphere": [0, 0, 0, 30.1]}},
                  {"file": "../ball.ply", "rotation": [0.9, 0.1, 0.3, -0.2], "translation": [0.1, -0.7, 1 / 3],
                   "clip": {"half_spaces": [[1, 0.3, 0, -9.1]]}},
                  {"file": "../ball.ply", "translation": [1, 0, 0], "clip": {"box": [-9, -9, -9, 9, 9, 9]}}]
        file = lists / "scenes.json"
        file.write_text(json.dumps(scenes), encoding="utf-8")
        with self.viewer(self.folder, "lists/scenes.json", "--renderer", "cpu") as viewer:
            viewer.picture()  # the window is there
            viewer.click(25, 2)
            viewer.click(53, 1)
            viewer.type_into(175, 5, "0.7")
            viewer.type_into(175, 4, "1000")  # beyond its end
            edited = viewer.picture()
            viewer.do("key", "l")
            wait_for("the list", lambda: "visible" in file.read_text(encoding="utf-8"))
        ball, hidden = json.loads(file.read_text(encoding="utf-8"))[1:]
        self.assertEqual((ball["scale"], hidden["visible"]), (100, False))
        self.assertAlmostEqual(ball["opacity"], 0.7, 6)
        self.assertEqual({name: ball[name] for name in ("file", "translation", "clip")},
                         {name: scenes[1][name] for name in ("file", "translation", "clip")})
        ran = tool(self.folder, "render", "lists/scenes.json", "--views", "0")
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        self.assertEqual(psnr(self.folder / "renders" / "front.png", edited), float("inf"))

    def test_a_window_with_edits_asks_before_it_closes(self):
        with self.viewer(self.folder, SCENE) as viewer:
            viewer.do("key", "k")
            close(*viewer.place())
            time.sleep(2)
            self.assertIsNone(viewer.process.poll())
            viewer.do("key", "Escape", "sleep", "1", "key", "f")
            wait_for("the path", (self.folder / "camera_path-1.json").exists)

    def test_depths_have_a_legend_that_follows_the_view(self):
        with self.viewer(self.folder, SCENE) as viewer:
            viewer.picture()
            viewer.click(150, PLANE)
            viewer.do("mousemove", "50", str(y_of(PLANE) + 59), "sleep", "0.5", "click", "1")
            for colour in (115, 26, 38), (77, 242, 255):  # blue, green, red of the nearest and the farthest
                wait_for("the colour in the sky's corner", lambda c=colour: any(
                    distance(pixel, c) < 12 for row in viewer.legend() for pixel in row))
            before = viewer.legend()
            viewer.do("mousemove", "800", "400", "click", "5", "click", "5", "click", "5")  # away
            wait_for("other numbers", lambda: viewer.legend() != before)

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
