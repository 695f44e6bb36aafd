# SPDX-License-Identifier: Apache-2.0
"""benchmarks/update_tables.py: the tables of Markdown files are what the results give."""
import collections
import contextlib
import copy
import csv
import dataclasses
import functools
import io
import json
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import rivals_figure  # noqa: E402
import synthetic  # noqa: E402
import synthetic_folder  # noqa: E402
import update_tables  # noqa: E402
from tables import blocks, ceilings, fits, paper  # noqa: E402
from tables.frames import OURS  # noqa: E402
from tables.results import OPTIONAL, STAGES, Duration, InputError, Results  # noqa: E402
from tables.source import MACHINES, RESULTS, Source, backend, family  # noqa: E402

COPIED = ("*.csv", "ulps.json", "formats.json", "python.json", "beside-gsplat*.json", "rivals.json",
          "planes*.json", "placed.json")
ROOT = HERE.parent.parent
ROWS = (  # (table, a line of it); synthetic_folder.py has the numbers behind them
    ("steps gpu", "| baseline | `standard/per-pixel/opacity-box` " + 3 * "| 3.50 (1.00x) " +
     "| 1.00x | 24.8 | 102.0 |"),
    ("steps gpu", "| AR | `standard/axis-shared-half-split/opacity-box` " + 3 * "| 3.10 (1.13x) " +
     "| 1.13x | 24.8 | 60.0 |"),
    ("steps gpu", "| ES | `early/per-pixel/opacity-box` " + 3 * "| 3.30 (1.06x) " + "| 1.06x | 24.8 | 102.0 |"),
    ("steps gpu", "| all, our terms | `adaptive/axis-shared-threshold-float-cholesky/opacity-box` " +
     3 * "| 2.30 (1.52x) " + "| 1.52x | 24.8 | 102.0 |"),
    ("accuracy many-cores", "| `axis-shared-half-split` " + 3 * "| 24.7500 (-0.0500) " + 3 * "| 60.0 " + "|"),
    ("accuracy many-cores", "| `axis-shared-float-cholesky` " + 3 * "| 24.8000 (+0.0000) " + 3 * "| 102.0 " + "|"),
    ("shares gpu", "| a GPU | garden, 1.5 M | 14.3 % | 28.6 % | 57.1 % | 21.7 % | 34.8 % | 43.5 % |"),
    ("raster-stage gpu", "| AR + AT | `axis-shared-threshold-half-split` " + 3 * "| 1.50 (1.33x) " + "| 1.33x |"),
    ("sort-stage gpu", "| garden, 1.5 M | three-sigma-square | 12.00 | 1.00 | 0.800 | 0.800 | -20.0 % "
                       "| -20.0 % to -20.0 % | 2 of 2 | +0.0 % |"),
    ("redundancy gpu", "| garden, 1.5 M, 2 views | three-sigma-square | 500,000 | 6,000,000 | 6,000,000 "
                       "| 12.00 | 12.00 | 45.8 % |"),
    ("bounds gpu", "| garden, 1.5 M | three-sigma-square | 6,000,000 | 0.500 | 0.800 | 1.00 | 2.30 | 102.0 |"),
    ("pruned gpu", f"| `{OURS}` " + 2 * "| 2.30 (1.52x) " + "| 1.52x |"),
    ("vanilla gpu", f"| `{OURS}` " + 3 * "| 2.30 (1.52x) " + "| 1.52x |"),
    ("prune-quality gpu", "| garden | contribution | 1.5 M | 0.02 M | 90.0 % | 24.80 | 23.50 | 28.25 |"),
    ("files gpu", "| `ceilings.json`, `harmonics-*.json`, `lenses.json`, `matrix.json`, `pruned.json`, "
                  "`scaling-*.json`, `vanilla.json` | a GPU | 2026-11-21 | `000000000000` |"),
    ("sort-growth gpu gaussians", "| garden | 0.1 | 2,000,000 | 1.00 | 0.800 | -20.0 % | -9.8 % |"),
    ("balance gpu", "| garden, 1.5 M | 1,000 | 2,000 | 400 | 5.00 | 2,048 | 1,500 |"),
    ("lenses gpu", "| pinhole | as stored | 500,000 | 0.500 | 0.800 | 1.00 | 2.30 | 1.00 |"),
    ("lenses gpu", "| panorama | as stored | 2,000,000 | 2.00 | 0.800 | 1.00 | 3.80 | 1.65 |"),
    ("lenses gpu", "| pinhole | in space | 500,000 | 0.250 | 0.800 | 1.00 | 2.05 | 1.00 |"),
    ("lenses gpu", "| fisheye | in space | 1,500,000 | 0.750 | 0.800 | 1.00 | 2.55 | 1.24 |"),
    ("harmonics gpu", "| fox, 0.2 M | bytes | 0.800 | 2.30 | 0.50 | 0.83 | 0.75 | 0.91 |"),
    ("ceilings gpu", "a GPU:"),
    ("ceilings gpu", "| copy in memory, read and written | 4.00 TB/s |"),
    ("ceilings gpu", "| sort by 13 of 16 bits of the keys, 32-bit values "
                     "| 0.1 M in 51 us; 1 M in 63 us; 10 M in 180 us |"),
    ("ceilings gpu", "| sort by 32 bits of the keys, 32-bit values | 0.1 M in 53 us; 1 M in 82 us; 10 M in 370 us |"))


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
                found.setdefault((begin[1], tuple(word for word in words if word not in MACHINES)), (begin[1], words))
    return list(found.values())


def without(row, member, value):
    """A row whose `member` is `value`, or a stage that took that long."""
    if member in STAGES:
        return dataclasses.replace(row, ms={**row.ms, member: Duration(value, value, value)})
    return dataclasses.replace(row, **{member: value})


def block(words):
    return f"<!-- table: {words} -->\n<!-- end -->\n"


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
        for machine in MACHINES:
            synthetic_folder.write(cls.results / machine, backend(machine))
        for path in (path for name in COPIED for path in pathlib.Path(RESULTS).glob(f"*/{name}")):
            shutil.copy(path, cls.results / path.parent.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def update(self, text, *options, results=None):
        """(exit code, text afterwards, standard output, standard error)"""
        page = self.place / "page.md"
        page.write_text(text, encoding="utf-8")
        out, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            code = update_tables.main(["--results", str(results or self.results), *options, str(page)])
        return code, page.read_text(encoding="utf-8"), out.getvalue(), errors.getvalue()

    def folder_with(self, files):
        """A folder of results with these files alone, {MACHINE/NAME: content}."""
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.place))
        for name, content in files.items():
            (folder / name).parent.mkdir(exist_ok=True)
            synthetic.write(folder / name, content)
        return folder

    def stored(self, name):
        return json.loads((self.results / name).read_text(encoding="utf-8"))

    def table(self, words, files=None):
        """The page of a table that is made without an error, of `files` alone if they are given."""
        code, text, _, error = self.update(block(words), results=files and self.folder_with(files))
        self.assertEqual((code, error), (0, ""))
        return text

    def refused(self, words, files, message):
        """The error that the table of `files` gives: one line, which names the last of them and holds `message`. The
        block stays."""
        code, text, _, error = self.update(block(words), results=self.folder_with(files))
        self.assertEqual((code, text), (2, block(words)))
        self.assertRegex(error, rf"\A[^\n]+/{pathlib.Path([*files][-1]).name}: [^\n]+\n\Z")
        self.assertIn(message, error)
        return error

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
        page = "<!-- table: steps gpu -->\nold\n<!-- end -->\n<!-- table: paper-steps -->\n<!-- end -->\n"
        code, text, _, error = self.update(page, results=self.place)
        self.assertEqual(code, 2)
        self.assertIn("<!-- table: steps gpu -->\nold\n<!-- end -->", text)
        self.assertIn("RTX 3090", text)
        self.assertRegex(error, r"\Aupdate_tables: \S+page.md:1: \S+/matrix.json: no such file; expected [^\n]+\n\Z")

    def test_blocks_that_make_no_sense_are_one_line(self):
        for page, message in (("<!-- table: stepps gpu -->\n<!-- end -->", "no table 'stepps'; expected one of "),
                              ("<!-- table: steps -->\n<!-- end -->", "table 'steps' : expected MACHINE"),
                              ("<!-- table: steps tpu -->\n<!-- end -->", "no machine 'tpu'; expected one of gpu, many-cores"),
                              ("<!-- table: exponents gpu size -->\n<!-- end -->", "no axis 'size'; expected one of"),
                              ("<!-- table: ceilings -->\n", "block 'ceilings' does not end; expected <!-- end -->"),
                              ("<!-- table: ceilings -->\n<!-- table: ceilings -->\n<!-- end -->", "does not end")):
            code, text, _, error = self.update(page)
            self.assertEqual((code, text), (2, page))
            self.assertRegex(error, r"\Aupdate_tables: \S+page.md:1: [^\n]+\n\Z")
            self.assertIn(message, error)

    def test_a_broken_result_file_is_one_line(self):
        self.refused("steps gpu", {"gpu/matrix.json": {}}, "format None, version None; expected 'swiftgs-bench', 1\n")

    def test_every_table_of_the_pages_can_be_made_of_what_the_script_measures(self):
        for page in pages():
            code, text, _, error = self.update(page.read_text(encoding="utf-8"))
            self.assertEqual((page.name, code, error), (page.name, 0, ""))
            self.assertNotRegex(text, r"<!-- table: [^\n]+ -->\n+<!-- end -->")

    def test_a_number_that_is_missing_or_0_is_a_dash_or_one_line_that_names_file_and_member(self):
        missing = [(member, None) for member in OPTIONAL]
        zeros = [(member, 0) for member in (*OPTIONAL, *STAGES, "gaussians", "width", "height", "threads", "enlarge")]
        refused, loaded = collections.Counter(), {}

        @functools.cache
        def lacking(key, member, value):
            return [without(row, member, value) for row in loaded[key].rows]

        for name, words in blocks_of_pages():
            source = Source(str(self.results))
            blocks.render(name, words, update_tables.TABLES, source)
            whole = {key: results for key, results in source.found.items() if isinstance(results, Results)}
            loaded.update(whole)
            for key, results in whole.items():
                for member, value in missing + zeros:
                    every = lacking(key, member, value)
                    for rows in (every, [*results.rows[:-1], *every[-1:]]):
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
        error = self.refused("exponents gpu occupancy", {"gpu/scaling-occupancy.json": synthetic.file_of(rows)},
                             "intersections of cuda/")
        self.assertRegex(error, r" on view '0' of garden: expected a number above 0\n\Z")

    def test_sorts_that_were_not_measured_at_the_same_places_are_not_set_side_by_side(self):
        rows = [row for row in synthetic_folder.growing("cuda", [({"gaussians": n}, {}) for n in (1, 2)])
                if row["gaussians"] == 1 or row["sort"] == "early"]
        folder = self.folder_with({"gpu/scaling-gaussians.json": synthetic.file_of(rows)})
        error = self.update(block("sort-growth gpu gaussians"), results=folder)[3]
        self.assertRegex(error, r"\A[^\n]+scaling-gaussians.json[^\n]*: garden: expected rows of [^\n]+\n\Z")

    def test_a_stage_is_shown_with_the_target_that_errs_most(self):
        found = self.stored("two-cores/ulps.json")
        for row in found["rows"]:
            if row["stage"] == "`Exp2`":
                row["ulps"] = 9.875 if row["target"] == "cpu AVX2" else 1
        text = self.table("ulps two-cores", {"two-cores/ulps.json": found})
        self.assertEqual(cells(text, "`Exp2`")[2:], ["cpu AVX2", "9.88"])
        found["rows"] = [row for row in found["rows"] if row["stage"] != "`l1`"]
        self.refused("ulps two-cores", {"two-cores/ulps.json": found}, "no row of `l1`; expected one of each stage\n")

    def test_steps_have_photographs_where_any_is_known(self):
        changed = self.stored("gpu/matrix.json")
        for last, cell in ((OURS, ["-"]), ("", [])):
            for row in changed["rows"]:
                if row["renderer"].endswith(last):
                    row["photo_psnr_db"] = None
            text = self.table("steps gpu", {"gpu/matrix.json": changed})
            self.assertEqual("photographs, mean, dB" in text, bool(cell))
            self.assertEqual(cells(text, "and our bounds")[-1 - len(cell):-1], cell)
            self.assertEqual(len({line.count("|") for line in text.splitlines() if line.startswith("|")}), 1)

    def test_the_headline_has_ten_renderers_on_every_machine_and_the_least_psnr(self):
        words = "headline gpu many-cores"
        text = self.table(words)
        self.assertEqual(len([line for line in text.splitlines() if line.startswith("| `")]), 10)
        best = "`early/axis-shared-threshold-float-cholesky/ellipse`"
        self.assertEqual(cells(text, best)[1:], ["**ours**"] + 2 * ["2.30", "2.30", "102.0"])
        half = "`early/axis-shared-threshold-half-split/opacity-box`"
        self.assertEqual(cells(text, half)[1:], ["the paper's"] + 2 * ["2.80", "2.80", "60.0"])
        self.assertIn("`cpu` is a processor, 16 cores, 2 views a capture, the same work measured again within 0.0 %.", text.replace("\n", " "))
        files = {name: self.stored(name) for name in ("gpu/matrix.json", "many-cores/matrix.json")}
        changed = files["many-cores/matrix.json"]
        for row in changed["rows"]:
            if row["scene"] == "fox" and row["view"] == "1":
                row["psnr_db"] = 77.0
        self.assertEqual(cells(self.table(words, files), best)[4::3], ["102.0", "77.0"])
        changed["rows"] = [row for row in changed["rows"] if row["scene"] != "fox"]
        self.refused(words, files, "matrix.json: expected the captures of ")

    def test_the_square_of_a_preset_is_judged_with_and_without_its_cut(self):
        lines = [line for line in self.table("presets gpu").splitlines() if "three-sigma-square" in line]
        self.assertEqual([line.strip("| ").split(" | ")[1:] for line in lines],
                         [["the square's part of it"] + ["101.5"] * 3, ["all that alpha keeps"] + ["102.0"] * 3])

    def test_errors_that_depend_on_the_sort_are_told(self):
        self.assertNotIn("except", self.table("sorts-change-nothing gpu"))
        rows = synthetic_folder.matrix("cuda")
        next(row for row in rows if row["renderer"] == "cuda/early/per-pixel/ellipse")["max_abs"] = 0.004
        text = self.table("sorts-change-nothing gpu", {"gpu/matrix.json": synthetic.file_of(rows)})
        self.assertIn("except `per-pixel` on garden, 1.5 M.", text.replace("\n", " "))

    def test_rows_are_what_the_invented_numbers_give(self):
        for words, line in ROWS:
            with self.subTest(words=words):
                self.assertIn(f"\n{line}\n", self.table(words))

    def test_bounds_stand_from_the_widest_to_the_tightest(self):
        text = self.table("bounds gpu")
        kinds = [line.split("|")[2].strip() for line in text.splitlines() if line.startswith("| garden, 1.5 M")]
        self.assertEqual(kinds, ["three-sigma-square", "opacity-box", "ellipse"])

    def test_growth_is_fitted_and_its_turning_points_found(self):
        text = self.table("exponents gpu gaussians pixels occupancy")
        for axis, expected in (("million Gaussians", ["1.00 (1.00)", "0.00 (0.00)", "0.00 (0.00)"]),
                               ("million pixels", ["0.00 (0.00)", "0.00 (0.00)", "1.00 (1.00)"]),
                               ("intersections a tile", ["0.00 (0.00)", "1.00 (1.00)", "0.00 (0.00)"])):
            line = next(line for line in text.splitlines() if axis in line)
            self.assertEqual(line.strip("| ").split(" | ")[2:5], expected)
        # Projection takes 0.5 ms a million, rasterization 1 ms.
        self.assertIn("| raster; from 2 project |", text)

    def test_launches_of_a_kernel_are_averaged(self):
        kernel = ("void swiftgs::kernels::raster_warps<swiftgs::kernels::CholeskyExponent, (bool)1, (bool)0>"
                  "(swiftgs::RasterJob)")
        metrics = {"gpu__time_duration.sum": ("153,000", "154,000"),
                   "smsp__inst_executed.sum": ("118,561,421", "118,561,421"),
                   "dram__bytes.sum": ("43,812,864", "43,800,000"), "launch__registers_per_thread": ("56", "56"),
                   "sm__warps_active.avg.pct_of_peak_sustained_active": ("47.31", "47.41"),
                   "smsp__issue_active.avg.pct_of_peak_sustained_active": ("85.69", "86.01")}
        with open(self.results / "gpu" / "kernels-made.csv", "w", encoding="utf-8", newline="") as file:
            write = csv.writer(file).writerow
            write(["ID", "Kernel Name", "Metric Name", "Metric Value"])
            for launch in range(2):
                for name, values in metrics.items():
                    write([launch, kernel, name, values[launch]])
        row = cells(self.table("kernels gpu made"), "`raster_warps<CholeskyExponent, 1, 0>`")
        self.assertEqual(row[1:], ["2", "153.5", "118.56", "43.8", "56", "47", "86"])

    def test_hard_frames_show_the_worse_of_both_rasterizers_of_a_form(self):
        for machine, device in (("gpu", "a GPU, `cuda`"), ("many-cores", "a processor, 16 cores, `cpu`")):
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
        error = self.update(block("stability gpu needle"))[3]
        self.assertIn("/stress.json: no family 'needle'; expected 'large' or one of needles, ", error)

    def test_hard_frames_above_the_gate_or_without_a_number_stand_out(self):
        found = synthetic_folder.stress("cuda", ((64, 48),))
        changes = {"per-pixel": {"strict_normalised_error": 12345.0},
                   "axis-shared-half-split": {"strict_normalised_error": None},
                   "axis-shared-float-split": {"failed": 1}, "axis-shared-float-cholesky": {"ambiguity": 1.0}}
        for row in found["rows"]:
            if row["family"] == "needles":
                row.update(changes.get(row["raster"], {}))
        self.assertEqual(cells(self.table("stability gpu", {"gpu/stress.json": found}), "`needles`")[1:],
                         ["**1.2e+04** (2.0e-06)", "**failed**", "4.00† (4.0e-06)", "**inf** (4.0e-06)"])

    def test_a_broken_file_of_hard_frames_is_one_line(self):
        good = synthetic_folder.stress("cuda", ((64, 48),))
        row = good["rows"][0]
        for change, message in (({"format": "swiftgs-bench"}, "expected 'swiftgs-stress', 1"),
                                ({"rows": []}, "rows: expected an array that is not empty"),
                                ({"rows": [{}]}, "rows[0].family: expected a string"),
                                ({"rows": [{**row, "strict_normalised_error": "x"}]},
                                 "rows[0].strict_normalised_error: expected a number"),
                                ({"rows": [{**row, "backend": "cpu"}]}, "no rows of the backend 'cuda'")):
            self.refused("stability gpu", {"gpu/stress.json": {**good, **change}}, message)

    def test_a_broken_file_of_other_commands_is_one_line(self):
        for name, table, form, missing in (
                ("prune-fox-contribution.json", "prune-quality", "swiftgs-prune", "before"),
                ("ulps.json", "ulps", "swiftgs-ulps", "rows")):
            for found, message in (({"format": form, "version": 2}, f"version 2; expected '{form}', 1"),
                                   ({"format": form, "version": 1, "machine": {}}, f"{missing}: expected an ")):
                self.refused(f"{table} many-cores", {f"many-cores/{name}": found}, message)

    def test_formats_show_what_each_costs(self):
        single = self.table("formats two-cores")
        self.assertEqual(len(cells(single, "SPZ version 4")), 12)
        self.assertIn("fox, 175,799 Gaussians", single)
        self.assertEqual(len(cells(single, "SPZ version 3")), 12)
        reads = self.table("format-reads two-cores")
        self.assertEqual(len(cells(reads, "glTF (binary)")), 7)
        self.assertEqual(cells(reads, "streamed SOG, level 0 of 3")[1], "0")

    def test_a_broken_file_of_formats_is_one_line(self):
        whole = self.stored("two-cores/formats.json")
        for member, broken, message in (("single", {}, "single: expected an array"),
                                        ("single", [{}], "file_format: expected a string"),
                                        ("read", [{"file_format": "a"}], "gaussians: expected a number"),
                                        ("scene", 1, "scene: expected a string")):
            self.refused("formats two-cores", {"two-cores/formats.json": {**whole, member: broken}}, message)

    def test_what_python_adds_is_the_difference_outside_of_the_stages(self):
        words, file, one = "python two-cores", "two-cores/python.json", {"p10": 1, "median": 2}
        row = {"scene": "fox", "gaussians": 5000, "renderer": "cpu/a/b/c", "cpp_ms": {"p10": 4, "median": 5},
               "python_ms": {"out": {"p10": 5, "median": 8}, "new": one}, "cpp_outside_us": one,
               "python_outside_us": {"p10": 21, "median": 32}}
        good = {"format": "swiftgs-python", "version": 1, "machine": {"cpu": "a processor", "cores": 2}, "rows": [row]}
        text = self.table(words, {file: good})
        self.assertIn("| a processor, 2 cores | fox, 5,000 | median | 200 | 125 | 500 | - | 30 |", text)
        self.assertIn("| a processor, 2 cores | fox, 5,000 | p10 | 250 | 200 | 1,000 | - | 20 |", text)
        for broken, message in (({"python_ms": {}}, "python_ms: expected an object with out and new"),
                                ({"cpp_ms": {"p10": 1}}, "median: expected a number"),
                                ({"cpp_outside_us": None}, "expected an object"),
                                ({"scene": 1}, "scene: expected a string")):
            self.refused(words, {file: {**good, "rows": [{**row, **broken}]}}, message)

    def test_gsplat_is_shown_by_its_times(self):
        words, file = "beside-gsplat gpu", "gpu/beside-gsplat.json"
        ms = {"swiftgs": 1, "swiftgs, matrices on the host": 0.9, "swiftgs, scene kept": 0.5, "gsplat": 2,
              "gsplat, not packed": 1.5}
        row = {"scene": "fox", "gaussians": 5000, "camera_model": "pinhole", "views": 2, "ms": ms,
               "between_db": [106.0, 99.5]}
        good = {"format": "swiftgs-beside-gsplat", "version": 1, "rows": [row]}
        self.assertIn("| fox, 5,000 | pinhole | 2 | 1.00 | 0.900 | 2.00 | 1.50 | 0.500 | 99.5 |",
                      self.table(words, {file: good}))
        for broken, message in (({"ms": {}}, "swiftgs: expected a number"),
                                ({"between_db": []}, "a list between_db that is not empty")):
            self.refused(words, {file: {**good, "rows": [{**row, **broken}]}}, message)

    def test_worlds_beside_gsplat_are_shown_by_times_and_images_of_the_fastest_call(self):
        words, file = "beside-gsplat-worlds gpu", "gpu/beside-gsplat-worlds.json"
        ms = {"swiftgs": 4, "swiftgs, matrices on the host": 3.2, "gsplat, not packed": 16}
        row = {"worlds": 64, "gaussians": 20_000, "views": 16, "size": [128, 96], "ms": ms, "between_db": [90.2, 88.1]}
        good = {"format": "swiftgs-beside-gsplat", "version": 1, "rows": [], "worlds": [row]}
        self.assertIn("| 64 of 20,000 | 16 of 128x96 | 4.00 | 3.20 | 16.0 | 320,000 | 64,000 | 88.1 |",
                      self.table(words, {file: good}))
        self.refused(words, {file: {**good, "worlds": None}}, "worlds: expected an array")
        for broken, message in (({"ms": {**ms, "gsplat, not packed": None}}, "gsplat, not packed: expected a number"),
                                ({"ms": {**ms, "gsplat, not packed": 0}}, "expected times above 0"),
                                ({"size": 128}, "expected times above 0 and a list size"),
                                ({"between_db": None}, "worlds[0]: expected an object ms and a list")):
            self.refused(words, {file: {**good, "worlds": [{**row, **broken}]}}, message)

    def test_rivals_count_by_their_fastest_call_and_worst_view(self):
        words, file = "rivals gpu", "gpu/rivals.json"
        ms = {"gsplat": 3, "gsplat, not packed": 2, "HiGS, tiles of 8": 0.5, "HiGS, tiles of 16": 0.6, "SwiftGS": 0.4}
        errors = {call: {"psnr_db": 90 - 10 * ms[call]} for call in ms}
        worse = {call: {"psnr_db": errors[call]["psnr_db"] - 20} for call in ms}
        row = {"scene": "fox", "gaussians": 200_000, "size": [640, 480], "ms": ms}
        good = {"format": "swiftgs-rivals", "version": 1,
                "machine": {"gpu": "a GPU", "date": "2026-11-21", "commit": 40 * "0"},
                "rows": [row, {**row, "errors": errors}, {**row, "errors": worse}]}
        text = self.table(words, {file: good})
        for line in ("| gsplat | 2.00 | 50.0 |", "| HiGS | 0.500 | 65.0 |", "| **SwiftGS** | 0.400 | 66.0 |"):
            self.assertIn(line, text)
        self.assertIn("3 views of fox (0.2 M Gaussians, 640x480)", text)
        self.assertIn("the worst of 2 views", text.replace("\n", " "))
        self.assertNotIn("Faster-GS", text)
        faster = copy.deepcopy(good)
        for each in faster["rows"]:
            each["ms"]["Faster-GS"] = 1
            each.get("errors", {})["Faster-GS"] = {"psnr_db": 80}
        place = self.folder_with({file: faster})
        self.assertIn("| Faster-GS | 1.00 | 80.0 |", self.update(block(words), results=place)[1])
        figure = rivals_figure.draw(rivals_figure.found_in(Source(place)))
        self.assertEqual(figure.count(f'fill="{rivals_figure.COLOURS["Faster-GS"]}"'), 2)  # its name and its point
        for broken, message in (({"ms": {}}, "gsplat: expected a number"), ({"errors": {}}, "expected an object"),
                                ({"errors": []}, "expected objects ms and errors")):
            self.refused(words, {file: {**good, "rows": [{**row, **broken}]}}, message)

    def test_frames_with_planes_are_compared_with_the_fastest_frame_of_colour(self):
        words, file = "planes-rivals gpu", "gpu/planes-rivals.json"
        ms = {"SwiftGS": 0.42, "SwiftGS, colour alone": 0.4, "SwiftGS, depth": 0.5, "SwiftGS, id": 0.6, "gsplat": 3,
              "gsplat, not packed": 2, "gsplat, depth": 2.5, "gsplat, not packed, depth": 2.6,
              "gsplat, not packed, id": 5}
        row = {"scene": "fox", "gaussians": 200_000, "size": [640, 480], "ms": ms}
        good = {"format": "swiftgs-rivals", "version": 1,
                "machine": {"gpu": "a GPU", "date": "2026-11-21", "commit": 40 * "0"},
                "rows": [{**row, "ms": {call: time * factor for call, time in ms.items()}} for factor in (9, 1, 0.5)]}
        text = self.table(words, {file: good})
        for line in ("| SwiftGS | colour | 0.400 | - |", "| SwiftGS | alpha, expected depth | 0.500 | 1.25 |",
                     "| SwiftGS | id of the largest weight | 0.600 | 1.50 |", "| gsplat | colour | 2.00 | - |",
                     "| gsplat | alpha, expected depth | 2.50 | 1.25 |",
                     "| gsplat | id of the largest weight | 5.00 | 2.50 |"):
            self.assertIn(line, text)
        del ms["gsplat, depth"]
        self.refused(words, {file: {**good, "rows": [row]}}, "gsplat, depth: expected a number")

    def test_the_figure_of_rivals_shows_the_results(self):
        figure = ROOT / "docs/images/rivals.svg"
        self.assertEqual(figure.read_text(encoding="utf-8"), rivals_figure.draw(rivals_figure.found_in(Source())))

    def test_a_host_is_not_called_by_its_gpu(self):
        self.assertIn("\na processor, 16 cores, ", self.table("exponents gpu threads"))

    def test_the_largest_gap_is_named(self):
        text = self.table("largest-gap gpu").replace("\n", " ")
        # Eleven floats of 200,000 Gaussians and seven of 500,000 splats take 5.7 us of 4 TB/s, where 0.5 ms was
        # measured; 49 million pairs of eight instructions take 13.1 us of 30 T/s, where it was 1 ms.
        self.assertIn("The largest gap is that of `project` in fox, 0.2 M: 500 us are 88 times what its memory would "
                      "take. Most time is to be gained from `raster` in garden, 1.5 M: 987 of 1,000 us.", text)

    def test_balanced_times_are_of_the_first_views_that_have_them(self):
        words, file = "balance gpu", "gpu/matrix.json"
        found = self.stored(file)
        for row in found["rows"]:
            if row["scene"] == "fox":
                row["counted_ms"]["balanced"] = 0
            if row["scene"] == "builtin" or row["view"] == "0":
                del row["counted_ms"]
            elif row["scene"] == "garden":
                row["counted_ms"] = {"raster": 3, "balanced": 2}
        text = self.table(words, {file: found})
        self.assertEqual(cells(text, "garden, 1.5 M")[1:5], ["1,000", "3,000", "2,000", "1.50"])
        self.assertEqual(cells(text, "fox, 0.2 M")[1:5], ["1,000", "2,000", "0", "-"])
        self.assertNotIn("builtin", text)
        for row in found["rows"]:
            row.pop("counted_ms", None)
        text = self.table(words, {file: found})
        self.assertIn("No row of `matrix.json` has a balanced time", text)
        self.assertNotIn("|", text)
        found["rows"][-1]["counted_ms"] = {"raster": 3, "balanced": -1}
        self.refused(words, {file: found}, f"rows[{len(found['rows']) - 1}].counted_ms.balanced: "
                                           "expected a number that is not")

    def test_a_sort_stands_beside_its_memory_and_beside_cub(self):
        rows = [line for line in self.table("gaps gpu").splitlines() if line.startswith("| garden, 1.5 M | sort |")]
        self.assertEqual([row.strip("| ").split(" | ")[2] for row in rows], ["memory", "CUB's sorts"])
        # 0.5 million depths of 8 bytes in four passes, 2 million tiles of 6 bytes in two, 51 floats of colour a splat.
        self.assertEqual(rows[0].strip("| ").split(" | ")[3], "49.5")

    def test_lenses_stand_beside_the_pinhole_in_the_same_order(self):
        text = self.table("lenses gpu")
        self.assertIn("garden, 1.5 M, milliseconds, means over 4 views:", text)
        self.assertEqual(sum(line.startswith("| ") for line in text.splitlines()), 10)

    def test_lenses_that_were_not_measured_are_dashes_and_a_sentence(self):
        rows = [synthetic_folder.row("cuda", synthetic_folder.BEST, f"garden-{lens}", view="0")
                for lens in ("pinhole", "opencv")]
        text = self.table("lenses gpu", {"gpu/lenses.json": synthetic.file_of(rows)})
        self.assertEqual(set(cells(text, "fisheye | as stored")[2:]), {"-"})
        self.assertIn("\nNot measured on every scene: `early/axis-shared-threshold-float-cholesky/ellipse`.\n", text)
        self.refused("lenses gpu", {"gpu/lenses.json": synthetic.file_of(rows[1:])},
                     "first scene 'garden-opencv'; expected one that ends in '-pinhole'")

    OF_MATRIX = ("steps", "accuracy", "shares", "raster-stage", "sort-stage", "redundancy", "bounds", "balance", "pareto",
                 "headline", "sorts-change-nothing")

    def test_own_files_at_another_scale_or_enlargement_have_every_table_and_say_so(self):
        for members, words in (({"scale": 0.25}, ", scale 0.25 "), ({"scale": 0.5, "enlarge": 2}, ", enlarged 2 ")):
            rows = synthetic_folder.matrix("cpu", ("builtin",), **members)
            files = {"mine/matrix.json": synthetic.file_of(rows),
                     "mine/vanilla.json": synthetic.file_of([{**row, "conventions": "inria"} for row in rows])}
            for name in (*self.OF_MATRIX, "vanilla", "presets"):
                with self.subTest(name=name, **members):
                    text = self.table(f"{name} mine", files)
                    if name in ("steps", "vanilla", "pareto"):
                        self.assertIn(words, text)

    def test_a_scene_is_shown_at_its_own_scale_where_there_are_several_and_else_at_the_largest(self):
        at = {scale: synthetic_folder.matrix("cuda", ("fox",), scale=scale, grow={"raster": scale}) for scale in (.5, 1, 2)}
        for scales, label in (((2, 1, .5), "fox, 0.2 M"), ((.5, 2), "fox, 0.2 M, scale 2")):
            text = self.table("raster-stage gpu",
                              {"gpu/matrix.json": synthetic.file_of(sum((at[scale] for scale in scales), []))})
            self.assertIn(f"| {label} |", text)

    def test_of_several_backends_and_numbers_of_threads_the_gpu_and_the_most_threads_are_shown(self):
        serial, cpu, cuda = (synthetic_folder.matrix(name, ("fox",), threads=threads)
                             for name, threads in (("serial", 1), ("cpu", 16), ("cuda", 16)))
        two = synthetic_folder.matrix("cpu", ("fox",), threads=2, grow={"raster": 8})
        for rows, backend_ in ((serial + cuda + cpu, "cuda"), (two + serial + cpu, "cpu"), (serial, "serial")):
            text = self.table("steps mine", {"mine/matrix.json": synthetic.file_of(rows)})
            self.assertIn(f"`{backend_}`, milliseconds", text)
            self.assertEqual(cells(text, "baseline")[2], "3.50 (1.00x)")

    def test_rows_that_were_not_measured_are_dashes_and_a_sentence(self):
        every = synthetic_folder.matrix("cpu", ("garden", "fox"))
        for kept in ("per-pixel/opacity-box", "early/", "standard/axis-shared-half-split", "adaptive/"):
            rows = [row for row in every if kept in row["renderer"] or row["scene"] == "garden"]
            for found in (rows, [row for row in rows if kept in row["renderer"]]):
                for name in self.OF_MATRIX:
                    with self.subTest(name=name, kept=kept, rows=len(found)):
                        text = self.table(f"{name} mine", {"mine/matrix.json": synthetic.file_of(found)})
                        self.assertNotIn("None", text)
        text = self.table("steps mine", {"mine/matrix.json": synthetic.file_of(found)})
        self.assertEqual(cells(text, "ES")[2:], 4 * ["-"] + ["-"])
        self.assertIn("\nNot measured on every scene: `", text)

    def test_scenes_without_photographs_have_their_errors(self):
        text = self.table("accuracy mine", {"mine/matrix.json": synthetic.file_of(
            synthetic_folder.matrix("cpu", ("builtin",), photo_psnr_db=None))})
        self.assertIn("No frame was compared with a photograph.", text)
        self.assertEqual(cells(text, "`axis-shared-half-split`")[1:], ["60.0"])

    def test_conventions_that_a_table_is_not_of_are_named(self):
        rows = synthetic_folder.matrix("cuda", ("fox",), conventions="inria")
        self.refused("steps gpu", {"gpu/matrix.json": synthetic.file_of(rows)},
                     "found inria; expected rows with gsplat conventions")

    def test_ratios_within_the_spread_of_the_same_work_are_marked(self):
        rows = synthetic_folder.matrix("cpu", ("fox",))
        self.assertNotIn("~0", self.table("steps mine", {"mine/matrix.json": synthetic.file_of(rows)}))
        for row in rows:  # the adaptive sort takes the early one, a tenth longer
            if row["renderer"] == "cpu/adaptive/per-pixel/three-sigma-square":
                for stage in row["ms"]:
                    row["ms"][stage] = synthetic_folder.exact(1.1 * row["ms"][stage]["median"])
        text = self.table("steps mine", {"mine/matrix.json": synthetic.file_of(rows)})
        self.assertIn("Where a factor has a ~, no difference was measured: the same work measured again differs by up to 10.0 %.",
                      text.replace("\n", " "))
        self.assertEqual(cells(text, "ES")[2:4], ["3.30 (~1.06x)", "~1.06x"])
        self.assertEqual(cells(text, "AR")[2:4], ["3.10 (1.13x)", "1.13x"])
        self.assertEqual(cells(text, "baseline")[2:4], ["3.50 (1.00x)", "1.00x"])

    def test_the_front_holds_what_no_other_beats_in_both(self):
        text = self.table("pareto gpu")
        lines = [line for line in text.splitlines() if line.startswith("| garden, 1.5 M | `")]
        self.assertEqual(len(lines), 1)  # the fastest of the synthetic ones is as exact as any
        self.assertIn("axis-shared-threshold-float-cholesky", lines[0])

    def test_a_broken_file_of_ceilings_and_one_of_another_device_are_one_line(self):
        good = synthetic_folder.ceilings()
        matrix = (self.results / "gpu" / "matrix.json").read_text(encoding="utf-8")
        row, of_row = good["sorts"][0], "sorts[0]: expected key_bits, sorted_bits, growing pairs, and as many us"
        for change, message in (({"version": 2}, "version 2; expected 'swiftgs-ceilings', 1"),
                                ({"copy_bytes_per_s": 0}, "copy_bytes_per_s: expected a number above 0"),
                                ({"ex2_per_s": None}, "ex2_per_s: expected a number above 0"),
                                ({"sorts": {}}, "sorts: expected an array"),
                                ({"sorts": [1]}, of_row),
                                ({"sorts": [{**row, "key_bits": []}]}, of_row),
                                ({"sorts": [{**row, "us": row["us"][:2]}]}, of_row),
                                ({"sorts": [{**row, "pairs": row["pairs"][::-1]}]}, of_row),
                                ({"sorts": [{**row, "pairs": [], "us": []}]}, of_row),
                                ({"sorts": good["sorts"][:2]}, "expected one with key_bits 64 and sorted_bits 45"),
                                ({"machine": {"gpu": "b"}}, "measured on b; expected a GPU, as matrix.json")):
            for name in ("gaps", "largest-gap"):
                self.refused(f"{name} gpu", {"gpu/matrix.json": matrix, "gpu/ceilings.json": {**good, **change}},
                             message)


class Kept(unittest.TestCase):
    """What is in benchmarks/results."""

    def setUp(self):
        self.runs = collections.defaultdict(set)  # (machine, family): {(file, commit)}
        for path in pathlib.Path(RESULTS).glob("*/*.json"):
            commit = json.loads(path.read_text(encoding="utf-8")).get("machine", {}).get("commit")
            if commit:
                self.runs[path.parent.name, family(path.name)].add((path.name, commit))

    def test_files_that_are_measured_together_are_of_one_commit(self):
        self.assertGreater(len(self.runs), 10)
        for run, found in self.runs.items():
            self.assertEqual(len({commit for _, commit in found}), 1, (run, found))

    def test_figures_are_of_the_same_files_as_tables(self):
        kept, drawn = set().union(*self.runs.values()), 0
        for path in (ROOT / "docs" / "images").glob("*.svg"):
            for found in re.findall(r"<metadata>(\S+) (\S+)</metadata>", path.read_text(encoding="utf-8")):
                self.assertIn(found, kept, path.name)
                drawn += 1
        self.assertGreater(drawn, 5)

    def test_all_files_take_at_most_5_megabytes(self):
        self.assertLess(sum(path.stat().st_size for path in pathlib.Path(RESULTS).rglob("*.*")), 5e6)


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
        sorts = {(32, 32): [(1e5, 67e-6), (3e5, 80e-6), (1e6, 86e-6), (1e7, 375e-6)]}
        most = ceilings.Ceilings("a GPU", 1, 1, 1, sorts)
        for size, time in sorts[ceilings.DEPTHS]:
            self.assertAlmostEqual(1e6 * most.sort_seconds(size, ceilings.DEPTHS), 1e6 * time)
        found = [most.sort_seconds(10**(4 + n / 10), ceilings.DEPTHS) for n in range(45)]
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
