# SPDX-License-Identifier: Apache-2.0
"""What pages link to is there, what they quote is what is built, and sources name their licence.

A block of code behind a line `<!-- FILE -->` is that file without its licence line; behind `<!-- lines of FILE -->` its
lines stand in that file, in this order.
"""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("docs", "backends", "benchmarks", "examples", "tests")
PAGES = {page: page.read_text(encoding="utf-8")
         for page in [*ROOT.glob("*.md"), *(page for folder in FOLDERS for page in (ROOT / folder).rglob("*.md"))]}
SOURCES = (".c", ".cmake", ".cpp", ".css", ".cu", ".cuh", ".dox", ".h", ".hpp", ".html", ".in", ".inc", ".js", ".map",
           ".py", ".sh", ".toml")
LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")
QUOTED = re.compile(r"^<!-- (lines of )?([\w/]+\.\w+) -->\n```\w*\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def lines_of(text):
    return [line.strip() for line in text.split("\n") if line.strip()]


class Pages(unittest.TestCase):
    def test_links_lead_somewhere(self):
        links = [(page, link) for page, text in PAGES.items() for link in LINK.findall(text)
                 if not re.match("[a-z]+:", link)]
        self.assertGreater(len(links), 100)
        self.assertEqual([f"{page}: {link}" for page, link in links if not (page.parent / link).exists()], [])

    def test_quoted_programs_are_those_that_are_built(self):
        found = [(page, *quote) for page, text in PAGES.items() for quote in QUOTED.findall(text)]
        self.assertEqual({bool(some) for _, some, _, _ in found}, {False, True})
        for page, some, name, quoted in found:
            with self.subTest(page=page, file=name):
                built = (ROOT / name).read_text(encoding="utf-8")
                if some:
                    rest = iter(lines_of(built))
                    self.assertEqual([line for line in lines_of(quoted) if line not in rest], [])
                else:
                    self.assertEqual(quoted, re.sub(r"\A// SPDX.*\n+", "", built))

    def test_the_page_of_formats_has_the_names_of_all(self):
        rows = re.compile(r"SceneFormat \w+_format\{.*?\.names = \{(.*?)\}", re.DOTALL)
        names = [name for path in (ROOT / "backends/parts/io").rglob("*.cpp")
                 for row in rows.findall(path.read_text(encoding="utf-8")) for name in re.findall('"(.*?)"', row)]
        self.assertGreater(len(names), 8)
        page = PAGES[ROOT / "docs/formats.md"]
        self.assertEqual([name for name in names if f"`{name}`" not in page], [])

    def test_every_source_file_names_its_licence(self):
        """In its first lines, behind what a program or a browser wants to read first."""
        folders = (".ci", "backends", "benchmarks", "cmake", "docs", "examples", "include", "tests")
        files = [path for folder in folders for path in (ROOT / folder).rglob("*")] + list(ROOT.iterdir())
        sources = [path for path in files if path.is_file() and
                   (path.suffix in SOURCES or path.name in ("CMakeLists.txt", "packages.txt", "run"))]
        self.assertGreater(len(sources), 500)
        self.assertEqual([str(path) for path in sources if "SPDX-License-Identifier: Apache-2.0" not in
                          "".join(path.read_text(encoding="utf-8").splitlines(keepends=True)[:3])], [])


if __name__ == "__main__":
    unittest.main()
