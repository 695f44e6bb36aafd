# SPDX-License-Identifier: Apache-2.0
"""Result files are what docs/schemas says of their format: those in benchmarks/results, and those that the
command-line tool writes, which SWIFTGS_TOOL names."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import synthetic

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCHEMAS = {path.name: json.loads(path.read_text(encoding="utf-8")) for path in (ROOT / "docs/schemas").glob("*.json")}
ANNOTATIONS = {"$schema", "title", "description", "$defs"}
TYPES = {"null": type(None), "boolean": bool, "string": str, "integer": int, "number": (int, float), "array": list,
         "object": dict}

RENDERER, SMALL = "serial/early/per-pixel/ellipse", "builtin:50 --scale 0.02"
COMMANDS = (
    "info builtin:50 --json {json}",
    "list --json {json}",
    f"render {SMALL} --views 0 --stats --renderer {RENDERER} --json {{json}}",
    f"check {SMALL} --views 0 --repeats 1 --renderers {RENDERER} --json {{json}}",
    f"bench builtin:50 --scales 0.05 --views 0 --min-frames 2 --max-frames 2 --renderers {RENDERER} --json {{json}}",
    f"prune {SMALL} --keep 0.5 --out small.ply --backend serial --json {{json}}",
    "convert small.ply small.splat --degree 1 --json {json}",
    f"stress --families needles --severity 100 --seeds 1 --renderers {RENDERER} --json {{json}}",
    f"stress --search 0.1 --families needles --renderers {RENDERER} --json {{json}}")


def is_of(value, name):
    return isinstance(value, TYPES[name]) and (name == "boolean" or not isinstance(value, bool))


def errors(value, schema, file, where="$"):
    """What is wrong with `value` by a schema in `file`, a line each; knows the keywords that docs/schemas uses."""
    members, items = (value if isinstance(value, kind) else kind() for kind in (dict, list))
    for keyword, said in schema.items():
        if keyword == "$ref":
            other, _, name = said.partition("#")
            yield from errors(value, resolved(other or file, name), other or file, where)
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
            for name in members.keys() - schema.get("properties", {}).keys():
                if said is False:
                    yield f"{where}.{name}: unknown"
                else:
                    yield from errors(members[name], said, file, f"{where}.{name}")
        elif keyword == "items":
            for index, item in enumerate(items):
                yield from errors(item, said, file, f"{where}[{index}]")
        elif keyword not in ANNOTATIONS:
            raise NotImplementedError(f"{file}: keyword {keyword}")


def resolved(file, pointer):
    schema = SCHEMAS[file]
    for name in pointer.split("/")[1:]:
        schema = schema[name]
    return schema


def errors_of(results):
    """Of a result file; without a format it is what describe_machine.sh prints."""
    if "format" not in results:
        return list(errors(results, {"$ref": "common.schema.json#/$defs/machine"}, ""))
    for file, schema in SCHEMAS.items():
        if schema["title"] == results["format"]:
            return list(errors(results, schema, file))
    return [f"$.format: {results['format']} has no schema"]


class Schemas(unittest.TestCase):
    def test_each_has_the_name_of_its_format(self):
        for file, schema in SCHEMAS.items():
            if file != "common.schema.json":
                self.assertEqual(f"swiftgs-{file}", f"{schema['title']}.schema.json")
                self.assertEqual(schema["properties"]["format"]["const"], schema["title"])


class Results(unittest.TestCase):
    def test_every_result_file_fits_its_schema(self):
        files = sorted((ROOT / "benchmarks/results").glob("*/*.json"))
        self.assertGreater(len(files), 30)
        for file in files:
            with self.subTest(file=str(file.relative_to(ROOT))):
                self.assertEqual(errors_of(json.loads(file.read_text(encoding="utf-8")))[:5], [])

    @unittest.skipUnless("SWIFTGS_TOOL" in os.environ, "SWIFTGS_TOOL names no swiftgs")
    def test_what_every_command_writes_fits_its_schema(self):
        with tempfile.TemporaryDirectory() as place:
            for command in COMMANDS:
                words = command.format(json="results.json").split()
                with self.subTest(command=command):
                    subprocess.run([os.environ["SWIFTGS_TOOL"], *words], cwd=place, check=True, capture_output=True)
                    results = pathlib.Path(place, "results.json")
                    self.assertEqual(errors_of(json.loads(results.read_text(encoding="utf-8"))), [])
                    results.unlink()


class Errors(unittest.TestCase):
    def test_a_keyword_that_nothing_checks_is_refused(self):
        with self.assertRaises(NotImplementedError):
            list(errors(1, {"maximum": 2}, ""))

    def setUp(self):
        self.row = synthetic.row({stage: synthetic.interval([1, 2, 3])
                                  for stage in ("project", "sort", "raster", "total", "wall")})
        self.results = synthetic.file_of([self.row], system="a system")

    def test_what_is_missing_mistyped_or_unknown_is_named(self):
        for change, message in (({"frames": "15"}, "frames: expected integer, found '15'"),
                                ({"frames": True}, "frames: expected integer, found 'True'"),
                                ({"frames": 0}, "frames: expected 1 at least, found 0"),
                                ({"psnr_db": "loud"}, "psnr_db: expected ['number', 'null'], found 'loud'"),
                                ({"conventions": "ours"}, "conventions: expected ['gsplat', 'inria'], found 'ours'"),
                                ({"ms": {**self.row["ms"], "wall": None}}, "ms.wall: expected object, found 'None'"),
                                ({"colour": 1}, "colour: unknown")):
            with self.subTest(message=message):
                changed = {**self.results, "rows": [{**self.row, **change}]}
                self.assertEqual(errors_of(changed), [f"$.rows[0].{message}"])
        del self.row["visible"], self.results["command"]
        self.assertEqual(sorted(errors_of(self.results)), ["$.command: missing", "$.rows[0].visible: missing"])

    def test_a_format_without_a_schema_is_refused(self):
        for name in ("swiftgs-other", "swiftgs-common"):
            self.assertEqual(errors_of({"format": name}), [f"$.format: {name} has no schema"])


if __name__ == "__main__":
    unittest.main()
