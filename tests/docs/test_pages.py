# SPDX-License-Identifier: Apache-2.0
"""Pages state no decibel that nothing checks, and have no long lines.

A number of decibels stands in a table that benchmarks/update_tables.py writes, or in a paragraph that names the test
which asserts it: `<!-- tested: tests/FILE -->`, where FILE holds the number.
"""
import pathlib
import re
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))
sys.dont_write_bytecode = True

from tables import blocks  # noqa: E402

WORDS = ("half", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
         "tens", "dozens")
NUMBER = rf"(?:\d+(?:\.\d+)?|\b(?:{'|'.join(WORDS)})\b(?: of)?)"
DECIBELS = re.compile(rf"({NUMBER}(?:\s*(?:to|and|or|-|–)\s*{NUMBER})*)\s*(?:dB|[Dd]ecibels?)\b")
TESTED = re.compile(r"<!-- tested: (\S+) -->")
TESTS = ("tests/", "benchmarks/tests/")
QUOTED = re.compile(r"^<!-- lines of (\S+) -->\n```\w*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COLUMNS = 120


def pages(root):
    found = [*root.glob("*.md"), *(page for folder in ("docs", "backends", "benchmarks", "examples", "tests")
                                   for page in root.glob(f"{folder}/**/*.md"))]
    return sorted(found)


def own_lines(text):
    """(number, line) of what people wrote: without the tables that a program writes."""
    inside = False
    for number, line in enumerate(text.split("\n"), 1):
        inside = inside and line.strip() != blocks.END or blocks.BEGIN.fullmatch(line.strip()) is not None
        if not inside:
            yield number, line


def paragraphs(text):
    """(number of the first line, lines joined); a table is one too."""
    start, lines, last = 1, [], 0
    for number, line in [*own_lines(text), (0, "")]:
        if lines and (not line.strip() or number != last + 1):
            yield start, " ".join(lines)
            lines = []
        if line.strip():
            start = start if lines else number
            lines.append(line.strip())
        last = number


def holds(text, number):
    """Whether a test's text has the number, not as a part of another."""
    return re.search(rf"(?<![\w.]){re.escape(number)}(?:\.0*)?(?![\w.])", text) is not None


def untested(root, page):
    """What is wrong with the decibels of a page, a line each."""
    where, wrong = page.relative_to(root), []
    for line, paragraph in paragraphs(page.read_text(encoding="utf-8")):
        names, texts = TESTED.findall(paragraph), []
        for name in names:
            if not name.startswith(TESTS) or not (root / name).is_file():
                wrong.append(f"{where}:{line}: '{name}' is no test; expected a file in {' or '.join(TESTS)}")
            else:
                texts.append((root / name).read_text(encoding="utf-8"))
        found = DECIBELS.findall(paragraph)
        if names and not found:
            wrong.append(f"{where}:{line}: names a test for no number of dB")
        for number in (number for group in found for number in re.findall(NUMBER, group)):
            if not names:
                wrong.append(f"{where}:{line}: '{number} dB'; expected a generated table or <!-- tested: FILE -->")
            elif not any(holds(text, number) for text in texts):
                wrong.append(f"{where}:{line}: '{number} dB' is not in {', '.join(names)}")
    return wrong


def long_lines(root, page):
    """Lines of prose that are too long; tables, code, and what cannot be broken are not."""
    wrong, code = [], False
    for number, line in own_lines(page.read_text(encoding="utf-8")):
        code ^= line.startswith("```")
        if len(line) > COLUMNS and not code and not line.startswith("|") and " " in line.strip()[:COLUMNS]:
            wrong.append(f"{page.relative_to(root)}:{number}: {len(line)} columns; expected {COLUMNS} at most")
    return wrong


def misquoted(root, page):
    """Quoted lines that do not stand in their file, in this order."""
    wrong = []
    for name, quoted in QUOTED.findall(page.read_text(encoding="utf-8")):
        lines = iter(line.strip() for line in (root / name).read_text(encoding="utf-8").split("\n"))
        missing = [line for line in quoted.split("\n") if line.strip() and line.strip() not in lines]
        wrong += [f"{page.relative_to(root)}: '{line}' is not in {name} behind those before it" for line in missing[:1]]
    return wrong


class Pages(unittest.TestCase):
    def test_every_decibel_is_generated_or_tested(self):
        self.assertGreater(len(pages(ROOT)), 10)
        self.assertEqual("\n".join(line for page in pages(ROOT) for line in untested(ROOT, page)), "")

    def test_quoted_lines_are_those_of_their_files(self):
        self.assertGreater(sum(len(QUOTED.findall(page.read_text(encoding="utf-8"))) for page in pages(ROOT)), 0)
        self.assertEqual("\n".join(line for page in pages(ROOT) for line in misquoted(ROOT, page)), "")

    def test_lines_of_prose_fit(self):
        self.assertEqual("\n".join(line for page in pages(ROOT) for line in long_lines(ROOT, page)), "")


class Checks(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "tests").mkdir()
        (self.root / "tests/some_test.cpp").write_text("CHECK(floor >= 95);\nCHECK(x > 1.5);\n", encoding="utf-8")

    def wrong(self, text, check=untested):
        page = self.root / "page.md"
        page.write_text(text, encoding="utf-8")
        return check(self.root, page)

    def test_all_that_is_wrong_is_found_and_nothing_else(self):
        tested = "<!-- tested: tests/some_test.cpp -->"
        block = "<!-- table: steps gpu -->\n\n| 95 dB |\n\n<!-- end -->\n"
        quote = "Text.\n\n<!-- lines of tests/some_test.cpp -->\n```cpp\n{}\n```\n"
        words = 30 * "word "
        for check, text, count in (
                (untested, "It has 95 dB.", 1), (untested, "It has 95 or more, at\n95 dB.", 1),
                (untested, "| half | 58 to 78 dB |", 2), (untested, "95.5dB", 1), (untested, "10 decibels", 1),
                (untested, "worse by three to twelve decibels", 2), (untested, "- tens of dB\n", 1),
                (untested, f"At least\n95 dB. {tested}\n\nNo number of dB.", 0),
                (untested, f"1.5 to 95 dB {tested}", 0), (untested, f"5 dB {tested}", 1),
                (untested, f"95 dB\n\nNext. {tested}", 2), (untested, block, 0),
                (untested, f"At 95 dB\n{block}and 94 dB", 2),
                (misquoted, quote.format("CHECK(floor >= 95);\n\n  CHECK(x > 1.5);"), 0),
                (misquoted, quote.format("CHECK(x > 1.5);"), 0), (misquoted, quote.format("CHECK(floor >= 9);"), 1),
                (misquoted, quote.format("CHECK(x > 1.5);\nCHECK(floor >= 95);"), 1),
                (long_lines, f"| {words} |", 0), (long_lines, f"```\n{words}\n```", 0), (long_lines, 130 * "w", 0),
                (long_lines, f"<!-- table: a -->\n{words}\n<!-- end -->", 0),
                (long_lines, f"```\n{words}\n```\n{words}", 1)):
            with self.subTest(check=check.__name__, text=text):
                self.assertEqual(len(self.wrong(text, check)), count)

    def test_what_is_wrong_is_named_with_its_place(self):
        self.assertEqual(self.wrong("First.\n\nAt most\n95 dB."),
                         ["page.md:3: '95 dB'; expected a generated table or <!-- tested: FILE -->"])
        self.assertEqual(self.wrong("94 dB <!-- tested: tests/some_test.cpp -->"),
                         ["page.md:1: '94 dB' is not in tests/some_test.cpp"])
        for name in ("tests/other_test.cpp", "page.md", "tests"):
            self.assertIn(f"'{name}' is no test", self.wrong(f"95 dB <!-- tested: {name} -->")[0])
        self.assertEqual(self.wrong(f"short\n{30 * 'word '}", long_lines),
                         ["page.md:2: 150 columns; expected 120 at most"])


if __name__ == "__main__":
    unittest.main()
