# SPDX-License-Identifier: Apache-2.0
"""Runs an example that opens a window: XVFB EXAMPLE EXPECTED_PICTURE."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from display import display, without_display  # noqa: E402

XVFB, EXAMPLE, EXPECTED_PICTURE = sys.argv[1:]


def run(environment, *arguments):
    return subprocess.run([EXAMPLE, *arguments], env=environment, capture_output=True, text=True, check=False,
                          timeout=120)


class Host(unittest.TestCase):
    def test_it_shows_what_the_library_composes(self):
        with tempfile.TemporaryDirectory() as folder, display(XVFB) as environment:
            picture = pathlib.Path(folder) / "picture.png"
            ran = run(environment, "--screenshot", str(picture))
            self.assertEqual((ran.returncode, ran.stdout, ran.stderr), (0, "", ""))
            compared = subprocess.run([EXPECTED_PICTURE, str(picture)], capture_output=True, text=True, check=False)
        print(compared.stdout)
        self.assertEqual((compared.returncode, compared.stderr), (0, ""), compared.stdout)

    def one_line(self, environment):
        ran = run(environment)
        self.assertGreater(ran.returncode, 0)
        self.assertRegex(ran.stderr, rf"\A{pathlib.Path(EXAMPLE).name}: [^\n]*expected a display[^\n]*\n\Z")

    def test_without_a_display_it_says_so_in_one_line(self):
        self.one_line(without_display())

    def test_on_a_display_without_opengl_it_says_so_in_one_line(self):
        with display(XVFB, "-extension", "GLX") as environment:
            self.one_line(environment)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
