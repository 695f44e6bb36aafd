# SPDX-License-Identifier: Apache-2.0
"""What single stages of the arithmetic err by: the largest errors that `ulps_table` found by search."""
from tables.markdown import table
from tables.results import InputError, check_rows
from tables.source import processor

# What the page shows of them.
SHOWN = ("mean", "depth", "determinant without blur", "`l0`", "`l1`", "cutoff", "colour of degree 3", "`Exp2`",
         "alpha `axis-shared-threshold-float-cholesky`", "transmittance after 10000 unequal layers")


def rows_of(source, machine):
    """(path, {(stage, yardstick): {target: ulps}}, the machine in words)"""
    path = source.path(machine, "ulps.json")
    found = source.json(machine, "ulps.json", "swiftgs-ulps", machine=dict, rows=list)
    check_rows(path, found["rows"], texts=("stage", "target", "yardstick"), numbers=("ulps",))
    stages = {}
    for row in found["rows"]:
        stages.setdefault((row["stage"], row["yardstick"]), {})[row["target"]] = row["ulps"]
    if not stages:
        raise InputError(f"{path}: no rows; expected what ulps_table --json prints")
    return path, stages, processor(found["machine"])


def ulps(source, machine):
    """The stages of SHOWN, each on the target that errs most."""
    path, stages, words = rows_of(source, machine)
    missing = [name for name in SHOWN if name not in {stage for stage, _ in stages}]
    if missing:
        raise InputError(f"{path}: no row of {missing[0]}; expected one of each stage")
    rows = []
    for name in SHOWN:
        for (stage, yardstick), found in stages.items():
            if stage == name:
                worst = max(found, key=found.get)
                rows.append([stage, yardstick, worst, f"{found[worst]:.2f}"])
    return f"{words}:\n\n" + table(["stage", "measured in", "worst on", "error"], rows, words=3)


TABLES = {"ulps": ulps}
