# SPDX-License-Identifier: Apache-2.0
"""benchmarks/compare: names what moved beyond its noise, and nothing else."""
import copy
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import synthetic

PROGRAM = pathlib.Path(__file__).resolve().parent.parent / "compare"
SLOWED = "cuda/early/axis-shared-threshold-float-cholesky/ellipse"


class Compare(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def compare(self, before, after, *options):
        """(exit code, standard output, standard error)"""
        place = pathlib.Path(self.folder.name)
        files = [synthetic.write(place / name, content)
                 for name, content in (("before.json", before), ("after.json", after))]
        ran = subprocess.run([sys.executable, "-B", str(PROGRAM), *files, *options], capture_output=True, text=True,
                             check=False, env={**os.environ, "PYTHONIOENCODING": "utf-8"})
        return ran.returncode, ran.stdout, ran.stderr

    def named(self, output, heading):
        """Cells of the table under a heading."""
        part = output.split(f"## {heading}\n\n")[1].split("\n\n")[0] if f"## {heading}\n" in output else ""
        return [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in part.splitlines()[2:]]

    def test_noise_alone_names_nothing(self):
        few = {"noise": 0.05, "frames": 7}
        for before, after, how in (*((seed, 100 + seed, {}) for seed in range(5)), (1, 2, few)):
            code, output, _ = self.compare(synthetic.run(before, **how), synthetic.run(after, **how))
            self.assertIn("Nothing moved beyond its noise.", output)
            self.assertEqual(code, 0)

    def test_a_stage_that_is_5_percent_slower_is_found_and_nothing_else_is_named(self):
        for seed, stage in enumerate(synthetic.STAGES):
            after = synthetic.run(200 + seed, slower={SLOWED: {stage: 1.05}})
            code, output, _ = self.compare(synthetic.run(seed), after)
            self.assertEqual(code, 1)
            means = self.named(output, "Means over all rows of a renderer")
            self.assertEqual([(row[0], row[1], row[2]) for row in means], [(f"`{SLOWED}`", stage, "slower")])
            self.assertAlmostEqual(float(means[0][4].rstrip(" %")), 5, delta=1)
            self.assertEqual({(row[3], row[4]) for row in self.named(output, "Rows")} - {(f"`{SLOWED}`", stage)}, set())

    def test_a_change_that_single_rows_hide_is_found_in_their_mean(self):
        after = synthetic.run(2, noise=0.05, views=30, frames=7, slower={SLOWED: {"sort": 1.05}})
        code, output, _ = self.compare(synthetic.run(1, noise=0.05, views=30, frames=7), after)
        self.assertEqual(self.named(output, "Rows"), [])
        self.assertEqual([row[1] for row in self.named(output, "Means over all rows of a renderer")], ["sort"])
        self.assertEqual(code, 1)

    def test_what_is_quicker_is_named_but_is_no_failure(self):
        code, output, _ = self.compare(synthetic.run(1), synthetic.run(2, slower={SLOWED: {"raster": 0.8}}))
        self.assertIn(("raster", "quicker"),
                      [tuple(row[1:3]) for row in self.named(output, "Means over all rows of a renderer")])
        self.assertEqual(code, 0)

    def test_a_change_below_the_threshold_is_none(self):
        before, after = synthetic.run(1), synthetic.run(2, slower={SLOWED: {"raster": 1.05}})
        self.assertEqual(self.compare(before, after, "--threshold", "0.1")[0], 0)

    def test_a_frame_that_is_less_exact_is_named(self):
        before = synthetic.run(1)
        for member, value in (("psnr_db", 101.9), ("max_abs", 2.8e-3), ("ssim", 0.9999), ("photo_psnr_db", 24.0)):
            if member == "photo_psnr_db":
                before["rows"][3][member] = 24.1
            after = copy.deepcopy(before)
            after["rows"][3][member] = value
            code, output, _ = self.compare(before, after)
            self.assertEqual([(row[4], row[5]) for row in self.named(output, "Rows")], [(member, "worse")])
            self.assertEqual(code, 1)

    def test_equal_images_that_differ_now_are_less_exact(self):
        before = synthetic.run(1)
        before["rows"][0].update(psnr_db=None, max_abs=0)
        code, output, _ = self.compare(before, synthetic.run(1))
        self.assertEqual({row[4] for row in self.named(output, "Rows")}, {"psnr_db", "max_abs"})
        self.assertIn("equal", output)
        self.assertEqual(code, 1)

    def test_counts_and_memory_that_differ_are_named_but_are_no_failure(self):
        before = synthetic.run(1)
        after = copy.deepcopy(before)
        after["rows"][5].update(intersections=1700000, device_bytes=2**30)
        code, output, _ = self.compare(before, after)
        self.assertEqual({(row[4], row[5]) for row in self.named(output, "Rows")},
                         {("intersections", "other"), ("device_bytes", "other")})
        self.assertEqual(code, 0)

    def test_rows_of_one_file_are_counted(self):
        before, after = synthetic.run(1), synthetic.run(1)
        before["rows"] = [row for row in before["rows"] if row["renderer"] != SLOWED]
        after["rows"] = after["rows"][:-2]
        code, output, _ = self.compare(before, after)
        self.assertIn(f"Only after: 8 rows, of `{SLOWED}` (8).", output)
        self.assertIn("Only before: 2 rows", output)
        self.assertEqual(code, 0)

    def test_times_of_fewer_than_six_frames_are_not_compared_and_that_is_said(self):
        for frames in range(1, 6):
            for seed in range(4):
                code, output, _ = self.compare(synthetic.run(seed, noise=0.05, frames=frames),
                                               synthetic.run(100 + seed, noise=0.05, frames=frames))
                self.assertIn("Times of 144 rows are not compared: fewer than 6 frames do not tell", output)
                self.assertIn("Nothing moved beyond its noise.", output)
                self.assertEqual(code, 0)

    def test_one_file_of_few_frames_is_enough_to_leave_times_out(self):
        after = synthetic.run(2, frames=5, slower={SLOWED: {"sort": 2}})
        code, output, _ = self.compare(synthetic.run(1), after)
        self.assertIn("Times of 144 rows are not compared", output)
        self.assertEqual(code, 0)

    def test_a_frame_that_its_stages_explain_more_than_wholly_is_not_named(self):
        def times(raster, total):
            return {stage: {"median": ms, "low": ms, "high": ms} for stage, ms in
                    (("project", 0.1), ("sort", 0.1), ("raster", raster), ("total", total), ("wall", total))}

        before, after = (synthetic.file_of([synthetic.row(times(raster, total), view=str(view)) for view in range(2)])
                         for raster, total in ((0.2, 0.4), (9.0, 3.0)))
        code, output, _ = self.compare(before, after)
        self.assertEqual([tuple(row[1:3]) for row in self.named(output, "Means over all rows of a renderer")],
                         [("raster", "slower")])
        self.assertEqual({row[4] for row in self.named(output, "Rows")}, {"raster"})
        self.assertEqual(code, 1)

    def test_only_a_slower_rasterization_passes_for_the_one_that_is_looked_for(self):
        place, program = pathlib.Path(self.folder.name), PROGRAM.parent.parent / "tests" / "bench" / "find_slowdown.py"
        for name, seed, slower in (("before", 1, {}), ("same", 2, {}), ("slower", 3, {"raster": 1.05}),
                                   ("quicker", 4, {"raster": 0.95}), ("sorts", 5, {"raster": 1.05, "sort": 1.05})):
            synthetic.write(place / f"{name}.json", synthetic.run(seed, slower={SLOWED: slower}))
        for after, same, message in (("slower", "same", None), ("quicker", "same", "expected exit code 1"),
                                     ("sorts", "same", "slower; named was ('sort', 'slower')"),
                                     ("same", "same", "the slower rasterization was not found"),
                                     ("slower", "quicker", "the same renderer; named was ('raster', 'quicker')")):
            folder = place / f"{after}-{same}"
            folder.mkdir()
            for name, content in (("before", "before"), ("after", after), ("same", same)):
                (folder / f"{name}.json").write_text((place / f"{content}.json").read_text(encoding="utf-8"),
                                                     encoding="utf-8")
            ran = subprocess.run([sys.executable, "-B", str(program), str(PROGRAM), str(folder), "true"],
                                 capture_output=True, text=True, check=False)
            self.assertEqual(ran.returncode, 1 if message else 0, ran.stdout + ran.stderr)
            self.assertEqual(ran.stdout.count(message or "named was"), 3 if message else 0, ran.stdout)
        noisy = place / "slower-same"
        for seed, (name, slower) in enumerate((("before", 1), ("after", 1.05), ("same", 1))):
            synthetic.write(noisy / f"{name}.json", synthetic.run(seed, views=1, noise=0.2, slower={
                renderer: {"raster": slower} for renderer in synthetic.RENDERERS}))
        ran = subprocess.run([sys.executable, "-B", str(program), str(PROGRAM), str(noisy), "true"],
                             capture_output=True, text=True, check=False)
        self.assertEqual(ran.returncode, 77, ran.stdout + ran.stderr)
        self.assertIn("skipped: a standard error of ", ran.stdout)

    def test_another_machine_is_warned_about(self):
        after = synthetic.run(1)
        after["machine"].update(gpu="another GPU", driver="1.0")
        _, output, _ = self.compare(synthetic.run(1), after)
        self.assertIn("**Not the same machine**: gpu was 'a GPU', is 'another GPU'.", output)
        self.assertIn("driver was None, is '1.0'", output)

    def test_threads_of_the_host_do_not_tell_frames_of_a_gpu_apart_but_those_of_a_cpu(self):
        after = synthetic.run(1)
        for row in after["rows"]:
            row["threads"] = 2
        self.assertIn("144 rows are in both", self.compare(synthetic.run(1), after)[1])
        for row in after["rows"]:
            row["backend"] = "cpu"
        self.assertEqual(self.compare(synthetic.run(1), after)[0], 2)

    def test_what_is_no_result_file_is_one_line_and_code_2(self):
        good, place = synthetic.run(1, views=1), self.folder.name
        no_stage, twice, swapped, text = (copy.deepcopy(good) for _ in range(4))
        del no_stage["rows"][2]["ms"]["raster"]
        twice["rows"].append(twice["rows"][0])
        swapped["rows"][0]["ms"]["sort"]["low"] = 9
        text["rows"][0]["psnr_db"] = "high"
        for bad, message in (("no JSON", "expected JSON"), ("[]", "expected a JSON object"), ("[" * 99999, "expected"),
                             ({**good, "version": 2}, "version 2; expected 'swiftgs-bench', 1"),
                             ({**good, "rows": {}}, "rows: expected an array"),
                             ({**good, "rows": [7]}, "rows[0]: expected an object"),
                             (no_stage, "rows[2].ms.raster: expected low <= median <= high"),
                             (swapped, "rows[0].ms.sort: expected low <= median <= high"),
                             (text, "rows[0].psnr_db: expected a number or null"), (twice, "is there twice"),
                             ({**good, "rows": []}, "no row is also in")):
            code, output, error = self.compare(good, bad)
            self.assertEqual((code, output), (2, ""))
            self.assertRegex(error, rf"\Acompare: {place}/after.json: [^\n]*\n\Z")
            self.assertIn(message, error)

    def test_a_file_that_is_not_there_is_one_line_and_code_2(self):
        ran = subprocess.run([sys.executable, "-B", str(PROGRAM), "absent.json", "absent.json"], capture_output=True,
                             text=True, check=False)
        self.assertEqual(ran.returncode, 2)
        self.assertEqual(ran.stderr, "compare: absent.json: No such file or directory; expected a readable file\n")


if __name__ == "__main__":
    unittest.main()
