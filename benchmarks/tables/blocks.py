# SPDX-License-Identifier: Apache-2.0
"""Blocks of Markdown files that a function writes: everything between these two lines.

<!-- table: NAME WORD... -->
<!-- end -->
"""
import inspect
import re

from tables.results import InputError

BEGIN = re.compile(r"<!-- table: (\S+)((?: \S+)*) -->")
END = "<!-- end -->"


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
