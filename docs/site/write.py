# SPDX-License-Identifier: Apache-2.0
"""write.py FOLDER SOURCES writes what doxygen reads for the documentation site, and prints its files in order.

Pages and their headings get names, and links between pages become doxygen's, which checks them; links to other files
lead below the address SOURCES. Headers join the groups of groups.dox. `reference` makes the pages that are no files.
"""
import fnmatch
import os
import pathlib
import re
import shutil
import sys

import reference

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINK = re.compile(r"(?<!!)\[(?P<text>[^][]+)\]\((?P<target>[^()#\s]*)(?:#(?P<fragment>[^()\s]*))?\)")
SPAN = re.compile(r"(`[^`]*`)|(?<![*\w])\*(?=[^\s*])((?:`[^`]*`|[^*`])+)\*(?!\*)")
CODE = re.compile(r"(^```.*?^```$)", re.M | re.S)
PAGES = [str(path.relative_to(ROOT)) for pattern in ("*.md", "docs/*.md", "backends/README.md", "benchmarks/README.md")
         for path in sorted(ROOT.glob(pattern))]
INCLUDES = ("include", "backends/cpu/include", "backends/cuda/include", "backends/vulkan/include", "backends/bridges/gl/include",
            "backends/bridges/cuda_vulkan/include", "backends/bridges/mpi/include", "backends/bridges/mpi/cuda/include")


def name_of(page):
    """docs/cuda.md is `cuda`, backends/README.md is `backends_readme`, and README.md is the first page."""
    return "index" if page == "README.md" else re.sub(r"^docs/|\.md$", "", page).lower().replace("/", "_")


def anchor(page, heading):
    """The name of a heading, by its text or by the fragment of links to it."""
    return f"{name_of(page)}_{re.sub('[^a-z0-9]', '_', re.sub(r'[^a-z0-9_ -]', '', heading.lower()))}"


def span(match):
    """Code with a quote, and emphasis of several lines or of code, as doxygen knows them."""
    code, emphasised = match.groups()
    return f"`{code}`" if code and "'" in code else code or f"<em>{emphasised}</em>"


class Page:
    def __init__(self, path, sources):
        self.path, self.sources, self.seen = path, sources, {"index"}

    def heading(self, match):
        marks, text = match.groups()
        name = anchor(self.path, text) if len(marks) > 1 else name_of(self.path)
        if name in self.seen:
            return match[0]
        self.seen.add(name)
        return f"{marks} {text.replace('`', '')} {{#{name}}}"

    def link(self, match):
        text, target, fragment = match["text"], match["target"], match["fragment"]
        if re.match("[a-z]+:", target):
            return match[0]
        file = os.path.normpath(os.path.join(os.path.dirname(self.path), target)) if target else self.path
        if file not in PAGES:
            return f'<a href="{self.sources}/{file}{"#" + fragment if fragment else ""}">{text}</a>'
        text = " ".join(text.replace("`", "").split())  # doxygen reads it as plain text, on one line
        return f"[{text}](@ref {anchor(file, fragment) if fragment else name_of(file)})"

    def written(self):
        parts = CODE.split((ROOT / self.path).read_text(encoding="utf-8"))
        for index in range(0, len(parts), 2):  # outside of blocks of code
            text = re.sub(r"^(#+) (.*)$", self.heading, LINK.sub(self.link, parts[index]), flags=re.M)
            parts[index] = SPAN.sub(span, text)
        more = reference.PART_OF.get(self.path)
        return "".join(parts) + (f"\n@subpage {more}\n" if more else "")


def in_order():
    """Pages as tables of the README name them, then the others."""
    rows = "\n".join(line for line in (ROOT / "README.md").read_text(encoding="utf-8").split("\n") if line[:1] == "|")
    named = [match["target"] for match in LINK.finditer(rows) if match["target"] in PAGES]
    return dict.fromkeys(["README.md", *named, *PAGES])


def group_of(header, groups):
    """The first group whose line names the header."""
    for group in groups.split("@defgroup ")[1:]:
        patterns = re.findall("`(.*?)`", group.partition("Headers: ")[2])
        if any(fnmatch.fnmatch(header, pattern) for pattern in patterns):
            return group.split()[0]
    raise SystemExit(f"{header}: expected a group in docs/site/groups.dox")


def grouped(header, group):
    """The declarations of a header in their group: those of its namespace, or in C those below its includes."""
    begin, end, text = f"/** @addtogroup {group}\n@{{ */", "/** @} */", header.read_text(encoding="utf-8")
    if header.suffix == ".h":
        text = re.sub(r'(?<=^extern "C" \{\n#endif\n)', begin, text, flags=re.M)
        return re.sub(r"^\n(?=#ifdef __cplusplus\n\})", f"{end}\n", text, flags=re.M)
    text = re.sub(r"^(namespace swiftgs.*\{)\n", rf"\1 {begin}", text, flags=re.M)
    return re.sub(r"^(?=\}  // namespace swiftgs)", end, text, flags=re.M)


def main(folder, sources):
    folder = pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    groups = (ROOT / "docs/site/groups.dox").read_text(encoding="utf-8")
    texts = {page: Page(page, sources).written() for page in in_order()} | reference.pages() | {"groups.dox": groups}
    for include in INCLUDES:
        for header in sorted((ROOT / include).glob("**/*.*")):
            name = str(header.relative_to(ROOT / include))
            texts[f"include/{name}"] = grouped(header, group_of(name.removeprefix("swiftgs/"), groups))
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
        print(f'"{folder / name}"')


if __name__ == "__main__":
    main(*sys.argv[1:])
