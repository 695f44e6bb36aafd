#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the tables of Markdown files anew from the files in benchmarks/results.

usage: benchmarks/update_tables.py [--check] [--results FOLDER] FILE.md...

A table is everything between the lines `<!-- table: NAME WORD... -->` and `<!-- end -->`; modules of benchmarks/tables
make them. A machine's word is its folder in benchmarks/results. --check changes nothing and prints what would change.
Exit code 0, with --check 1 where something would change, 2 where a table cannot be made: its block stays as it is.
"""
import argparse
import difflib
import sys

sys.dont_write_bytecode = True

from tables import blocks, ceilings, conformance, files, growth, listings, matrix, paper, rivals, stability  # noqa: E402
from tables.blocks import RESULTS, Source  # noqa: E402
from tables.results import InputError  # noqa: E402

MODULES = (ceilings, conformance, files, growth, listings, matrix, paper, rivals, stability)
TABLES = {name: function for module in MODULES for name, function in module.TABLES.items()}


def update(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE.md")
    parser.add_argument("--check", action="store_true", help="say what would change, and change nothing")
    parser.add_argument("--results", default=RESULTS, help="the folder of the machines' folders (benchmarks/results)")
    options = parser.parse_args(arguments)
    source, changed, failed = Source(options.results), False, False
    for path in options.files:
        try:
            with open(path, encoding="utf-8") as file:
                before = file.read()
            after, errors = blocks.updated(path, before, TABLES, source)
        except OSError as error:
            raise InputError(f"{path}: {error.strerror}; expected a Markdown file") from None
        for error in errors:
            print(f"update_tables: {error}", file=sys.stderr)
        failed |= bool(errors)
        changed |= after != before
        if options.check:
            sys.stdout.writelines(difflib.unified_diff(before.splitlines(True), after.splitlines(True), path,
                                                       f"{path} from the results"))
        elif after != before:
            with open(path, "w", encoding="utf-8") as file:
                file.write(after)
    return 2 if failed else 1 if options.check and changed else 0


def main(arguments=None):
    """The exit code: 0, 1 if `--check` found a difference, 2 for what cannot be made."""
    try:
        return update(arguments)
    except InputError as error:
        print(f"update_tables: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
