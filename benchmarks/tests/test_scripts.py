# SPDX-License-Identifier: Apache-2.0
"""The shell scripts, with programs in place of swiftgs and of the browser that say how they were called."""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parent)]

import synthetic  # noqa: E402
import synthetic_folder  # noqa: E402

BENCHMARKS = pathlib.Path(__file__).resolve().parent.parent
ROOT = BENCHMARKS.parent
SWIFTGS = """#!/bin/sh
[ "$1" != list ] || { echo "cpu/early/per-pixel/ellipse runs here"; exit 0; }
if [ "$1" = info ]; then
  [ -e "$2/fox.spz" ] || { echo "$2: expected a capture" >&2; exit 1; }
  echo "{\\"cameras\\": \\"$2/cameras.json\\", \\"photos\\": \\"$2/photos\\"}"
  exit 0
fi
echo "$*" >>"$CALLS"
while [ $# -gt 0 ]; do [ "$1" != --json ] || echo '"command": "swiftgs"' >"$2"; shift; done
"""
# Has measured: its results are files in FILES.
MEASURED = """#!/bin/sh
[ "$1" != list ] || { echo "cpu/early/per-pixel/ellipse runs here"; exit 0; }
echo "$*" >>"$CALLS"
while [ $# -gt 0 ]; do
  [ "$1" != --json ] || cp "$FILES/${2##*/}" "$2"
  [ "$1" != --out ] || : >"$2"
  shift
done
"""
NCU = """#!/bin/sh
echo "$*" >>"$CALLS"
echo "a line of the program"
echo '"ID","Kernel Name"'
"""
BROWSER = """#!/bin/sh
mkdir "${4#--user-data-dir=}"
echo '<p id="figures"></p><p data-figure="pareto-fox">PHN2Zy8+</p>'
"""


def program(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    path.chmod(0o755)


class Scripts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.place = pathlib.Path(folder.name)
        program(self.place / "build" / "examples" / "swiftgs", SWIFTGS)
        self.fox = self.place / "scenes" / "fox"
        (self.fox / "photos").mkdir(parents=True)
        for name in ("fox.spz", "fox.spz.sort.json", "fox.json", "cameras.json", "photos/0001.jpg"):
            (self.fox / name).write_text(name, encoding="utf-8")

    def run_script(self, script, *arguments, **variables):
        temporary = self.place / "temporary"
        temporary.mkdir(exist_ok=True)
        return subprocess.run([str(BENCHMARKS / script), *map(str, arguments)], capture_output=True, text=True,
                              check=False, env={"PATH": os.environ["PATH"], "TMPDIR": str(temporary), **variables})

    def measure(self, *parts, options=(), **variables):
        """(exit code, standard error but for names of files, [arguments of swiftgs])"""
        calls = self.place / "calls"
        calls.write_text("", encoding="utf-8")
        ran = self.run_script("measure_matrix.sh", *options, self.place / "out", *parts, CALLS=str(calls),
                              SWIFTGS_BUILD=str(self.place / "build"), SWIFTGS_SCENES=str(self.place / "scenes"),
                              **variables)
        error = re.sub(r"measure: \S+\.json\n", "", ran.stderr)
        return ran.returncode, error, [line.split() for line in calls.read_text(encoding="utf-8").splitlines()]

    def expect_the_capture_as_it_was(self):
        self.assertEqual(sorted(path.name for path in self.fox.iterdir()),
                         ["cameras.json", "fox.json", "fox.spz", "fox.spz.sort.json", "photos"])
        self.assertEqual([path.name for path in (self.fox / "photos").iterdir()], ["0001.jpg"])

    def test_captures_are_the_folders_in_which_swiftgs_finds_cameras(self):
        (self.place / "scenes" / "empty").mkdir()
        code, error, calls = self.measure("prune")
        self.assertEqual((code, error), (0, ""))
        self.assertEqual([call[1] for call in calls if call[0] == "prune"], 2 * [str(self.fox)])

    def test_frames_too_few_for_an_interval_are_refused(self):
        for frames in ("4", "few", "-6"):
            self.assertEqual(self.measure("matrix", MIN_FRAMES=frames),
                             (2, f"measure: MIN_FRAMES is '{frames}'; expected 6 or more\n", []))
        code, _, calls = self.measure("matrix", MIN_FRAMES="08")
        self.assertEqual(code, 0)
        self.assertEqual(calls[0][calls[0].index("--min-frames") + 1], "08")

    def test_one_command_has_the_front_and_the_papers_tables_of_a_scene_at_any_scale(self):
        program(self.place / "build" / "examples" / "swiftgs", MEASURED)
        rows = synthetic_folder.matrix("cpu", ("builtin",), scale=0.25, photo_psnr_db=None)
        synthetic.write(self.place / "matrix.json", synthetic.file_of(rows))
        vanilla = synthetic.file_of([{**row, "conventions": "inria"} for row in rows if row["bounds"] != "ellipse"])
        for name in ("vanilla.json", "pruned.json"):
            synthetic.write(self.place / name, vanilla)
        calls, out = self.place / "calls", self.place / "out"
        ran = self.run_script("your_machine.sh", out, "builtin:500", "--scales", "0.25", "--views", "0,2", CALLS=str(calls),
                              FILES=str(self.place), SWIFTGS_BUILD=str(self.place / "build"))
        self.assertEqual(ran.returncode, 0, ran.stderr)
        page = (out / "README.md").read_text(encoding="utf-8")
        for table in ("pareto cpu", "steps cpu", "accuracy cpu", "vanilla cpu", "pruned cpu", "paper-scenes", "paper-steps",
                      "paper-accuracy", "paper-pruned"):
            self.assertRegex(page, rf"<!-- table: {table} -->\n\n[^<]+\| --- \|[^<]+<!-- end -->")
        self.assertIn("\nNot measured on every scene: `adaptive/axis-shared-threshold-float-cholesky/ellipse`.\n", page)
        matrix, old, prune, pruned, report = [line.split() for line in calls.read_text(encoding="utf-8").splitlines()]
        self.assertEqual([prune[:3], report[0]], [["prune", "builtin:500", "--keep"], "report"])
        for call in (matrix, old, pruned):
            self.assertEqual([call[0], call[-1]], ["bench", "--resume"])
            self.assertEqual("--views" in call, call is not pruned)  # one view is found for a file
            self.assertEqual(call[call.index("--scales") + 1], "0.25")

    def test_with_resume_rows_that_are_there_are_kept_and_files_of_pages_are_made_of_whole_ones(self):
        for options in ((), ("--resume",)):
            code, error, calls = self.measure("vanilla", options=options)
            self.assertEqual((code, error), (0, ""))
            whole = self.place / "out" / "whole" / "vanilla.json"
            self.assertEqual(calls[0][calls[0].index("--json") + 1:], [str(whole), *options])
            self.assertEqual((self.place / "out" / "vanilla.json").read_text(encoding="utf-8"),
                             whole.read_text(encoding="utf-8"))

    def test_pruned_scenes_have_links_and_the_capture_stays_as_it_is(self):
        for _ in range(2):
            self.assertEqual(self.measure("prune")[0], 0)
        pruned = self.place / "out" / "pruned" / "fox-pruned"
        self.assertEqual(os.readlink(pruned / "photos"), str(self.fox / "photos"))
        self.assertEqual(os.readlink(pruned / "cameras.json"), str(self.fox / "cameras.json"))
        self.expect_the_capture_as_it_was()

    def test_lenses_are_captures_of_links_with_cameras_of_their_own(self):
        cameras = [{"img_name": "a", "width": 4, "height": 3, "fx": 5.5, "fy": 6.5}, {"img_name": "b"}]
        (self.fox / "cameras.json").write_text(json.dumps(cameras), encoding="utf-8")
        for _ in range(2):
            code, error, calls = self.measure("lenses")
            self.assertEqual((code, error), (0, ""))
        out = self.place / "out" / "lenses"
        names = [f"fox-{lens}{order}" for order in ("", "-ordered") for lens in ("pinhole", "opencv", "fisheye", "panorama")]
        self.assertEqual(calls[:2], [["convert", str(self.fox), str(out / "scene.ply")],
                                     ["convert", str(self.fox), "--order", str(out / "scene-ordered.ply")]])
        self.assertEqual(calls[2][:9], ["bench", *(str(out / name) for name in names)])
        self.assertEqual(calls[2][9:15], ["--renderers", "cpu/early/axis-shared-threshold-float-cholesky/ellipse",
                                          "--views", "0,3,6,9", "--errors", "none"])
        for name in names:
            _, lens, *ordered = name.split("-")
            self.assertEqual(os.readlink(out / name / f"{name}.ply"),
                             "../scene-ordered.ply" if ordered else "../scene.ply")
            first, second = json.loads((out / name / "cameras.json").read_text(encoding="utf-8"))
            model = {"opencv": "OPENCV", "fisheye": "OPENCV_FISHEYE", "panorama": "EQUIRECTANGULAR"}.get(lens)
            self.assertEqual((first.get("camera_model"), second.get("camera_model")), (model, model))
            self.assertEqual((first["width"], first["height"]), (2048, 1024) if lens == "panorama" else (4, 3))
            self.assertEqual([first.get(key) for key in ("fx", "fy", "k1", "k2", "p1", "p2")],
                             [5.5, 6.5, *4 * [1e-7 if lens == "opencv" else None]])
        self.assertEqual(json.loads((self.fox / "cameras.json").read_text(encoding="utf-8")), cameras)
        self.expect_the_capture_as_it_was()

    def test_lenses_need_a_capture_with_a_cameras_json(self):
        said = "measure: '{}': expected a capture with a cameras.json; lenses are not measured\n"
        program(self.place / "build" / "examples" / "swiftgs", SWIFTGS.replace("cameras.json", "sparse/0"))
        self.assertEqual(self.measure("lenses"), (0, said.format(self.fox), []))
        (self.fox / "fox.spz").rename(self.fox / "other.spz")
        self.assertEqual(self.measure("lenses"), (0, said.format(""), []))

    def test_harmonics_are_measured_in_each_form(self):
        code, error, calls = self.measure("harmonics")
        self.assertEqual((code, error), (0, ""))
        made = [str(self.place / "out" / "harmonics" / f"builtin-{form}.{form}") for form in ("spz", "sog")]
        self.assertEqual(calls[:2], [["convert", "builtin:1000000", file] for file in made])
        scenes = [str(self.fox), "builtin:1000000", *made]
        self.assertEqual([call[:5] for call in calls[2:]], 3 * [["bench", *scenes]])
        self.assertEqual([call[call.index("--harmonics") + 1] for call in calls[2:]], ["float", "smallest", "half"])

    def test_hard_frames_that_fail_a_renderer_fail_the_part_and_leave_both_files(self):
        code, error, calls = self.measure("stress")
        self.assertEqual((code, error), (0, ""))
        self.assertEqual([call[0] for call in calls], ["stress", "stress"])
        self.assertEqual([call[call.index("--size") + 1] for call in calls], ["64x48", "960x540,1920x1080"])
        self.assertEqual(calls[0][calls[0].index("--renderers") + 1], "cpu/early/*/ellipse")
        program(self.place / "build" / "examples" / "swiftgs", SWIFTGS + 'echo "$*" >&2\n[ "$1" = list ]\n')
        code, error, calls = self.measure("stress")
        self.assertEqual((code, len(calls)), (1, 2))
        self.assertIn("measure: stress FAILED", error)
        for name in ("stress.json", "stress-large.json"):
            self.assertTrue((self.place / "out" / name).exists())

    def test_kernels_are_profiled_in_the_first_view_of_captures_and_of_the_built_in_scene(self):
        program(self.place / "bin" / "ncu", NCU)
        calls, out = self.place / "calls", self.place / "out"
        ran = self.run_script("profile_kernels.sh", out, "builtin:500", "fox", CALLS=str(calls),
                              PATH=f"{self.place / 'bin'}:{os.environ['PATH']}", SWIFTGS_BUILD=str(self.place / "build"),
                              SWIFTGS_SCENES=str(self.place / "scenes"))
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        drawn = [call.split(f"{self.place / 'build'}/examples/swiftgs ")[1]
                 for call in calls.read_text(encoding="utf-8").splitlines() if " bench " in call]
        self.assertEqual([words.split(" --renderers ")[0] for words in drawn],
                         [f"bench {scene} --profile --views 0" for scene in ("builtin:500", self.fox, "builtin:500")])
        self.assertIn("cuda/standard/axis-shared-threshold-float-cholesky/ellipse", drawn[0])
        for name in ("kernels-builtin-500.csv", "kernels-fox.csv"):
            self.assertEqual((out / name).read_text(encoding="utf-8"), '"ID","Kernel Name"\n')

    def test_figures_are_saved_and_where_the_profile_is_left_is_said(self):
        program(self.place / "browser", BROWSER)
        page, folder = self.place / "report.html", self.place / "figures"
        page.write_text("a page", encoding="utf-8")
        folder.mkdir()
        (folder / "kept.txt").write_text("kept", encoding="utf-8")
        ran = self.run_script("figures.sh", page, folder, SWIFTGS_BROWSER=str(self.place / "browser"))
        self.assertEqual((ran.returncode, ran.stdout), (0, f"{folder}/pareto-fox.svg\n"))
        self.assertEqual((folder / "pareto-fox.svg").read_text(encoding="utf-8"), "<svg/>")
        self.assertTrue((folder / "kept.txt").exists() and page.exists())
        left = re.fullmatch(r"figures: the browser's profile is left in (\S+)\n", ran.stderr)
        self.assertIsNotNone(left, ran.stderr)
        self.assertEqual([path.name for path in pathlib.Path(left[1]).iterdir()], ["profile"])

    def test_no_script_deletes_folders_with_what_is_in_them(self):
        """But one: systems to test packages in, whose names stand in the line before."""
        allowed = '  rm -rf --one-file-system "$source/build/release_check/roots/$1"'
        scripts = [path for path in ROOT.rglob("*.sh") if "build" not in path.relative_to(ROOT).parts[:1]]
        self.assertGreater(len(scripts), 5)
        for script in scripts:
            for line in script.read_text(encoding="utf-8").splitlines():
                if (script.name, line) == ("release_check.sh", allowed):
                    continue
                with self.subTest(script=script.name, line=line):
                    self.assertNotRegex(line, r"\brm +(-\S+ +)*-(\w*[rR]|-recursive)|\bfind\b.*-delete|^\s*trap\b")


if __name__ == "__main__":
    unittest.main()
