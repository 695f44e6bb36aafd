#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""usage: find_slowdown.py COMPARE FOLDER MEASURE

Asks COMPARE what moved from before.json in FOLDER to after.json, which rasterizes a fifth slower, and to same.json, which
is the same renderer measured again. Of the first it must be rasterization that is slower, with what holds it, and
nothing else, and of the second nothing at all. Stages of less than a fiftieth of the frame are not judged in the first:
the two renderers are compiled apart, and where their loops lie moves so short a stage by some per cent. COMPARE names
what moved by 2.6 standard errors, and of the stages that did not change chance moves one so far now and then, other
programs more often. So MEASURE may write other files twice, and the test fails by what is wrong in all three. Exit code
77 where the machine was too busy to tell 20 %.
"""
import math
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "benchmarks"))

from tables.comparison import standard_error  # noqa: E402
from tables.results import STAGES, read  # noqa: E402

SLOWER = {"slower", "worse"}  # COMPARE's words for means and for rows
# What COMPARE and chance leave of 20 %: 2.6 standard errors for a mean to be named, and 2 for it to come out less.
NOISE = math.log(1.2) / (2.6 + 2)
NOT_FOUND = "the slower rasterization was not found"


def compared(compare, before, after):
    """(exit code, {(stage, word that says how it moved)})"""
    run = subprocess.run([sys.executable, "-B", compare, before, after], capture_output=True, text=True, check=False)
    print(run.stdout, run.stderr)
    named = set()
    for line in run.stdout.splitlines():
        cells = [cell.strip() for cell in line.strip("| ").split(" | ")]
        named |= {(cell, cells[n + 1]) for n, cell in enumerate(cells[:-1]) if cell in STAGES}
    return run.returncode, named


def noise(*files):
    """Standard error of the ratio of the rasterization's medians."""
    return math.hypot(*(standard_error(read(name).rows[0].ms["raster"]) for name in files))


def judged(stage, name):
    """Whether the stage is long enough in the file's frames."""
    ms = read(name).rows[0].ms
    return ms[stage].median >= ms["total"].median / 50


def wrong(compare, folder):
    """What is wrong with what COMPARE says, each a line."""
    code, named = compared(compare, f"{folder}/before.json", f"{folder}/same.json")
    found = {f"expected no stage for the same renderer; named was {each}" for each in named}
    if code != 0 and not named:
        found.add(f"expected exit code 0 for the same renderer; got {code}")
    code, named = compared(compare, f"{folder}/before.json", f"{folder}/after.json")
    if "raster" not in {stage for stage, _ in named}:
        return found | {NOT_FOUND}
    if code != 1:
        found.add(f"expected exit code 1, something is slower; got {code}")
    return found | {f"expected nothing but raster, total and wall, slower; named was {(stage, word)}"
                    for stage, word in named if judged(stage, f"{folder}/before.json")
                    and (stage in ("project", "sort") or word not in SLOWER)}


def main(compare, folder, measure):
    least, always = math.inf, None
    for left in (2, 1, 0):
        found = wrong(compare, folder)
        print(*sorted(found), sep="\n")
        always = found if always is None else always & found
        if not always:
            return
        least = min(least, noise(f"{folder}/before.json", f"{folder}/after.json"))
        if left:
            subprocess.run([measure, folder], check=True)
    if NOT_FOUND in always and least > NOISE:
        print(f"skipped: a standard error of {100 * least:.1f} % is too much to tell 20 %; expected a quiet machine")
        sys.exit(77)
    sys.exit("three measurements were judged wrongly")


if __name__ == "__main__":
    main(*sys.argv[1:])
