# SPDX-License-Identifier: Apache-2.0
"""What `swiftgs` writes fits docs/schemas, your_machine.sh makes its tables of what it has measured, `compare` names what
is slower, and no script deletes folders. SWIFTGS_TOOL names the program, SWIFTGS_BUILD the folder of its build; without them exit code 77."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCHEMAS = {path.name: json.loads(path.read_text(encoding="utf-8")) for path in (ROOT / "docs/schemas").glob("*.json")}
ANNOTATIONS = {"$schema", "title", "description", "$defs"}
TYPES = {"null": type(None), "boolean": bool, "string": str, "integer": int, "number": (int, float), "array": list,
         "object": dict}
RENDERER, SMALL = "serial/early/per-pixel/ellipse", "builtin:50 --scale 0.02"
COMMANDS = (
    "info builtin:50", "list", f"render {SMALL} --views 0 --stats --renderer {RENDERER}",
    f"check {SMALL} --views 0 --repeats 1 --renderers {RENDERER}",
    f"bench builtin:50 --scales 0.05 --views 0 --min-frames 2 --max-frames 2 --renderers {RENDERER}",
    f"prune {SMALL} --keep 0.5 --out small.ply --backend serial", "convert small.ply small.splat --degree 1")


def is_of(value, name):
    return isinstance(value, TYPES[name]) and (name == "boolean" or not isinstance(value, bool))


def errors(value, schema, file, where="$"):
    """What is wrong with `value` by a schema in `file`, a line each; knows the keywords that docs/schemas uses."""
    members, items = (value if isinstance(value, kind) else kind() for kind in (dict, list))
    for keyword, said in schema.items():
        if keyword == "$ref":
            other, _, pointer = said.partition("#")
            found = SCHEMAS[other or file]
            for name in pointer.split("/")[1:]:
                found = found[name]
            yield from errors(value, found, other or file, where)
        elif keyword == "type":
            if not any(is_of(value, name) for name in ([said] if isinstance(said, str) else said)):
                yield f"{where}: expected {said}, found {str(value)[:40]!r}"
                return
        elif keyword in ("const", "enum"):
            if value not in (said if keyword == "enum" else [said]):
                yield f"{where}: expected {said}, found {str(value)[:40]!r}"
        elif keyword == "minimum":
            if is_of(value, "number") and value < said:
                yield f"{where}: expected {said} at least, found {value}"
        elif keyword == "required":
            yield from (f"{where}.{name}: missing" for name in said if name not in members)
        elif keyword == "properties":
            for name in filter(members.__contains__, said):
                yield from errors(members[name], said[name], file, f"{where}.{name}")
        elif keyword == "additionalProperties":
            yield from (f"{where}.{name}: unknown" for name in members.keys() - schema.get("properties", {}).keys())
        elif keyword == "items":
            for index, item in enumerate(items):
                yield from errors(item, said, file, f"{where}[{index}]")
        elif keyword not in ANNOTATIONS:
            raise NotImplementedError(f"{file}: keyword {keyword}")


class Benchmarks(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.place = pathlib.Path(folder.name)

    def test_what_every_command_writes_fits_its_schema(self):
        for command in COMMANDS:
            words = command.split()
            with self.subTest(command=command):
                subprocess.run([os.environ["SWIFTGS_TOOL"], *words, "--json", "results.json"], cwd=self.place,
                               check=True, capture_output=True)
                results = json.loads((self.place / "results.json").read_text(encoding="utf-8"))
                self.assertEqual(results["format"], f"swiftgs-{words[0]}")
                file = f"{words[0]}.schema.json"
                self.assertEqual(list(errors(results, SCHEMAS[file], file)), [])
                command_of = results.pop("command")  # what is missing is found
                self.assertEqual(list(errors(results, SCHEMAS[file], file)), ["$.command: missing"], command_of)

    def test_one_command_has_the_front_and_the_papers_tables_of_a_scene(self):
        out = self.place / "out"
        ran = subprocess.run([str(ROOT / "benchmarks/your_machine.sh"), str(out), "builtin:200", "--scales", "0.05",
                              "--views", "0", "--min-frames", "6", "--max-frames", "6"],
                             check=False, capture_output=True, text=True)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        page = (out / "README.md").read_text(encoding="utf-8")
        for table in ("pareto", "steps", "accuracy", "vanilla", "pruned", "paper-scenes", "paper-steps",
                      "paper-accuracy", "paper-pruned"):
            self.assertRegex(page, rf"<!-- table: {table}( \w+)? -->\n\n[^<]+\| --- \|[^<]+<!-- end -->")

    def test_compare_names_a_stage_that_is_slower_and_nothing_of_equal_files(self):
        before, after = ROOT / "benchmarks/results/gpu/lenses.json", self.place / "after.json"
        results = json.loads(before.read_text(encoding="utf-8"))
        for row in results["rows"]:
            longer = 0.2 * row["ms"]["sort"]["median"]
            for stage in ("sort", "total", "wall"):
                row["ms"][stage] = {name: ms + longer for name, ms in row["ms"][stage].items()}
        after.write_text(json.dumps(results), encoding="utf-8")
        for other, code, said in ((before, 0, set()), (after, 1, {"sort"})):
            ran = subprocess.run([sys.executable, str(ROOT / "benchmarks/compare"), str(before), str(other)], check=False,
                                 capture_output=True, text=True)
            named = {stage for stage in ("project", "sort", "raster", "total", "wall") if f"| {stage} |" in ran.stdout}
            self.assertEqual((ran.returncode, named), (code, said), ran.stdout + ran.stderr)

    def test_stored_results_stay_small(self):
        stored = (ROOT / "benchmarks/results").rglob("*")
        self.assertLess(sum(path.stat().st_size for path in stored if path.is_file()), 3_000_000)

    def test_no_script_deletes_folders_with_what_is_in_them(self):
        """But one: systems to test packages in, whose names stand in the line before."""
        allowed = '  rm -rf --one-file-system "$source/build/release_check/roots/$1"'
        scripts = [path for path in ROOT.rglob("*.sh") if "build" not in path.relative_to(ROOT).parts[:1]]
        self.assertGreater(len(scripts), 5)
        for script in scripts:
            for line in script.read_text(encoding="utf-8").splitlines():
                if (script.name, line) != ("release_check.sh", allowed):
                    self.assertNotRegex(line, r"\brm +(-\S+ +)*-(\w*[rR]|-recursive)|\bfind\b.*-delete|^\s*trap\b",
                                        script)


if __name__ == "__main__":
    if not os.path.exists(os.environ.get("SWIFTGS_TOOL", "")):
        sys.exit(77)
    unittest.main()
