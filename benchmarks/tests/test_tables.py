# SPDX-License-Identifier: Apache-2.0
"""benchmarks/update_tables.py: the tables of Markdown files are what the results give."""
import collections
import csv
import dataclasses
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import synthetic  # noqa: E402
import synthetic_folder  # noqa: E402
import update_tables  # noqa: E402
from tables import blocks, ceilings, fits, paper  # noqa: E402
from tables.frames import OURS  # noqa: E402
from tables.results import OPTIONAL, STAGES, Duration, InputError, Results  # noqa: E402
from tables.source import FOLDERS, RESULTS, Source  # noqa: E402

PROGRAM = HERE.parent / "update_tables.py"
ROOT = HERE.parent.parent


def pages():
    return (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted(pathlib.Path(RESULTS).glob("*/*.md")))


def blocks_of_pages():
    """{(name, words)} of tables of every kind: of those that differ by machines alone, one."""
    found = {}
    for page in pages():
        for line in page.read_text(encoding="utf-8").splitlines():
            begin = blocks.BEGIN.fullmatch(line.strip())
            if begin:
                words = begin[2].split()
                found.setdefault((begin[1], tuple(word for word in words if word not in FOLDERS)), (begin[1], words))
    return list(found.values())


def without(row, member, value):
    """A row whose `member` is `value`, or a stage that took that long."""
    if member in STAGES:
        return dataclasses.replace(row, ms={**row.ms, member: Duration(value, value, value)})
    return dataclasses.replace(row, **{member: value})


def cells(text, first):
    """The cells of the row that begins with `first`."""
    line = next(line for line in text.splitlines() if line.startswith(f"| {first} |"))
    return [cell.strip() for cell in line.strip("| ").split(" | ")]


class Tables(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.place = pathlib.Path(cls.folder.name)
        cls.results = cls.place / "results"
        for machine, backend in (("gpu", "cuda"), ("cpu", "cpu"), ("cpu2", "cpu")):
            synthetic_folder.write(cls.results / FOLDERS[machine], backend, older=machine == "cpu")
        for path in (pathlib.Path(RESULTS) / FOLDERS["gpu"]).glob("*.csv"):
            shutil.copy(path, cls.results / FOLDERS["gpu"])
        synthetic_folder.write(cls.results / FOLDERS["amd"], "cpu")
        synthetic_folder.write(cls.results / FOLDERS["h200"], "cuda")
        for machine in ("amd", "h200"):
            shutil.copy(pathlib.Path(RESULTS) / FOLDERS[machine] / "ulps.json", cls.results / FOLDERS[machine])
        shutil.copy(pathlib.Path(RESULTS) / FOLDERS["amd"] / "formats.json", cls.results / FOLDERS["amd"])
        for machine in ("xeon", "xeon24", "xeon26"):
            synthetic_folder.write(cls.results / FOLDERS[machine], "cpu")
        # The last one written gives the files that have no backend in their names.
        for machine in ("hopper", "nvidia24", "nvidia", "h100"):
            for backend in ("cpu", "cuda"):
                synthetic_folder.write(cls.results / FOLDERS[machine], backend)
        for machine, name in (("xeon", "python.json"), ("hopper", "python.json"), ("hopper", "beside-gsplat.json")):
            shutil.copy(pathlib.Path(RESULTS) / FOLDERS[machine] / name, cls.results / FOLDERS[machine])
        for machine in ("h100", "xeon26"):  # tables of severities name families
            for path in (pathlib.Path(RESULTS) / FOLDERS[machine]).glob("stress*.json"):
                shutil.copy(path, cls.results / FOLDERS[machine])

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def update(self, text, *options, results=None):
        """(exit code, text afterwards, standard output, standard error)"""
        page = self.place / "page.md"
        page.write_text(text, encoding="utf-8")
        ran = subprocess.run([sys.executable, "-B", str(PROGRAM), "--results", str(results or self.results), *options,
                              str(page)], capture_output=True, text=True, check=False)
        return ran.returncode, page.read_text(encoding="utf-8"), ran.stdout, ran.stderr

    def table(self, words):
        code, text, _, error = self.update(f"<!-- table: {words} -->\n<!-- end -->\n")
        self.assertEqual((code, error), (0, ""))
        return text

    def test_a_block_is_written_anew_and_what_is_around_it_stays(self):
        code, text, _, _ = self.update("before\n<!-- table: paper-steps -->\nold\n<!-- end -->\nafter\n")
        self.assertEqual(code, 0)
        self.assertTrue(text.startswith("before\n<!-- table: paper-steps -->\n\n| step | RTX 3090, 7k |"))
        self.assertTrue(text.endswith("|\n\n<!-- end -->\nafter\n"))
        self.assertNotIn("old", text)
        self.assertEqual(self.update(text)[1], text)

    def test_check_finds_a_number_that_drifted_and_changes_nothing(self):
        good = self.table("steps gpu")
        self.assertEqual(self.update(good, "--check")[0], 0)
        drifted = good.replace("3.50", "3.40")
        code, text, output, _ = self.update(drifted, "--check")
        self.assertEqual((code, text), (1, drifted))
        self.assertIn("\n-", output)
        self.assertIn("3.50", output)

    def test_a_table_whose_file_is_missing_is_one_line_and_its_block_stays(self):
        page = "<!-- table: steps gpu -->\nold\n<!-- end -->\n<!-- table: ceilings -->\n<!-- end -->\n"
        code, text, _, error = self.update(page, results=self.place)
        self.assertEqual(code, 2)
        self.assertIn("<!-- table: steps gpu -->\nold\n<!-- end -->", text)
        self.assertIn("TB/s", text)
        self.assertRegex(error, r"\Aupdate_tables: \S+page.md:1: \S+/matrix.json: no such file; expected [^\n]+\n\Z")

    def test_blocks_that_make_no_sense_are_one_line(self):
        for page, message in (("<!-- table: stepps gpu -->\n<!-- end -->", "no table 'stepps'; expected one of "),
                              ("<!-- table: steps -->\n<!-- end -->", "table 'steps' : expected MACHINE"),
                              ("<!-- table: steps tpu -->\n<!-- end -->", "no machine 'tpu'; expected one of gpu, cpu"),
                              ("<!-- table: growth gpu size -->\n<!-- end -->", "no axis 'size'; expected one of"),
                              ("<!-- table: ceilings -->\n", "block 'ceilings' does not end; expected <!-- end -->"),
                              ("<!-- table: ceilings -->\n<!-- table: ceilings -->\n<!-- end -->", "does not end")):
            code, text, _, error = self.update(page)
            self.assertEqual((code, text), (2, page))
            self.assertRegex(error, r"\Aupdate_tables: \S+page.md:1: [^\n]+\n\Z")
            self.assertIn(message, error)

    def test_a_broken_result_file_is_one_line(self):
        broken = self.place / "broken" / FOLDERS["gpu"]
        broken.mkdir(parents=True)
        (broken / "matrix.json").write_text("{}", encoding="utf-8")
        code, _, _, error = self.update("<!-- table: steps gpu -->\n<!-- end -->", results=broken.parent)
        self.assertEqual(code, 2)
        self.assertRegex(error, r"\A[^\n]+matrix.json: format None, version None; expected 'swiftgs-bench', 1\n\Z")

    def test_every_table_of_the_pages_can_be_made_of_what_the_script_measures(self):
        for page in pages():
            code, text, _, error = self.update(page.read_text(encoding="utf-8"))
            self.assertEqual((page.name, code, error), (page.name, 0, ""))
            self.assertNotRegex(text, r"<!-- table: [^\n]+ -->\n+<!-- end -->")

    def test_a_number_that_is_missing_or_0_is_a_dash_or_one_line_that_names_file_and_member(self):
        missing = [(member, None) for member in OPTIONAL]
        zeros = [(member, 0) for member in (*OPTIONAL, *STAGES, "gaussians", "width", "height", "threads", "enlarge")]
        refused = collections.Counter()
        for name, words in blocks_of_pages():
            source = Source(str(self.results))
            blocks.render(name, words, update_tables.TABLES, source)
            whole = {key: results for key, results in source.found.items() if isinstance(results, Results)}
            for key, results in whole.items():
                for member, value in missing + zeros:
                    for changed in (slice(None), slice(-1, None)):  # all rows, or the last
                        rows = list(results.rows)
                        rows[changed] = [without(row, member, value) for row in rows[changed]]
                        source.found[key] = dataclasses.replace(results, rows=rows)
                        with self.subTest(table=name, words=words, member=member, value=value):
                            try:
                                blocks.render(name, words, update_tables.TABLES, source)
                            except InputError as error:
                                refused[member] += 1
                                self.assertNotIn("\n", str(error))
                                self.assertIn(pathlib.Path(results.path).name, str(error))
                    source.found[key] = results
        for member in ("intersections", "visible", "sort", "raster", "total", "width"):
            self.assertGreater(refused[member], 0, member)

    def test_a_row_that_a_table_divides_by_is_named_with_its_file_and_member(self):
        rows = synthetic_folder.growing("cuda", [({"enlarge": e, "intersections": 1e6 * e}, {}) for e in (0.5, 1, 2)])
        rows[-1]["intersections"] = None
        folder = self.place / "null" / FOLDERS["gpu"]
        folder.mkdir(parents=True)
        (folder / "scaling-occupancy.json").write_text(
            json.dumps(synthetic_folder.synthetic.file_of(rows)), encoding="utf-8")
        for table in ("growth gpu occupancy", "exponents gpu occupancy", "dominates gpu occupancy"):
            code, _, _, error = self.update(f"<!-- table: {table} -->\n<!-- end -->\n", results=folder.parent)
            self.assertEqual(code, 2)
            self.assertRegex(error, r"\A[^\n]+/scaling-occupancy.json: intersections of cuda/[^\n]+ on view '0' of garden: "
                                    r"expected a number above 0\n\Z")

    def test_sorts_that_were_not_measured_at_the_same_places_are_not_set_side_by_side(self):
        folder = self.place / "uneven" / FOLDERS["gpu"]
        folder.mkdir(parents=True)
        rows = [row for row in synthetic_folder.growing("cuda", [({"gaussians": n}, {}) for n in (1, 2)])
                if row["gaussians"] == 1 or row["sort"] == "early"]
        (folder / "scaling-gaussians.json").write_text(
            json.dumps(synthetic_folder.synthetic.file_of(rows)), encoding="utf-8")
        error = self.update("<!-- table: sort-growth gpu gaussians -->\n<!-- end -->\n", results=folder.parent)[3]
        self.assertRegex(error, r"\A[^\n]+scaling-gaussians.json[^\n]*: garden: expected rows of [^\n]+\n\Z")

    def test_a_stage_is_shown_with_the_target_that_errs_most(self):
        found = json.loads((self.results / FOLDERS["amd"] / "ulps.json").read_text(encoding="utf-8"))
        for row in found["rows"]:
            if row["stage"] == "`Exp2`":
                row["ulps"] = 9.875 if row["target"] == "cpu AVX2" else 1
        folder = self.place / "ulps" / FOLDERS["amd"]
        folder.mkdir(parents=True)
        (folder / "ulps.json").write_text(json.dumps(found), encoding="utf-8")
        _, text, _, error = self.update("<!-- table: ulps amd -->\n<!-- end -->\n", results=folder.parent)
        self.assertEqual((error, cells(text, "`Exp2`")[2:]), ("", ["cpu AVX2", "9.88"]))
        found["rows"] = [row for row in found["rows"] if row["stage"] != "`l1`"]
        (folder / "ulps.json").write_text(json.dumps(found), encoding="utf-8")
        code, _, _, error = self.update("<!-- table: ulps amd -->\n<!-- end -->\n", results=folder.parent)
        self.assertEqual(code, 2)
        self.assertRegex(error, r"ulps.json: no row of `l1`; expected one of each stage\n\Z")

    def test_speed_ups_are_against_the_baseline(self):
        text = self.table("steps gpu")
        self.assertEqual(cells(text, "baseline")[2:], ["3.50 (1.00x)"] * 3 + ["1.00x", "24.8", "102.0"])
        self.assertEqual(cells(text, "AR")[2:], ["3.10 (1.13x)"] * 3 + ["1.13x", "24.8", "60.0"])
        self.assertEqual(cells(text, "ES")[2:], ["3.30 (1.06x)"] * 3 + ["1.06x", "24.8", "102.0"])
        self.assertEqual(cells(text, "all, our terms")[2:], ["2.30 (1.52x)"] * 3 + ["1.52x", "24.8", "102.0"])

    def test_steps_have_photographs_where_any_is_known(self):
        changed = json.loads((self.results / FOLDERS["gpu"] / "matrix.json").read_text(encoding="utf-8"))
        folder = self.place / "photographs"
        (folder / FOLDERS["gpu"]).mkdir(parents=True)
        for last, cell in ((OURS, ["-"]), ("", [])):
            for row in changed["rows"]:
                if row["renderer"].endswith(last):
                    row["photo_psnr_db"] = None
            synthetic.write(folder / FOLDERS["gpu"] / "matrix.json", changed)
            code, text, _, error = self.update("<!-- table: steps gpu -->\n<!-- end -->\n", results=folder)
            self.assertEqual((code, error), (0, ""))
            self.assertEqual("photographs, mean, dB" in text, bool(cell))
            self.assertEqual(cells(text, "and our bounds")[-1 - len(cell):-1], cell)
            self.assertEqual(len({line.count("|") for line in text.splitlines() if line.startswith("|")}), 1)

    def test_the_headline_has_ten_renderers_on_every_machine_and_the_least_psnr(self):
        text = self.table("headline gpu cpu")
        self.assertEqual(len([line for line in text.splitlines() if line.startswith("| `")]), 10)
        best = "`early/axis-shared-threshold-float-cholesky/ellipse`"
        self.assertEqual(cells(text, best)[1:], ["**ours**"] + 2 * ["2.30", "2.30", "102.0"])
        half = "`early/axis-shared-threshold-half-split/opacity-box`"
        self.assertEqual(cells(text, half)[1:], ["the paper's"] + 2 * ["2.80", "2.80", "60.0"])
        self.assertIn("`cpu` is a processor, 16 cores, 2 views a capture.", text.replace("\n", " "))
        changed = json.loads((self.results / FOLDERS["cpu"] / "matrix.json").read_text(encoding="utf-8"))
        for row in changed["rows"]:
            if row["scene"] == "fox" and row["view"] == "1":
                row["psnr_db"] = 77.0
        folder = self.place / "headline"
        for machine in ("gpu", "cpu"):
            (folder / FOLDERS[machine]).mkdir(parents=True)
        shutil.copy(self.results / FOLDERS["gpu"] / "matrix.json", folder / FOLDERS["gpu"])
        synthetic_folder.synthetic.write(folder / FOLDERS["cpu"] / "matrix.json", changed)
        text = self.update("<!-- table: headline gpu cpu -->\n<!-- end -->\n", results=folder)[1]
        self.assertEqual(cells(text, best)[4::3], ["102.0", "77.0"])
        changed["rows"] = [row for row in changed["rows"] if row["scene"] != "fox"]
        synthetic_folder.synthetic.write(folder / FOLDERS["cpu"] / "matrix.json", changed)
        error = self.update("<!-- table: headline gpu cpu -->\n<!-- end -->\n", results=folder)[3]
        self.assertRegex(error, r"[^\n]+matrix.json: expected the captures of [^\n]+matrix.json\n\Z")

    def test_loss_of_a_form_is_against_the_per_pixel_rasterizer(self):
        text = self.table("accuracy cpu")
        self.assertEqual(cells(text, "`axis-shared-half-split`")[1:],
                         ["24.7500 (-0.0500)"] * 3 + ["60.0"] * 3)
        self.assertEqual(cells(text, "`axis-shared-float-cholesky`")[1:], ["24.8000 (+0.0000)"] * 3 + ["102.0"] * 3)

    def test_the_square_of_a_preset_is_judged_with_and_without_its_cut(self):
        lines = [line for line in self.table("presets gpu").splitlines() if "three-sigma-square" in line]
        self.assertEqual([line.strip("| ").split(" | ")[1:] for line in lines],
                         [["the square's part of it"] + ["101.5"] * 3, ["all that alpha keeps"] + ["102.0"] * 3])

    def test_errors_that_depend_on_the_sort_are_told(self):
        same = self.table("sorts-change-nothing gpu")
        self.assertNotIn("except", same)
        rows = synthetic_folder.matrix("cuda")
        next(row for row in rows if row["renderer"] == "cuda/early/per-pixel/ellipse")["max_abs"] = 0.004
        other = self.place / "other" / FOLDERS["gpu"]
        other.mkdir(parents=True)
        (other / "matrix.json").write_text(json.dumps(synthetic_folder.synthetic.file_of(rows)), encoding="utf-8")
        text = self.update("<!-- table: sorts-change-nothing gpu -->\n<!-- end -->\n", results=other.parent)[1]
        self.assertIn("except `per-pixel` on garden, 1.5 M.", text.replace("\n", " "))

    def test_shares_and_ratios_of_stages(self):
        shares = cells(self.table("shares gpu"), "a GPU")
        self.assertEqual(shares[2:5], ["14.3 %", "28.6 %", "57.1 %"])
        self.assertEqual(cells(self.table("raster-stage gpu"), "AR + AT")[2], "1.50 (1.33x)")
        sort = cells(self.table("sort-stage gpu"), "garden, 1.5 M")
        self.assertEqual(sort[2:], ["12.00", "1.00", "0.800", "0.800", "-20.0 %", "-20.0 % to -20.0 %", "2 of 2",
                                    "+0.0 %"])

    def test_redundancy_counts_intersections_a_visible_gaussian(self):
        text = self.table("redundancy gpu")
        self.assertEqual(cells(text, "garden, 1.5 M, 2 views")[1:],
                         ["three-sigma-square", "500,000", "6,000,000", "6,000,000", "12.00", "12.00", "45.8 %"])

    def test_a_change_of_each_stage_is_a_part_of_what_it_was(self):
        text = self.table("change gpu frame cuda")
        self.assertEqual(cells(text, "garden, 1.5 M")[2:],
                         ["0.500 → 0.500 (+0.0 %)", "0.800 → 0.720 (-10.0 %)", "1.00 → 1.00 (+0.0 %)",
                          "2.30 → 2.22 (-3.5 %)", "102.0 → 102.0"])
        self.assertNotIn("dB", self.table("change gpu coarse cuda"))

    def test_bounds_stand_from_the_widest_to_the_tightest(self):
        text = self.table("bounds gpu")
        kinds = [line.split("|")[2].strip() for line in text.splitlines() if line.startswith("| garden, 1.5 M")]
        self.assertEqual(kinds, ["three-sigma-square", "opacity-box", "ellipse"])
        self.assertEqual(cells(text, "garden, 1.5 M")[1:],
                         ["three-sigma-square", "6,000,000", "0.500", "0.800", "1.00", "2.30", "102.0"])

    def test_pruned_scenes_stand_below_whole_ones(self):
        text = self.table("pruned gpu")
        self.assertEqual(cells(text, "garden-pruned")[1:],
                         ["0.15 M", "3.50", "2.80 (1.25x)", "2.30 (1.52x)", "2.30 (1.52x)"])
        self.assertEqual(cells(self.table("prune-quality gpu"), "garden")[1:],
                         ["contribution", "1.5 M", "0.02 M", "90.0 %", "24.80", "23.50", "28.25"])

    def test_growth_is_fitted_and_its_turning_points_found(self):
        text = self.table("exponents gpu gaussians pixels occupancy")
        best = f"`{'/'.join(synthetic_folder.BEST)}`"

        def exponents(axis):
            line = next(line for line in text.splitlines() if axis in line and best in line)
            return [cell.strip() for cell in line.strip("| ").split(" | ")][3:6]

        self.assertEqual(exponents("million Gaussians"), ["1.00 (1.00)", "0.00 (0.00)", "0.00 (0.00)"])
        self.assertEqual(exponents("million pixels"), ["0.00 (0.00)", "0.00 (0.00)", "1.00 (1.00)"])
        self.assertEqual(exponents("intersections a tile"), ["0.00 (0.00)", "1.00 (1.00)", "0.00 (0.00)"])
        alone = self.table("best-exponents gpu gaussians pixels occupancy")
        self.assertEqual([line for line in alone.splitlines() if "0.00 (0.00)" in line],
                         [line for line in text.splitlines() if best in line])
        # Projection takes 0.5 ms a million, rasterization 1 ms.
        self.assertIn(f"{best} | raster; from 2 project |", self.table("dominates gpu gaussians"))

    def test_memory_is_of_each_stage_where_a_file_tells_it(self):
        best = "early/axis-shared-threshold-float-cholesky/ellipse"
        self.assertEqual(cells(self.table("growth gpu gaussians"), "garden")[-3:], ["0", "1", "1"])
        self.assertEqual(cells(self.table("growth cpu gaussians"), "garden")[-1], "1")
        text = self.table("memory-exponents gpu gaussians")
        line = next(line for line in text.splitlines() if f"`{best}`" in line)
        self.assertEqual(line.strip("| ").split(" | ")[3:], ["1.00 (1.00)", "0.00 (0.00)", "0.00 (0.00)"])
        _, _, _, error = self.update("<!-- table: memory-exponents cpu gaussians -->\n<!-- end -->\n")
        self.assertIn("rows without bytes of each stage; expected them in every row", error)

    def test_launches_of_a_kernel_are_averaged(self):
        kernel = ("void swiftgs::kernels::raster_warps<swiftgs::kernels::CholeskyExponent, (bool)1, (bool)0>"
                  "(swiftgs::RasterJob)")
        launches = ({"gpu__time_duration.sum": "153,000", "smsp__inst_executed.sum": "118,561,421",
                     "dram__bytes.sum": "43,812,864", "launch__registers_per_thread": "56",
                     "sm__warps_active.avg.pct_of_peak_sustained_active": "47.31",
                     "smsp__issue_active.avg.pct_of_peak_sustained_active": "85.69"},
                    {"gpu__time_duration.sum": "154,000", "smsp__inst_executed.sum": "118,561,421",
                     "dram__bytes.sum": "43,800,000", "launch__registers_per_thread": "56",
                     "sm__warps_active.avg.pct_of_peak_sustained_active": "47.41",
                     "smsp__issue_active.avg.pct_of_peak_sustained_active": "86.01"})
        with open(self.results / FOLDERS["gpu"] / "kernels-made.csv", "w", encoding="utf-8", newline="") as file:
            write = csv.writer(file).writerow
            write(["ID", "Kernel Name", "Metric Name", "Metric Value"])
            for number, metrics in enumerate(launches):
                for name, value in metrics.items():
                    write([number, kernel, name, value])
        row = cells(self.table("kernels gpu made"), "`raster_warps<CholeskyExponent, 1, 0>`")
        self.assertEqual(row[1:], ["2", "153.5", "118.56", "43.8", "56", "47", "86"])

    def test_memory_of_an_older_file_is_what_the_device_has_less(self):
        results = self.place / "older"
        synthetic_folder.write(results / FOLDERS["gpu"], "cuda", older=True)
        _, text, _, _ = self.update("<!-- table: growth gpu gaussians -->\n<!-- end -->\n", results=results)
        self.assertEqual(cells(text, "garden")[-1], "512")

    def test_hard_frames_show_the_worse_of_both_rasterizers_of_a_form(self):
        for machine, device in (("gpu", "a GPU, `cuda`"), ("cpu", "a processor, 16 cores, `cpu`")):
            text = self.table(f"stability {machine}")
            self.assertIn(f"\n{device}, images of 64x48, 16 seeds at each severity: ", text)
            self.assertIn("| family | per-pixel | float-split | float-cholesky | half-split |", text)
            self.assertEqual(cells(text, "`needles`")[1:], ["2.00 (2.0e-06)"] + 3 * ["4.00 (4.0e-06)"])
        text = self.table("stability gpu large")
        self.assertEqual(cells(text, "`ridges`, 1920x1080")[1], "2.00 (2.0e-06)")
        self.assertEqual(len([line for line in text.splitlines() if line.startswith("| `")]),
                         2 * len(synthetic_folder.FAMILIES))

    def test_hard_frames_of_some_families_alone(self):
        every = self.table("stability gpu")
        some = self.table("stability gpu mixtures needles")
        self.assertEqual([line for line in some.splitlines() if line.startswith("| `")],
                         [line for line in every.splitlines() if line.startswith(("| `needles`", "| `mixtures`"))])
        self.assertIn("`ridges`, 960x540", self.table("stability gpu large ridges"))
        error = self.update("<!-- table: stability gpu needle -->\n<!-- end -->\n")[3]
        self.assertIn("/stress.json: no family 'needle'; expected 'large' or one of needles, ", error)

    def test_hard_frames_above_the_gate_or_without_a_number_stand_out(self):
        folder = self.place / "hard" / FOLDERS["gpu"]
        folder.mkdir(parents=True)
        found = synthetic_folder.stress("cuda", ((64, 48),))
        for row in found["rows"]:
            if row["family"] == "needles":
                row.update({"per-pixel": {"strict_normalised_error": 12345.0}, "axis-shared-half-split": {"strict_normalised_error": None},
                            "axis-shared-float-split": {"failed": 1},
                            "axis-shared-float-cholesky": {"ambiguity": 1.0}}.get(row["raster"], {}))
        synthetic_folder.synthetic.write(folder / "stress.json", found)
        text = self.update("<!-- table: stability gpu -->\n<!-- end -->\n", results=folder.parent)[1]
        self.assertEqual(cells(text, "`needles`")[1:], ["**1.2e+04** (2.0e-06)", "**failed**", "4.00† (4.0e-06)",
                                                        "**inf** (4.0e-06)"])

    def test_a_broken_file_of_hard_frames_is_one_line(self):
        folder = self.place / "soft" / FOLDERS["gpu"]
        folder.mkdir(parents=True)
        page = "<!-- table: stability gpu -->\n<!-- end -->\n"
        good = synthetic_folder.stress("cuda", ((64, 48),))
        for change, message in (({"format": "swiftgs-bench"}, "expected 'swiftgs-stress', 1"),
                                ({"rows": []}, "rows: expected an array that is not empty"),
                                ({"rows": [{}]}, "rows[0].family: expected a string"),
                                ({"rows": [{**good["rows"][0], "strict_normalised_error": "x"}]}, "rows[0].strict_normalised_error: expected a number"),
                                ({"rows": [{**good["rows"][0], "backend": "cpu"}]}, "no rows of the backend 'cuda'")):
            synthetic_folder.synthetic.write(folder / "stress.json", {**good, **change})
            code, text, _, error = self.update(page, results=folder.parent)
            self.assertEqual((code, text), (2, page))
            self.assertRegex(error, r"\A[^\n]+/stress.json: [^\n]+\n\Z")
            self.assertIn(message, error)

    def test_a_broken_file_of_other_commands_is_one_line(self):
        folder = self.place / "broken" / FOLDERS["cpu"]
        folder.mkdir(parents=True)
        for name, table, form in (("prune-fox-contribution.json", "prune-quality", "swiftgs-prune"),
                                  ("ulps.json", "ulps", "swiftgs-ulps")):
            page = f"<!-- table: {table} cpu -->\n<!-- end -->\n"
            missing = "before" if table == "prune-quality" else "rows"
            for found, message in (({"format": form, "version": 2}, f"version 2; expected '{form}', 1"),
                                   ({"format": form, "version": 1, "machine": {}}, f"{missing}: expected an ")):
                synthetic_folder.synthetic.write(folder / name, found)
                code, text, _, error = self.update(page, results=folder.parent)
                self.assertEqual((code, text), (2, page))
                self.assertRegex(error, rf"\A[^\n]+/{name}: [^\n]+\n\Z")
                self.assertIn(message, error)

    def test_formats_show_what_each_costs_and_every_pair(self):
        single = self.table("formats amd")
        self.assertEqual(len(cells(single, "SPZ version 4")), 12)
        self.assertIn("fox, 175,799 Gaussians", single)
        self.assertEqual(len(cells(single, "SPZ version 3")), 12)
        pairs = [line for line in self.table("format-pairs amd").splitlines() if line.startswith("| ")]
        self.assertEqual(len(pairs), 2 + 5 * 5)
        self.assertTrue(all(line.count("|") == 10 for line in pairs))
        reads = self.table("format-reads amd")
        self.assertEqual(len(cells(reads, "glTF (binary)")), 7)
        self.assertEqual(cells(reads, "streamed SOG, level 0 of 3")[1], "0")

    def test_a_broken_file_of_formats_is_one_line(self):
        folder = self.place / "broken" / FOLDERS["amd"]
        folder.mkdir(parents=True, exist_ok=True)
        whole = json.loads((self.results / FOLDERS["amd"] / "formats.json").read_text(encoding="utf-8"))
        for member, broken, message in (("single", {}, "single: expected an array"),
                                        ("single", [{}], "file_format: expected a string"),
                                        ("pairs", [{"first": "a"}], "second: expected a string"),
                                        ("pairs", [{"first": "a", "second": "b"}], "expected an object"),
                                        ("read", [{"file_format": "a"}], "gaussians: expected a number"),
                                        ("scene", 1, "scene: expected a string")):
            (folder / "formats.json").write_text(json.dumps({**whole, member: broken}), encoding="utf-8")
            code, _, _, error = self.update("<!-- table: formats amd -->\n<!-- end -->\n", results=folder.parent)
            self.assertEqual(code, 2)
            self.assertRegex(error, r"\A[^\n]+/formats.json: [^\n]+\n\Z")
            self.assertIn(message, error)

    def test_what_python_adds_is_the_difference_outside_of_the_stages(self):
        folder, one = self.place / "python" / FOLDERS["xeon"], {"p10": 1, "median": 2}
        folder.mkdir(parents=True)
        row = {"scene": "fox", "gaussians": 5000, "renderer": "cpu/a/b/c", "cpp_ms": {"p10": 4, "median": 5},
               "python_ms": {"out": {"p10": 5, "median": 8}, "new": one, "nothing": {"p10": 0.01, "median": 0.02}},
               "cpp_nothing_ms": {"p10": 0.008, "median": 0.01}, "cpp_outside_us": one,
               "python_outside_us": {"p10": 21, "median": 32}}
        page, good = "<!-- table: python xeon -->\n<!-- end -->\n", {"format": "swiftgs-python", "version": 1}
        synthetic_folder.synthetic.write(folder / "python.json", {**good, "rows": [row]})
        code, text, _, error = self.update(page, results=folder.parent)
        self.assertEqual((code, error), (0, ""))
        self.assertIn("| fox, 5,000 | `cpu` | median | 200 | 125 | 500 | - | 30 | 10.0 |", text)
        self.assertIn("| fox, 5,000 | `cpu` | p10 | 250 | 200 | 1,000 | - | 20 | 2.0 |", text)
        for broken, message in (({"python_ms": {}}, "python_ms: expected an object with out, new and nothing"),
                                ({"cpp_ms": {"p10": 1}}, "median: expected a number"),
                                ({"cpp_outside_us": None}, "expected an object"),
                                ({"scene": 1}, "scene: expected a string")):
            synthetic_folder.synthetic.write(folder / "python.json", {**good, "rows": [{**row, **broken}]})
            code, text, _, error = self.update(page, results=folder.parent)
            self.assertEqual((code, text), (2, page))
            self.assertRegex(error, r"\A[^\n]+/python.json: [^\n]+\n\Z")
            self.assertIn(message, error)

    def test_gsplat_is_shown_by_its_times_and_by_decisions_apart_from_rounding(self):
        folder = self.place / "gsplat" / FOLDERS["hopper"]
        folder.mkdir(parents=True)
        ms = {"swiftgs": 1, "swiftgs, matrices on the host": 0.9, "swiftgs, scene kept": 0.5, "gsplat": 2,
              "gsplat, not packed": 1.5}
        row = {"scene": "fox", "gaussians": 5000, "views": 2, "ms": ms, "between_db": [106.0, 99.5]}
        ours, theirs = {"db": 110.0, "otherwise": 2, "db_of_others": 134.5}, {"db": 102.0, "otherwise": 12,
                                                                             "db_of_others": 131.0}
        good = {"format": "swiftgs-beside-gsplat", "version": 1, "rows": [row],
                "from_float64": {"fox": [{"swiftgs": ours, "gsplat": theirs}] * 2}}
        page = "".join(f"<!-- table: {name} hopper -->\n<!-- end -->\n" for name in ("beside-gsplat", "gsplat-exactness"))
        synthetic_folder.synthetic.write(folder / "beside-gsplat.json", good)
        code, text, _, error = self.update(page, results=folder.parent)
        self.assertEqual((code, error), (0, ""))
        self.assertIn("| fox, 5,000 | 2 | 1.00 | 0.900 | 0.500 | 2.00 | 1.50 | 99.5 |", text)
        self.assertIn("| fox | swiftgs | 110.0, 110.0 | 2, 2 | 134.5, 134.5 |", text)
        self.assertIn("| fox | gsplat | 102.0, 102.0 | 12, 12 | 131.0, 131.0 |", text)
        for broken, message in (({"rows": [{**row, "ms": {}}]}, "swiftgs: expected a number"),
                                ({"rows": [{**row, "between_db": []}]}, "a list between_db that is not empty"),
                                ({"from_float64": {"fox": [{}]}}, "expected an object"),
                                ({"from_float64": {"fox": 1}}, "from_float64.fox: expected a list of objects")):
            synthetic_folder.synthetic.write(folder / "beside-gsplat.json", {**good, **broken})
            code, text, _, error = self.update(page, results=folder.parent)
            self.assertEqual((code, text), (2, page))
            self.assertIn(message, error)

    def test_a_cost_says_whether_its_frames_were_compared_with_float64(self):
        text = self.table("stability-cost gpu").replace("\n", " ")
        self.assertIn("and the worst PSNR of the frames that were compared with float64.", text)
        self.assertEqual(cells(self.table("stability-cost gpu"), "`per-pixel`")[1],
                         "2.00 → 2.00 (1.00x), 102.0 → 102.0 dB")
        folder = self.place / "cost" / FOLDERS["gpu"]
        folder.mkdir(parents=True)
        for when in ("before", "after"):
            found = json.loads((self.results / FOLDERS["gpu"] / f"cost-{when}-cuda.json").read_text(encoding="utf-8"))
            for row in found["rows"]:
                row["psnr_db"] = None
            synthetic_folder.synthetic.write(folder / f"cost-{when}-cuda.json", found)
        text = self.update("<!-- table: stability-cost gpu -->\n<!-- end -->\n", results=folder.parent)[1]
        self.assertIn("of frames that were not compared with float64.", text.replace("\n", " "))
        self.assertEqual(cells(text, "`per-pixel`")[1], "2.00 → 2.00 (1.00x)")

    def test_the_commands_of_a_folder_are_listed(self):
        text = self.table("files gpu")
        self.assertEqual(cells(text, "`matrix.json`")[1:], ["`000000000000`", "`swiftgs bench`"])

    def test_both_sorts_stand_side_by_side_along_an_axis(self):
        self.assertEqual(cells(self.table("sort-growth gpu gaussians"), "garden")[1:],
                         ["0.1", "2,000,000", "1.00", "0.800", "-20.0 %", "-9.8 %"])

    def test_a_host_is_not_called_by_its_gpu(self):
        self.assertIn("\na processor, 16 cores, ", self.table("growth gpu threads"))

    def test_the_largest_gap_is_named(self):
        text = self.table("largest-gap gpu").replace("\n", " ")
        # Eleven floats of 200,000 Gaussians and seven of 500,000 splats take 5.5 us of 4.14 TB/s, where 0.5 ms was
        # measured; 49 million pairs of eight instructions take 13.1 us of 30 T/s, where it was 1 ms.
        self.assertIn("The largest gap is that of `project` in fox, 0.2 M: 500 us are 91 times what its memory would "
                      "take. Most time is to be gained from `raster` in garden, 1.5 M: 987 of 1,000 us.", text)

    def test_balanced_times_are_of_the_first_views_that_have_them(self):
        text = self.table("balance gpu pieces-after-cuda")
        self.assertEqual(cells(text, "garden, 1.5 M")[1:], ["1,000", "2,000", "400", "5.00", "2,048", "1,500"])
        found = json.loads((self.results / FOLDERS["gpu"] / "matrix.json").read_text(encoding="utf-8"))
        for row in found["rows"]:
            if row["scene"] == "fox":
                row["counted_ms"]["balanced"] = 0
            if row["scene"] == "builtin" or row["view"] == "0":
                del row["counted_ms"]
            elif row["scene"] == "garden":
                row["counted_ms"] = {"raster": 3, "balanced": 2}
        folder = self.place / "balance" / FOLDERS["gpu"]
        folder.mkdir(parents=True)
        page = "<!-- table: balance gpu matrix -->\n<!-- end -->\n"
        synthetic_folder.synthetic.write(folder / "matrix.json", found)
        text = self.update(page, results=folder.parent)[1]
        self.assertEqual(cells(text, "garden, 1.5 M")[1:5], ["1,000", "3,000", "2,000", "1.50"])
        self.assertEqual(cells(text, "fox, 0.2 M")[1:5], ["1,000", "2,000", "0", "-"])
        self.assertNotIn("builtin", text)
        for row in found["rows"]:
            row.pop("counted_ms", None)
        synthetic_folder.synthetic.write(folder / "matrix.json", found)
        code, text, _, _ = self.update(page, results=folder.parent)
        self.assertEqual(code, 0)
        self.assertIn("No row of `matrix.json` has a balanced time", text)
        self.assertNotIn("|", text)
        found["rows"][-1]["counted_ms"] = {"raster": 3, "balanced": -1}
        synthetic_folder.synthetic.write(folder / "matrix.json", found)
        code, _, _, error = self.update(page, results=folder.parent)
        self.assertEqual(code, 2)
        self.assertIn(f"rows[{len(found['rows']) - 1}].counted_ms.balanced: expected a number that is not", error)

    def test_a_sort_stands_beside_its_memory_and_beside_cub(self):
        rows = [line for line in self.table("gaps gpu").splitlines() if line.startswith("| garden, 1.5 M | sort |")]
        self.assertEqual([row.strip("| ").split(" | ")[2] for row in rows], ["memory", "CUB's sorts"])
        # 0.5 million depths of 8 bytes in four passes, 2 million tiles of 6 bytes in two, 51 floats of colour a splat.
        self.assertEqual(rows[0].strip("| ").split(" | ")[3], "47.8")


class Arithmetic(unittest.TestCase):
    def test_a_power_law_is_found_exactly_and_noise_around_it_is_averaged(self):
        law = fits.fit([(x, 3 * x**0.7) for x in (1, 2, 5, 100)])
        self.assertAlmostEqual(law.exponent, 0.7)
        self.assertAlmostEqual(law(1000), 3 * 1000**0.7)
        noisy = fits.fit([(1, 2 * 1.1), (10, 200 / 1.1**2), (100, 20000 * 1.1)])
        self.assertAlmostEqual(noisy.exponent, 2)
        self.assertAlmostEqual(noisy(50), 5000)
        self.assertIsNone(fits.fit([(2, 1)]))
        self.assertIsNone(fits.fit([(2, 1), (2, 3)]))

    def test_curves_cross_where_their_power_laws_meet(self):
        xs = (1, 4, 16)
        curves = {"flat": [3, 3, 3], "grows": list(xs)}
        (first, start), (second, turn) = fits.dominance(xs, curves)
        self.assertEqual((first, start, second), ("flat", 1, "grows"))
        self.assertAlmostEqual(turn, 3)

    def test_the_time_of_a_sort_is_the_measured_one_and_grows_between(self):
        for kind, times in ceilings.SORT.items():
            for size, time in zip(ceilings.SORT_SIZES, times):
                self.assertAlmostEqual(1e6 * ceilings.sort_seconds(size, kind), time)
            sizes = [10**(4 + n / 10) for n in range(45)]
            found = [ceilings.sort_seconds(size, kind) for size in sizes]
            self.assertEqual(found, sorted(found))

    def test_the_papers_own_numbers_are_as_it_says_where_they_agree(self):
        self.assertAlmostEqual(paper.saved(paper.RATIO_MEAN), paper.SAVED_MEAN, places=4)
        for run in paper.RUNS:
            for values in (*paper.TIME[run], *paper.PSNR[run]):
                self.assertEqual(len(values), len(paper.SCENES))
        self.assertEqual([scene for scene, _ in paper.lost("RTX 3090, 30k")], ["bicycle", "room"])
        self.assertEqual([scene for scene, _ in paper.lost("L40S, 30k")], ["counter"])
        for column, printed in zip(paper.PRUNED[::2], paper.PRUNED_PRINTED[::2]):
            self.assertAlmostEqual(sum(column) / len(column), printed, places=2)


if __name__ == "__main__":
    unittest.main()
