# SPDX-License-Identifier: Apache-2.0
"""Where the numbers of tables come from, a folder of results for each kind of machine, and where tables go, blocks of
Markdown files: everything between these two lines.

<!-- table: NAME WORD... -->
<!-- end -->
"""
import inspect
import os
import re

from tables.results import InputError, Row, read, read_format

RESULTS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "results")
BEGIN = re.compile(r"<!-- table: (\S+)((?: \S+)*) -->")
END = "<!-- end -->"


class Source:
    """The results of the machines, each file read once."""

    def __init__(self, results=RESULTS):
        self.root, self.found = results, {}

    def path(self, machine, name):
        """Of a file in a machine's folder; InputError where it is not there."""
        path = os.path.join(self.root, machine, name)
        if not os.path.isfile(path):
            raise InputError(f"{path}: no such file; expected a MACHINE with a folder of results in {self.root}")
        return path

    def has(self, machine, name):
        return os.path.isfile(os.path.join(self.root, machine, name))

    def results(self, machine, name):
        """The Results of a file of `swiftgs bench`."""
        return self.once(read, self.path(machine, name))

    def rows(self, machine, name, form="swiftgs-bench"):
        """(member `machine` of a file, its rows), with any members."""
        found = self.once(lambda path: read_format(path, form), self.path(machine, name))
        return found["machine"], [Row(row) for row in found["rows"]]

    def once(self, reader, path):
        if path not in self.found:
            self.found[path] = reader(path)
        return self.found[path]


def backend(machine):
    """The backend that a machine's results are of; a folder of one's own may have its name."""
    return "cuda" if "gpu" in machine else machine if machine in ("cuda", "serial") else "cpu"


def device(machine, name):
    """What ran a backend, in words, as 'NVIDIA H200', from the member `machine` of a file. A host's files name its GPU
    too."""
    host = f"{machine.get('cpu', 'unknown')}, {machine.get('cores', '?')} cores"
    return str(name == "cuda" and machine.get("gpu") or host)


def machine_name(results):
    """The device that rendered, in words."""
    return device(results.machine, "cuda" if any(row.backend == "cuda" for row in results.rows) else "cpu")


def commit_of(machine):
    commit = str(machine.get("commit", "unknown"))
    return f"`{commit[:12]}`{' with changes' if commit.endswith('+') else ''}"


def render(name, words, tables, source):
    """What the table called `name` says for `words`."""
    if name not in tables:
        raise InputError(f"no table '{name}'; expected one of {', '.join(sorted(tables))}")
    try:
        inspect.signature(tables[name]).bind(source, *words)
    except TypeError:
        takes = [word for word in inspect.signature(tables[name]).parameters if word != "source"]
        raise InputError(f"table '{name}' {' '.join(words)}: expected {' '.join(takes).upper() or 'no word'}") from None
    return tables[name](source, *words).strip()


def updated(path, text, tables, source):
    """(`text` with its blocks written anew, [error]). A block that cannot be written stays as it is."""
    lines, made, errors, at = text.split("\n"), [], [], 0
    while at < len(lines):
        begin = BEGIN.fullmatch(lines[at].strip())
        made.append(lines[at])
        at += 1
        if not begin:
            continue
        end = next((n for n in range(at, len(lines)) if lines[n].strip() == END or BEGIN.fullmatch(lines[n].strip())),
                   len(lines))
        if end == len(lines) or lines[end].strip() != END:
            raise InputError(f"{path}:{at}: block '{begin[1]}' does not end; expected {END}")
        try:
            made += ["", *render(begin[1], begin[2].split(), tables, source).split("\n"), ""]
        except InputError as error:
            errors.append(f"{path}:{at}: {error}")
            made += lines[at:end]
        at = end
    return "\n".join(made), errors
