#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Injects each defect of table.py and named.py and runs the tests that must notice it: the program that the defect
names, or the stability tests of the backend that has it.

    run.py BUILD [--quick] [--only WORDS] [--jobs N] [--compiler 'ccache c++'] [--include FOLDER]...
    run.py BUILD --build-only FOLDER [--only WORDS] [--nvcc nvcc] [--architecture 90]
    run.py --run FOLDER [--only WORDS] [--jobs N]

Works in the folder BUILD and leaves the sources alone: a mutant's file lies in a folder that the compiler searches
first, or in a copy of the project. Reports which defects the tests noticed; exits with 1 where one went unnoticed or
did not compile.

The first form tries the defects of the host's backends. Those of the cuda backend need nvcc, and then a GPU: the second
form builds them on any machine with nvcc, the third runs what lies in FOLDER on a machine with a GPU.
"""
import argparse
import itertools
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
from common import MUTANTS, Failed, chosen, mutated, report  # noqa: E402
from cuda import build_cuda, run_cuda  # noqa: E402
from host import Tests  # noqa: E402
from programs import Programs  # noqa: E402


def check_table():
    """Every mutant's texts must be in the sources, whichever are tried."""
    errors = []
    for mutant in MUTANTS:
        try:
            mutated(mutant)
        except Failed as error:
            errors.append(f"{mutant.name}: {error}")
    if errors:
        raise SystemExit("mutants: update table.py or named.py\n" + "\n".join(errors))


def run_host(options):
    begun = time.time()
    mutants, tests, programs = chosen(options, False), Tests(options), Programs(options)
    own = [mutant for mutant in mutants if not mutant.test]
    named = [mutant for mutant in mutants if mutant.test]
    try:
        if own:
            tests.prepare({mutant.backend() for mutant in own})
        if named:
            programs.prepare({mutant.test for mutant in named})
    except Failed as error:
        raise SystemExit(f"mutants: the tests do not compile without a defect\n{error}")
    with ThreadPoolExecutor(options.jobs) as pool:
        outcomes = itertools.chain(pool.map(tests.try_mutant, own), map(programs.try_mutant, named))
        return report(own + named, outcomes, begun)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?")
    parser.add_argument("--build-only", metavar="FOLDER", help="build the mutants of the cuda backend into FOLDER")
    parser.add_argument("--run", metavar="FOLDER", help="run what --build-only left there")
    parser.add_argument("--nvcc", default="nvcc")
    parser.add_argument("--architecture", default="90", help="compute capability of the GPU, without its point")
    parser.add_argument("--quick", action="store_true", help="the selection that ctest runs")
    parser.add_argument("--only", default="", metavar="WORDS", help="mutants whose name begins so")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--compiler", default=os.environ.get("CXX", "c++"))
    parser.add_argument("--include", action="append", default=["/usr/include/eigen3"], metavar="FOLDER")
    parser.add_argument("--keep", action="store_true", help="keep the programs of mutants")
    options = parser.parse_args()

    if options.run:
        sys.exit(not run_cuda(options))
    if not options.build:
        parser.error("expected the folder BUILD")
    check_table()
    sys.exit(not (build_cuda(options) if options.build_only else run_host(options)))


if __name__ == "__main__":
    main()
